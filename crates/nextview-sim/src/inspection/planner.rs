use super::{KnownPart, PartFit, PlacedPart, SurfaceDemands};
use crate::SimError;
use crate::mesh::TriangleMesh;
use fixedbitset::FixedBitSet;
use glam::DVec3;
use nextview::Error;
use nextview::flow::{Incidence, SetValues, fewest_sets, good_coverage};
use nextview::geometry::{Plane, Pose};
use nextview::object::ON_TABLE;
use nextview::planner::{Choice, EvenViews, Explanation, Plan, Situation, ViewPlanner};
use nextview::registration::{KnownSurface, RegistrationConfig, SurfacePoint};
use nextview::view::ViewSpace;
use rayon::prelude::*;
use std::cmp::Reverse;

/// Plans the fewest views that show all surfaces of a part as required.
///
/// After each frame, it locates the part, determines the samples measured as demanded, and finds a small set
/// of views that show the rest: the fewest, or those that show most if that exceeds the maximum number of
/// views. It takes the view of this set that shows most. A sample that two pictures should have shown but did
/// not is given up.
pub struct InspectionViews {
    mesh: TriangleMesh,
    demands: SurfaceDemands,
    place: PartPlace,
    /// The renderings of the previous plan.
    rendered: Option<ShownSamples>,
}

/// The part's samples that each candidate would show.
struct ShownSamples {
    fit: PartFit,
    views: ViewSpace,
    /// By candidate, the samples it would show as demanded.
    shown: Vec<FixedBitSet>,
}

/// The part's place.
enum PartPlace {
    Stated { world_from_reference: Pose },
    ToFind(KnownPart),
}

/// Number of frames after which the part must have been found.
const N_FRAMES_TO_FIND: usize = 4;

/// The part's pose is kept until a new one moves a corner of its box farther than this, metres: rendering the
/// model from all candidates is the slowest step.
const MOTION: f64 = 0.001;

/// Number of pictures that should have shown a sample before it is given up.
const N_ATTEMPTS: u8 = 2;

impl InspectionViews {
    /// Creates a planner for a part with this CAD model in metres, whose triangles run counter-clockwise seen
    /// from outside. The part stands at the given place, or anywhere.
    pub fn new(
        mesh: TriangleMesh,
        demands: SurfaceDemands,
        world_from_reference: Option<Pose>,
    ) -> Result<Self, Error> {
        let place = match world_from_reference {
            Some(world_from_reference) => PartPlace::Stated { world_from_reference },
            None => PartPlace::ToFind(KnownPart::new(&mesh)?),
        };
        Ok(Self { mesh, demands, place, rendered: None })
    }

    /// The part's pose; `None` while it may still be found. Fails if the part should have been found.
    fn find(&self, situation: &Situation<'_>) -> Result<Option<PartFit>, Error> {
        let part = match &self.place {
            PartPlace::Stated { world_from_reference } => {
                let reference_from_world = world_from_reference.inverse();
                return Ok(Some(PartFit { reference_from_world, share: 1.0, ruled_out_share: 0.0 }));
            }
            PartPlace::ToFind(part) => part,
        };
        let fit =
            part.fit(&measured_points(situation)?, |point| rules_out(situation, point), situation.cancel())?;
        let n_frames = situation.frames().len();
        if fit.share < PartFit::LEAST_SHARE && n_frames >= N_FRAMES_TO_FIND {
            let problem = format!(
                "the CAD model does not fit what {n_frames} frames measured: {:.0} % of the points lie near it in the best pose found, expected at least {:.0} %; is it the model of this part, in the right unit?",
                1e2 * fit.share,
                1e2 * PartFit::LEAST_SHARE
            );
            return Err(Error::Planner(problem.into()));
        }
        Ok(Some(fit).filter(|fit| fit.share >= PartFit::LEAST_SHARE))
    }

    /// The samples of a part at this pose that each candidate would show; reused where hardly anything has
    /// changed.
    fn rendered(&self, fit: PartFit, situation: &Situation<'_>) -> Result<Option<ShownSamples>, Error> {
        if self.rendered.as_ref().is_some_and(|known| self.is_as_before(known, &fit, situation)) {
            return Ok(None);
        }
        let part = self.placed(&fit, situation)?;
        let shown_from = |pose| {
            situation.cancel().check()?;
            part.shown_from(pose)
        };
        let views = situation.views();
        let shown = views.poses().par_iter().map(shown_from).collect::<Result<_, Error>>()?;
        Ok(Some(ShownSamples { fit, views: views.clone(), shown }))
    }

    fn is_as_before(&self, known: &ShownSamples, fit: &PartFit, situation: &Situation<'_>) -> bool {
        let motion = known.fit.reference_from_world * fit.reference_from_world.inverse();
        let stays = |corner: DVec3| motion.transform_point(corner).distance(corner) <= MOTION;
        self.mesh.bounds().corners().into_iter().all(stays)
            && known.views.poses() == situation.views().poses()
    }

