use crate::frame::uselessness;
use crate::recording::{ReadOptions, Recording, Skipped};
use crate::{RecordedFrame, RecordingError, folder, limits, mcap, tum};
use rayon::prelude::*;
use std::path::Path;

impl Recording {
    /// Reads a recording: a folder with `poses.csv`, `intrinsics.txt` and `depth/`, a folder with
    /// `depth.txt`, `groundtruth.txt` and `intrinsics.txt` (TUM RGB-D), or an MCAP file with ROS 2 messages.
    pub fn open(path: &Path, options: &ReadOptions) -> Result<Self, RecordingError> {
        options.check()?;
        let is_there = |name: &str| path.join(name).exists();
        let recording = match path.metadata() {
            Err(error) => Err(error.into()),
            Ok(what) if what.is_file() => mcap::read(path, options),
            Ok(_) if is_there("poses.csv") => folder::read(path, options),
            Ok(_) if is_there("depth.txt") || is_there("groundtruth.txt") => tum::read(path, options),
            Ok(_) => Err(RecordingError::Content(
                "is not a recording, expected a folder with poses.csv, intrinsics.txt and depth/, or a folder of TUM RGB-D with \
                 depth.txt, groundtruth.txt and intrinsics.txt, or an .mcap file"
                    .into(),
            )),
        };
        // An error in a file of the folder already names that file.
        let recording = recording.map_err(|error| match error {
            RecordingError::InFile { .. } => error,
            error => error.in_file(path),
        });
        let mut recording = recording?;
        for frame in &mut recording.frames {
            frame.world_from_camera = options.world_from_camera(&frame.world_from_camera);
        }
        recording.check_pixels(path).map_err(|error| error.in_file(path))?;
        let recording = recording.without_useless_frames().map_err(|error| match error {
            RecordingError::Content(_) => error.in_file(path),
            error => error,
        })?;
        recording.with_checked_colors()
    }

    /// Fails if the images are larger than plausible for the files.
    fn check_pixels(&self, path: &Path) -> Result<(), RecordingError> {
        let sizes: Vec<Option<u64>> =
            self.frames.iter().map(RecordedFrame::file_size).collect::<Result<_, _>>()?;
        let shared = if sizes.contains(&None) { path.metadata()?.len() } else { 0 };
        let n_bytes = sizes.iter().flatten().sum::<u64>() + shared;
        limits::check_pixels(&self.intrinsics, self.frames.len(), n_bytes)
    }

    /// Reads all images and leaves out useless ones.
    fn without_useless_frames(mut self) -> Result<Self, RecordingError> {
        let check = |frame: &RecordedFrame| Ok(uselessness(frame.load()?.image()));
        let mut checks: Vec<Option<String>> = Vec::new();
        for group in self.groups() {
            checks.append(&mut group.par_iter().map(check).collect::<Result<_, RecordingError>>()?);
        }
        let mut kept = Vec::new();
        for (frame, why) in self.frames.into_iter().zip(checks) {
            match why {
                Some(why) => self.skipped.push(Skipped { what: frame.name, why }),
                None => kept.push(frame),
            }
        }
        if kept.is_empty() {
            let first = self.skipped.first().map(|skipped| format!("; {skipped}")).unwrap_or_default();
            return Err(RecordingError::Content(format!("holds no usable frame{first}")));
        }
        Ok(Self { frames: kept, ..self })
    }

    /// Reads all colour images, and notes if some frames lack one.
    fn with_checked_colors(mut self) -> Result<Self, RecordingError> {
        for group in self.groups() {
            group.par_iter().try_for_each(|frame| frame.load_color().map(drop))?;
        }
        let n_colored = self.frames.iter().filter(|frame| frame.has_color()).count();
        if n_colored > 0 && n_colored < self.frames.len() {
            let n_frames = self.frames.len();
            self.notes.push(format!("{} of {n_frames} frames have no colour image", n_frames - n_colored));
        }
        Ok(self)
    }
}
