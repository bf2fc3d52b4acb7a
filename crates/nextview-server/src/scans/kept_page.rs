//! The page content of a finished scan, as files in the scan's folder.

use crate::refusal::Refusal;
use axum::http::StatusCode;
use nextview_report::live::{LiveScene, SceneSource};
use nextview_report::{color_png, depth_png};
use nextview_scan::{Fault, LiveScan};
use std::fs;
use std::io::ErrorKind;
use std::path::Path;

/// The subfolder of the scan's folder.
const FOLDER: &str = "page";

const SCENE: &str = "scene.json";

/// An image taken by a camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Picture {
    Depth,
    Color,
}

impl Picture {
    /// The picture of the step with this index from 0, as PNG; `None` if the frame has none. Depth uses the
    /// colour scale of the first step, as on the page.
    pub fn of_scan(self, scan: &LiveScan, step_idx: usize) -> Result<Option<Vec<u8>>, Fault> {
        let scan = scan.scan();
        match self {
            Self::Depth => Ok(Some(depth_png(scan.frame(step_idx)?.image(), scan.frame(0)?.image()))),
            Self::Color => Ok(scan.color(step_idx)?.as_ref().map(color_png)),
        }
    }

    /// Reads the picture of a scan that was [kept](keep).
    pub fn of_folder(self, dir: &Path, step_idx: usize) -> Result<Option<Vec<u8>>, Fault> {
        read(dir, &self.name(step_idx))
    }

    fn name(self, step_idx: usize) -> String {
        let kind = if self == Self::Depth { "depth" } else { "color" };
        format!("{kind}-{}.png", step_idx + 1)
    }
}

/// Writes the scene and the pictures of a scan into its folder.
pub(super) fn keep(scan: &LiveScan, dir: &Path) -> Result<(), Fault> {
    let folder = dir.join(FOLDER);
    let write = |name: &str, bytes: &[u8]| {
        let path = folder.join(name);
        fs::write(&path, bytes).map_err(|e| Fault::from(e).while_writing(&path))
    };
    fs::create_dir_all(&folder).map_err(|e| Fault::from(e).while_writing(&folder))?;
    let source = SceneSource::of_scan(scan.scan(), scan.config(), None);
    write(SCENE, LiveScene::default().json(&source, 0).as_bytes())?;
    for step_idx in 0..scan.scan().steps.len() {
        for picture in [Picture::Depth, Picture::Color] {
            if let Some(png) = picture.of_scan(scan, step_idx)? {
                write(&picture.name(step_idx), &png)?;
            }
        }
    }
    Ok(())
}

/// Reads the scene of a scan that was [kept](keep).
pub(crate) fn scene(dir: &Path) -> Result<Vec<u8>, Refusal> {
    read(dir, SCENE)?.ok_or_else(|| {
        let fault = Fault::request("the scan was finished by a server that stored no scene");
        Refusal::new(StatusCode::CONFLICT, fault.with_remedy("download its files: `report.html` shows it"))
    })
}

/// Reads a file; `None` if there is none.
fn read(dir: &Path, name: &str) -> Result<Option<Vec<u8>>, Fault> {
    let path = dir.join(FOLDER).join(name);
    match fs::read(&path) {
        Ok(bytes) => Ok(Some(bytes)),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
        Err(error) => Err(Fault::from(error).in_file(&path)),
    }
}
