use super::object_points::{LEAST_POINTS, ObjectPoints};
use super::table::{KnownTable, ShownTable};
use crate::geometry::Aabb;
use crate::sensor::{Depth, Frame};
use crate::{Cancel, Cancelled};
use glam::{DVec2, DVec3, IVec3};
use rustc_hash::{FxHashMap, FxHashSet};

/// A body near the object that does not belong to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OtherBody {
    /// The box around its points, metres.
    pub bounds: Aabb,
    /// Its distance from the object, metres. With a larger `max_gap`, it
    /// belongs to the object.
    pub gap: f64,
}

/// The outline of a body is free if this many times more of it borders on something farther away than on
/// something nearer or on the edge of an image. Walls and floors fail this, and so do parts of them between
/// the shadows of other things. If any images show the whole body, only those count: a body near the object
/// is cut by the edge of most.
const MOSTLY_FREE: usize = 2;

/// Bodies farther from the object than this, metres, belong to the room: noise tears specks out of far walls.
const FARTHEST: f64 = 1.0;

/// The object's number among the bodies.
const OBJECT: u32 = 0;

/// The thing that a pixel shows.
#[derive(Clone, Copy, PartialEq)]
enum Shown {
    /// Nothing is known.
    Nothing,
    /// A neighbour farther away may stand on it.
    Table {
        depth: f32,
    },
    /// Nothing came back.
    Beyond,
    Body {
        number: u32,
        depth: f32,
    },
}

/// Connected cells, and the outlines of their pixels.
struct Candidate {
    cells: FxHashSet<IVec3>,
    /// In images that show all of it.
    whole: BodyOutline,
    /// In images whose edge cuts it.
    cut: BodyOutline,
}

/// The pixels of a body and their neighbours.
#[derive(Clone, Copy, Default)]
struct BodyOutline {
    n_pixels: usize,
    /// Neighbours that are farther away.
    n_free: usize,
    /// Neighbours that are nearer.
    n_hidden: usize,
    /// Neighbours beyond the edge of the image.
    n_beyond: usize,
}

/// Returns the bodies within a metre of the object, nearest first: at least 20 connected points, with free
/// space around most of their outline.
pub(super) fn other_bodies(
    points: &ObjectPoints,
    frames: &[Frame],
    table: Option<KnownTable>,
    cancel: &Cancel,
) -> Result<Vec<OtherBody>, Cancelled> {
    let mut search = points.search(cancel);
    let mut number_of: FxHashMap<IVec3, u32> = points.object().iter().map(|cell| (*cell, OBJECT)).collect();
    let mut candidates: Vec<Candidate> = Vec::new();
    for frame in frames {
        cancel.check()?;
        let table = table.map(|table| ShownTable::new(table, frame));
        cancel.check()?;
        let image = shown(frame, table, |point| {
            let cell = points.cell(point);
            if let Some(&number) = number_of.get(&cell) {
                return Ok(number);
            }
            let candidate = Candidate::new(search.around(FxHashSet::from_iter([cell]))?);
            let number = candidates.len() as u32 + 1;
            number_of.extend(candidate.cells.iter().map(|cell| (*cell, number)));
            candidates.push(candidate);
            Ok(number)
        })?;
        cancel.check()?;
        count_outlines(&image, frame.image().width() as usize, &mut candidates);
    }
    let bodies = candidates.iter().filter(|candidate| candidate.is_body());
    let mut bodies: Vec<OtherBody> = bodies
        .filter_map(|candidate| {
            let bounds = points.bounds_of(&candidate.cells)?;
            Some(OtherBody { bounds, gap: points.gap_to_object(&candidate.cells)? })
        })
        .filter(|body| body.gap <= FARTHEST)
        .collect();
    let place = |body: &OtherBody| body.bounds.min.to_array();
    let by_place =
        |a: &OtherBody, b: &OtherBody| place(a).partial_cmp(&place(b)).unwrap_or(std::cmp::Ordering::Equal);
    bodies.sort_by(|a, b| a.gap.total_cmp(&b.gap).then(by_place(a, b)));
    Ok(bodies)
}

impl Candidate {
    fn new(cells: FxHashSet<IVec3>) -> Self {
        Self { cells, whole: BodyOutline::default(), cut: BodyOutline::default() }
    }

    fn add(&mut self, outline: BodyOutline) {
        let sum = if outline.n_beyond == 0 { &mut self.whole } else { &mut self.cut };
        sum.n_pixels += outline.n_pixels;
        sum.n_free += outline.n_free;
        sum.n_hidden += outline.n_hidden;
        sum.n_beyond += outline.n_beyond;
    }

    fn is_body(&self) -> bool {
        let BodyOutline { n_pixels, n_free, n_hidden, n_beyond } =
            if self.whole.n_pixels >= LEAST_POINTS { self.whole } else { self.cut };
        n_pixels >= LEAST_POINTS && n_free > MOSTLY_FREE * (n_hidden + n_beyond)
    }
}

/// Returns what each pixel shows, row by row; `number` gives the body of a point.
fn shown(
    frame: &Frame,
    table: Option<ShownTable>,
    mut number: impl FnMut(DVec3) -> Result<u32, Cancelled>,
) -> Result<Vec<Shown>, Cancelled> {
    let (image, pose, intrinsics) = (frame.image(), frame.world_from_camera(), frame.intrinsics());
    let pixels = (0..image.height()).flat_map(|v| (0..image.width()).map(move |u| (u, v)));
    let look = |(u, v)| {
        let Depth::Surface(depth) = image.get(u, v) else {
            return Ok(if image.get(u, v) == Depth::Beyond { Shown::Beyond } else { Shown::Nothing });
        };
        let Some(ideal) = intrinsics.deproject(DVec2::new(u as f64, v as f64)) else {
            return Ok(Shown::Nothing);
        };
        let point = pose.transform_point(ideal.extend(1.0) * depth as f64);
        match table.is_none_or(|table| table.is_below(point)) {
            true => Ok(Shown::Body { number: number(point)?, depth }),
            false => Ok(Shown::Table { depth }),
        }
    };
    pixels.map(look).collect()
}

/// Counts the neighbours of every body's pixels that are not its own.
fn count_outlines(image: &[Shown], width: usize, candidates: &mut [Candidate]) {
    let mut outlines = vec![BodyOutline::default(); candidates.len()];
    for (pixel, &shown) in image.iter().enumerate() {
        let Shown::Body { number, depth } = shown else { continue };
        let Some(outline) = (number as usize).checked_sub(1).map(|i| &mut outlines[i]) else { continue };
        outline.n_pixels += 1;
        let (column, at) = (pixel % width, |i: Option<usize>| i.and_then(|i| image.get(i)));
        let left = at(pixel.checked_sub(1).filter(|_| column > 0));
        let right = at((column + 1 < width).then_some(pixel + 1));
        for neighbor in [left, right, at(pixel.checked_sub(width)), at(Some(pixel + width))] {
            match neighbor {
                Some(Shown::Nothing) => (),
                Some(Shown::Table { depth: other }) if *other <= depth => (),
                Some(Shown::Body { number: other, .. }) if *other == number => (),
                Some(Shown::Body { depth: other, .. }) if *other <= depth => outline.n_hidden += 1,
                Some(_) => outline.n_free += 1,
                None => outline.n_beyond += 1,
            }
        }
    }
    candidates.iter_mut().zip(outlines).for_each(|(candidate, outline)| candidate.add(outline));
}
