//! One scan: its page, and its quantities as text.
//!
//! The page is a single HTML file for the screen and for print. Start with [`scan_page`].

mod chart;
mod color;
mod coverage;
mod headline;
mod input;
mod live_scene;
mod new_points;
mod of_scan;
mod page;
mod picture;
mod placement;
mod placement_picture;
mod png_file;
mod scan_copy;
mod scene_source;
mod shown;
mod step_line;
mod steps;
mod stop_phrase;
mod summary;
mod thumbnail;
mod viewer;

pub use input::ScanPage;
pub use live_scene::LiveScene;
pub use of_scan::page_of_scan;
pub use page::scan_page;
pub use picture::ViewPicture;
pub use png_file::color_png;
pub use scene_source::SceneSource;
pub use shown::ShownModel;
pub use step_line::{heading, step_line};
pub use stop_phrase::stop_phrase;
pub use summary::{summary, summary_text};
pub use thumbnail::depth_png;
pub(crate) use viewer::{LIVE_PAGE, LIVE_SCRIPT};
