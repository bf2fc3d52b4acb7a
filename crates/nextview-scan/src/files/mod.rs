//! Reading and writing files. Only regular files of bounded size are read. Files are written as a whole or
//! not at all, and never replace protected files.

mod csv;
mod keep;
mod numbered;
mod place;
mod read;
mod results;
mod write;

pub use csv::csv_field;
pub use keep::{Overwrite, check_name, is_within};
pub use numbered::numbered;
pub(crate) use place::{PathTarget, create_folder, name_new, path_target, sync_folder};
pub use read::{open, read, read_text};
pub use results::{ResultFolder, remove_unfinished};
pub use write::{NewFile, unfinished, write};
