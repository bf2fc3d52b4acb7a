use super::SessionConfig;
use super::alignment::Alignment;
use super::earlier::Earlier;
use super::goal::MeasuredQuality;
use super::report::MapReport;
use super::scan_map::{MapRules, ScanMap};
use super::seen_cells::SeenCells;
use super::shown::shown_on;
use super::taken_frames::{SetAside, TakenFrames};
use crate::map::MapUpdate;
use crate::object::{Location, Locator, Place};
use crate::placement::ShownObject;
use crate::registration::{Registration, RegistrationConfig, RegistrationMode};
use crate::sensor::Frame;
use crate::{Cancel, Cancelled, Error};

/// The frames and everything they have shown: the object's location, its surface, and the map.
#[derive(Clone, Debug)]
pub(super) struct KnownScene {
    pub frames: TakenFrames,
    /// `None` if this is the first placement of the object.
    pub earlier: Option<Earlier>,
    pub locator: Locator,
    pub map: ScanMap,
    pub seen: SeenCells,
    pub alignment: Alignment,
    /// `None` if there are no goals.
    pub quality: Option<MeasuredQuality>,
    /// Whether the box that was found has too many voxels and was not adopted.
    pub is_box_too_large: bool,
}

/// The changes made by an observation.
#[derive(Default)]
pub(super) struct Added {
    pub update: MapUpdate,
    pub report: MapReport,
    /// The object's location; `None` if unchanged.
    pub moved: Option<Location>,
    /// The alignment of the frame; `None` if registration is off, and while no surface is known.
    pub registration: Option<Registration>,
    /// The share of measured cells that reach the goals; `None` if there are no goals.
    pub share_at_goal: Option<f64>,
    /// The numbers of the frames that were set aside before and entered the map with this one.
    pub recovered: Vec<usize>,
    /// How far apart the given poses put the same surface, metres, if this frame proves them wrong: all
    /// frames have then been aligned.
    pub apart: Option<f64>,
    /// Whether alignment was given up with this frame: all poses are used as given.
    pub is_as_given: bool,
}

impl KnownScene {
    /// Returns the scene before the first frame, and the object's location if known then. The configuration
    /// must have been checked.
    pub fn new(config: &SessionConfig) -> Result<(Self, Option<Location>), Error> {
        let &SessionConfig { voxel_size, sensor_model, rays, background, registration, .. } = config;
        let rules = MapRules { voxel_size, sensor_model, rays, background };
        let is_aligned = registration.mode() == RegistrationMode::On;
        let pose_error = is_aligned.then_some(registration.position_uncertainty);
        let mut scene = Self {
            frames: TakenFrames::default(),
            earlier: None,
            locator: Locator::new(config.object_box, config.table, voxel_size, config.max_gap, pose_error),
            map: ScanMap::new(rules, Place::default()),
            seen: SeenCells::new(voxel_size),
            alignment: Alignment::new(registration, voxel_size)?,
            quality: MeasuredQuality::new(config)?,
            is_box_too_large: false,
        };
        let never = &Cancel::default();
        let location = scene.locator.locate(&[], never)?;
        let location = scene.adopt(location, config, never)?;
        Ok((scene, location))
    }

    /// Returns the scene with one more frame, and the changes. It is a copy, so that nothing changes if
    /// cancelled.
    pub fn with_frame(
        &self,
        config: &SessionConfig,
        frame: &Frame,
        cancel: &Cancel,
    ) -> Result<(Self, Added), Cancelled> {
        let mut scene = self.clone();
        let mut added = scene.take_in(config, frame, cancel)?;
        let Place { bounds, table } = scene.map.place();
        let top = table.map(|table| table.top);
        if added.apart.is_some() || added.is_as_given {
            scene.seen = scene.frames.seen_anew(SeenCells::new(config.voxel_size), bounds, top);
        } else {
            scene.seen.add(&scene.frames.mapped[self.frames.mapped.len()..], bounds, top);
        }
        scene.join_earlier(config, &mut added, cancel)?;
        Ok((scene, added))
    }

    /// Returns the object as shown by the frames of this placement; `None` before it is found, and without a
    /// table.
    pub fn shown_object(&self, cancel: &Cancel) -> Result<Option<ShownObject>, Cancelled> {
        let (snapshot, table) = (self.map.finest_snapshot(cancel)?, self.map.place().table);
        let shown = |(snapshot, table)| shown_on(self.frames.of_now(), snapshot, table, cancel);
        snapshot.zip(table).map(shown).transpose()
    }

