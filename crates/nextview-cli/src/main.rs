//! The program `nextview`.

fn main() {}
