/// Name of the folder with the frames of the map in their mapped poses: a recording in our own format, with
/// images numbered by step. After them come those of the scan before the object was turned, if there was one;
/// all frames then show only the object.
pub const FRAMES_FOLDER: &str = "frames";