    /// Takes in a new frame. With registration, it is aligned first. If that fails, it is set aside; else
    /// those set aside before are tried again, since more surface is known. With
    /// [`RegistrationMode::Auto`], alignment is given up if it fails for most frames.
    fn take_in(
        &mut self,
        config: &SessionConfig,
        frame: &Frame,
        cancel: &Cancel,
    ) -> Result<Added, Cancelled> {
        let apart = self.alignment.compare(frame, self.map.place().bounds, cancel)?;
        let mut moved = match apart {
            Some(_) => self.begin_again(RegistrationMode::On, config, cancel)?,
            None => None,
        };
        let mut registration = self.register(frame, cancel)?;
        let is_choice = config.registration.mode() == RegistrationMode::Auto;
        let is_as_given =
            is_choice && !self.is_reliable(registration) && self.frames.would_mostly_be_set_aside();
        let mut recovered = Vec::new();
        if is_as_given {
            recovered = self.frames.set_aside.iter().map(|waiting| waiting.number).collect();
            moved = self.begin_again(RegistrationMode::Off, config, cancel)?.or(moved);
            registration = None;
        }
        let number = self.frames.add(frame.world_from_camera());
        let mut added = Added { registration, moved, recovered, apart, is_as_given, ..Added::default() };
        if self.is_reliable(registration) {
            self.add((number, frame.clone(), registration), config, &mut added, cancel)?;
            self.try_again(config, &mut added, cancel)?;
        } else {
            let aside = registration.map(|registration| (frame.clone(), registration));
            self.frames.set_aside.extend(aside.map(|(frame, registration)| SetAside {
                number,
                frame,
                registration,
            }));
        }
        added.share_at_goal = self.quality.as_mut().map(MeasuredQuality::end_step);
        let snapshot = self.map.finest_snapshot(cancel)?;
        let report = snapshot.map(|snapshot| MapReport::unless(&snapshot, cancel)).transpose()?;
        Ok(Added { report: report.unwrap_or_default(), ..added })
    }

    /// Adds the frames of the earlier placement, moved with the object, if this frame shows how it was
    /// turned, or shows it better.
    fn join_earlier(
        &mut self,
        config: &SessionConfig,
        added: &mut Added,
        cancel: &Cancel,
    ) -> Result<(), Cancelled> {
        let Some(earlier) = &self.earlier else { return Ok(()) };
        let Some(now) = self.shown_object(cancel)? else { return Ok(()) };
        let Some(turn) = earlier.find(&now, cancel)? else { return Ok(()) };
        let earlier = Earlier { turn: Some(turn), ..earlier.clone() };
        if let Ok(turn) = turn {
            let frames = self.frames.after(earlier.frames(&turn.now_from_before));
            let (scene, joined) = self.anew(config, frames, cancel)?;
            *self = scene;
            let Place { bounds, table } = self.map.place();
            self.seen.know(self.frames.of_before(), bounds, table.map(|table| table.top));
            added.moved = joined.moved.or(added.moved.take());
            added.report = joined.report;
        }
        self.earlier = Some(earlier);
        Ok(())
    }

    /// Rebuilds the scene from the earlier frames of this placement, in this mode.
    fn begin_again(
        &mut self,
        mode: RegistrationMode,
        config: &SessionConfig,
        cancel: &Cancel,
    ) -> Result<Option<Location>, Cancelled> {
        let registration = RegistrationConfig { enabled: Some(mode), ..config.registration };
        let config = SessionConfig { registration, ..*config };
        let (mut scene, mut moved) = Self::new(&config).expect("the configuration was checked");
        let before = self.frames.of_before().to_vec();
        if !before.is_empty() {
            let (joined, added) = scene.anew(&config, TakenFrames::default().after(before), cancel)?;
            (scene, moved) = (joined, added.moved);
        }
        scene.earlier = self.earlier.take();
        let given = self.frames.as_given();
        *self = scene;
        for frame in given {
            let added = self.take_in(&config, &frame, cancel)?;
            moved = added.moved.or(moved);
        }
        Ok(moved)
    }

    /// Returns the scene rebuilt from these frames, some of which may be of the placement before, and the
    /// changes.
    fn anew(
        &self,
        config: &SessionConfig,
        frames: TakenFrames,
        cancel: &Cancel,
    ) -> Result<(Self, Added), Cancelled> {
        let mut scene = Self {
            locator: self.locator.after(frames.n_earlier),
            frames,
            earlier: self.earlier.clone(),
            map: self.map.nowhere(),
            seen: self.seen.clone(),
            alignment: self.alignment.without_surface(),
            quality: self.quality.clone(),
            is_box_too_large: false,
        };
        if scene.frames.mapped.is_empty() {
            return Ok((scene, Added::default()));
        }
        let location = scene.locator.locate_anew(&scene.frames.mapped, cancel)?;
        let moved = scene.adopt(location, config, cancel)?;
        let bounds = scene.map.place().bounds;
        for frame in &scene.frames.mapped {
            scene.alignment.remember(frame, &frame.world_from_camera(), bounds, None, cancel)?;
        }
        if let Some(quality) = &mut scene.quality {
            quality.renew(&scene.frames.mapped, bounds, cancel)?;
        }
        let last = scene.frames.mapped.last().expect("there are frames");
        scene.map.integrate(last, cancel)?;
        scene.refine_what_is_known(config, cancel)?;
        let snapshot = scene.map.finest_snapshot(cancel)?;
        let report = snapshot.map(|snapshot| MapReport::unless(&snapshot, cancel)).transpose()?;
        Ok((scene, Added { moved, report: report.unwrap_or_default(), ..Added::default() }))
    }

