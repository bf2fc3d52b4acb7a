//! No test: prints what the tests before it have skipped. It has no harness, which would hide that.

fn main() {
    print!("{}", nextview_checks::take_skipped());
}
