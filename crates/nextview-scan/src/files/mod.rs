//! Files. Those that are read are regular and of bounded size; those that are written appear as a whole, and
//! never replace protected files.

mod keep;
mod numbered;
mod place;
mod read;
mod results;
mod write;

pub use keep::{Overwrite, check_name, is_within};
pub use numbered::numbered;
pub(crate) use place::{PathTarget, create_folder, name_new, path_target, sync_folder};
pub use read::{open, read, read_text};
pub use results::{ResultFolder, remove_unfinished};
pub use write::{NewFile, unfinished, write};