    fn placed(&self, fit: &PartFit, situation: &Situation<'_>) -> Result<PlacedPart<'_>, Error> {
        let camera = (*situation.intrinsics(), situation.depth_range());
        PlacedPart::new(&self.mesh, &self.demands, &fit.reference_from_world.inverse(), camera)
            .map_err(failed)
    }

    fn plan_by(&self, rendered: &ShownSamples, situation: &Situation<'_>) -> Result<Plan, Error> {
        let part = self.placed(&rendered.fit, situation)?;
        let MeasuredSamples { measured, given_up } = state(&part, situation, self.demands.samples().len())?;
        let open = situation.open_views();
        let still_shown = |view: &usize| {
            let mut shown = rendered.shown[*view].clone();
            shown.difference_with(&measured);
            shown.difference_with(&given_up);
            shown
        };
        let shown: Vec<FixedBitSet> = open.iter().map(still_shown).collect();
        let fewest = fewest_views(&shown, situation)?;
        let n_left = situation.n_views_left();
        let mut by_gain = match fewest.len() <= n_left {
            true => fewest.clone(),
            false => best_views(&shown, n_left, situation)?,
        };
        let gain = |i: usize| shown[i].count_ones(..);
        by_gain.sort_by_key(|&i| Reverse(gain(i))); // stable
        let Some(&best) = by_gain.first() else { return Ok(Plan::default()) };
        let all = self.demands.samples().len() as f64;
        let mut showable = measured.clone();
        shown.iter().for_each(|shown| showable.union_with(shown));
        let explanation = Explanation::from([
            ("views_to_show_all", fewest.len() as f64),
            ("measured_as_demanded_share", measured.count_ones(..) as f64 / all),
            ("measurable_as_demanded_share", showable.count_ones(..) as f64 / all),
            ("given_up_share", given_up.count_ones(..) as f64 / all),
            ("points_near_model_share", rendered.fit.share),
        ]);
        let choice = Choice {
            view: open[best],
            score: gain(best) as f64 / all,
            runner_up: by_gain.get(1).map(|&i| open[i]),
            explanation: Some(explanation),
        };
        Ok(Plan { choice: Some(choice), ..Plan::default() })
    }
}

impl ViewPlanner for InspectionViews {
    fn plan(&mut self, situation: &Situation<'_>) -> Result<Plan, Error> {
        match self.find(situation)? {
            Some(fit) => {
                let anew = self.rendered(fit, situation)?;
                let rendered = anew.as_ref().or(self.rendered.as_ref()).expect("it is as before");
                let plan = self.plan_by(rendered, situation)?;
                self.rendered = anew.or(self.rendered.take());
                Ok(plan)
            }
            None => EvenViews.plan(situation),
        }
    }

    fn seeks_surface(&self) -> bool {
        false
    }
}

/// The samples measured as demanded, and those not tried again.
struct MeasuredSamples {
    measured: FixedBitSet,
    given_up: FixedBitSet,
}

fn state(
    part: &PlacedPart<'_>,
    situation: &Situation<'_>,
    n_samples: usize,
) -> Result<MeasuredSamples, Error> {
    let mut measured = FixedBitSet::with_capacity(n_samples);
    let mut n_attempts = vec![0_u8; n_samples];
    for frame in situation.frames() {
        situation.cancel().check()?;
        let (shown, of_frame) = part.shown_in(frame)?;
        shown.ones().for_each(|sample| n_attempts[sample] = n_attempts[sample].saturating_add(1));
        measured.union_with(&of_frame);
    }
    let mut given_up = FixedBitSet::with_capacity(n_samples);
    given_up.extend((0..n_samples).filter(|&i| n_attempts[i] >= N_ATTEMPTS && !measured.contains(i)));
    Ok(MeasuredSamples { measured, given_up })
}

/// A small selection of the sets that together holds all their samples.
fn fewest_views(shown: &[FixedBitSet], situation: &Situation<'_>) -> Result<Vec<usize>, Error> {
    let n_samples = shown.first().map_or(0, FixedBitSet::len);
    let mut views_of_sample = Incidence::new(n_samples, shown.len());
    for (view, shown) in shown.iter().enumerate() {
        shown.ones().for_each(|sample| views_of_sample.insert(sample, view as u32));
    }
    let views = fewest_sets(&views_of_sample, situation.cancel())?;
    Ok(views.into_iter().map(|view| view as usize).collect())
}

/// At most `n` of the sets that together hold the most samples.
fn best_views(shown: &[FixedBitSet], n: usize, situation: &Situation<'_>) -> Result<Vec<usize>, Error> {
    let n_samples = shown.first().map_or(0, FixedBitSet::len);
    let of_view = |shown: &FixedBitSet| shown.ones().map(|sample| (sample as u32, 1.0)).collect();
    let values = SetValues::new(n_samples, shown.iter().map(of_view).collect());
    let coverage = good_coverage(&values, n, situation.cancel())?;
    Ok(coverage.sets.into_iter().map(|view| view as usize).collect())
}

/// The measured points with normals, without the table.
fn measured_points(situation: &Situation<'_>) -> Result<Vec<SurfacePoint>, Error> {
    let spacing = Some(situation.finest_voxel_size());
    let mut surface = KnownSurface::new(RegistrationConfig { spacing, ..RegistrationConfig::default() })?;
    let snapshot = situation.snapshot();
    let bounds = snapshot.lattice().bounds(&snapshot.block());
    for frame in situation.frames() {
        surface.add(frame, &frame.world_from_camera(), bounds, situation.cancel())?;
    }
    let is_above =
        |point: &SurfacePoint| situation.table().is_none_or(|table| table.height(point.position) > ON_TABLE);
    Ok(surface.points().into_iter().filter(is_above).collect())
}

/// Whether the part cannot be here: in the table, or in space seen to be free, including everything up to a
/// voxel away.
fn rules_out(situation: &Situation<'_>, point: DVec3) -> bool {
    let snapshot = situation.snapshot();
    let is_in = |table: Plane| table.height(point) < -snapshot.lattice().voxel_size();
    situation.table().is_some_and(is_in) || snapshot.is_free_around(point)
}

fn failed(error: SimError) -> Error {
    Error::Planner(error.into())
}
