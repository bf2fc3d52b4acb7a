/// Name of the folder of the results that holds the frames of the map, in the poses in which they were
/// mapped: a recording in our own form, whose images have the numbers of their steps. Behind them come those
/// of the scan before the object was turned, if there was one; all then show nothing but the object.
pub const FRAMES_FOLDER: &str = "frames";