    /// Aligns a frame to the known surface; `None` while there is none.
    pub fn register(&self, frame: &Frame, cancel: &Cancel) -> Result<Option<Registration>, Cancelled> {
        self.alignment.register(frame, self.map.place().bounds, cancel)
    }

    /// Whether the pose of a frame can be trusted: its alignment, or the given pose if that was refused.
    fn is_reliable(&self, registration: Option<Registration>) -> bool {
        registration.is_none_or(|found| found.fits()) || self.alignment.trusts_given_poses()
    }

    /// Aligns the frames set aside to the known surface until none fits any more.
    fn try_again(
        &mut self,
        config: &SessionConfig,
        added: &mut Added,
        cancel: &Cancel,
    ) -> Result<(), Cancelled> {
        loop {
            let bounds = self.map.place().bounds;
            for waiting in &mut self.frames.set_aside {
                if let Some(found) = self.alignment.register(&waiting.frame, bounds, cancel)? {
                    waiting.registration = found;
                }
            }
            // Frames that fit come first: others may overlap with them.
            let fitting = self.frames.set_aside.iter().position(|waiting| waiting.registration.fits());
            let given = || self.alignment.trusts_given_poses().then_some(0);
            let next = fitting.or_else(given).filter(|next| *next < self.frames.set_aside.len());
            let Some(next) = next else { return Ok(()) };
            let SetAside { number, frame, registration } = self.frames.set_aside.remove(next);
            self.add((number, frame, Some(registration)), config, added, cancel)?;
            added.recovered.push(number);
        }
    }

    /// Adds a frame, in its aligned pose, to the scene.
    fn add(
        &mut self,
        (number, frame, registration): (usize, Frame, Option<Registration>),
        config: &SessionConfig,
        added: &mut Added,
        cancel: &Cancel,
    ) -> Result<(), Cancelled> {
        let given = frame.world_from_camera();
        let pose = registration.map_or(given, |found| found.world_from_camera);
        self.frames.map(number, frame.with_pose(pose));
        let location = self.locator.locate(&self.frames.mapped, cancel)?;
        let mut moved = self.adopt(location, config, cancel)?;
        let mut is_all_new = moved.is_some();
        let frame = self.frames.mapped.last().expect("a frame was added");
        self.alignment.remember(frame, &given, self.map.place().bounds, registration, cancel)?;
        let realigned = self.alignment.realign(self.map.place().bounds, cancel)?;
        if let Some(realigned) = &realigned {
            self.frames.move_to(&realigned.poses);
        }
        // What is finer than the map's voxels does not change it.
        if realigned.is_some_and(|realigned| realigned.is_far) {
            let known = self.frames.all_but_last();
            self.map.move_to(self.map.place(), known, cancel)?;
            let location = self.locator.locate_anew(&self.frames.mapped, cancel)?;
            moved = self.adopt(location, config, cancel)?.or(moved);
            is_all_new = true;
        }
        added.moved = moved.or(added.moved.take());
        let frame = self.frames.mapped.last().expect("a frame was added");
        if let Some(quality) = &mut self.quality {
            let bounds = self.map.place().bounds;
            match is_all_new {
                true => quality.renew(&self.frames.mapped, bounds, cancel)?,
                false => quality.add(frame, bounds, cancel)?,
            }
        }
        added.update += self.map.integrate(frame, cancel)?;
        self.refine_what_is_known(config, cancel)
    }

    /// Adopts the place found from all frames unless its box is too large; the last frame is not mapped yet.
    fn adopt(
        &mut self,
        location: Location,
        config: &SessionConfig,
        cancel: &Cancel,
    ) -> Result<Option<Location>, Cancelled> {
        let bounds = location.place.bounds;
        self.is_box_too_large = bounds.is_some_and(|bounds| config.check_size(&bounds).is_err());
        if location.place == self.map.place() || self.is_box_too_large {
            return Ok(None);
        }
        let known = self.frames.all_but_last();
        let is_first_box = self.map.place().bounds.is_none();
        self.map.move_to(location.place, known, cancel)?;
        let rule = config.multi_resolution;
        if let (true, Some(bounds)) = (is_first_box && rule.enabled, location.place.bounds) {
            let n_halvings = rule.n_halvings(config.voxel_size, bounds.longest_side());
            self.map.plan_in(n_halvings, known, cancel)?;
        }
        Ok(Some(location))
    }

    /// Halves the planning voxels as long as the map in them is known well enough: algorithm 1, eq. (9).
    fn refine_what_is_known(&mut self, config: &SessionConfig, cancel: &Cancel) -> Result<(), Cancelled> {
        let rule = config.multi_resolution;
        while rule.enabled && !self.map.is_finest() {
            let Some(snapshot) = self.map.planning_snapshot(cancel)? else { break };
            if snapshot.entropy_share_unless(cancel)? >= rule.q_thresh {
                break;
            }
            self.map.refine(&self.frames.mapped, cancel)?;
        }
        Ok(())
    }
}
