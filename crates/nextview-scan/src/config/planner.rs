//! Construction of the configured planner.

#[cfg(feature = "simulated")]
use super::planner_name::no_reference;
use super::{PlannerChoice, PlannerName, ReferenceConfig, ScanConfig};
use crate::Fault;
use nextview::gain::{
    Apora, AreaFactor, AverageEntropy, InformationGain, Krainin, OcclusionAware, Potthast, ProximityCount,
    RearSideEntropy, RearSideVoxel, UnobservedVoxel,
};
use nextview::planner::{
    Batch, EvenViews, FrontierTour, Greedy, GreedyConfig, InOrder, MaxFlow, MaxFlowConfig, MinOverlap,
    MostSurface, PbNbv, RandomViews, RecedingHorizon, See, ViewPlanner,
};
use nextview::registration::RegistrationMode;
use nextview_learned::kaba::Kaba;
use nextview_learned::nbv_regression::NbvRegression;
use nextview_learned::pc_nbv::PcNbv;

/// Minimum overlap of views if frames are aligned. With 0.3, a scan of a recorded bunny took views that
/// aligned only by chance; with 0.6 and more, scans advance too slowly.
const OVERLAP_TO_ALIGN: f64 = 0.5;

impl ScanConfig {
    /// Builds the planner. The caller provides the clairvoyant one; `None` if the truth is unknown.
    pub fn planner(&self, clairvoyant: Option<Box<dyn ViewPlanner>>) -> Result<Box<dyn ViewPlanner>, Fault> {
        let planner = match &self.planner {
            PlannerChoice::BuiltIn(name) => build(*name, self, clairvoyant)?,
            PlannerChoice::Provided(planner) => planner.build(self.greedy, self.seed)?,
        };
        let is_aligned = self.registration_mode() != RegistrationMode::Off;
        Ok(match self.min_overlap {
            Some(share) => Box::new(MinOverlap::new(share, planner)?),
            None if is_aligned && !self.planner.properties().is_in_order => {
                Box::new(MinOverlap::to_align(OVERLAP_TO_ALIGN, planner)?)
            }
            None => planner,
        })
    }
}

/// Builds a planner with its parameters.
fn build(
    name: PlannerName,
    config: &ScanConfig,
    clairvoyant: Option<Box<dyn ViewPlanner>>,
) -> Result<Box<dyn ViewPlanner>, Fault> {
    let &ScanConfig { most_surface, max_flow, greedy, batch, seed, .. } = config;
    let &ScanConfig { frontier_tour, receding_horizon, kaba, .. } = config;
    Ok(match name {
        PlannerName::MostSurface => Box::new(MostSurface::new(most_surface)?),
        PlannerName::MaxFlow => Box::new(MaxFlow::new(max_flow)?),
        PlannerName::Local => Box::new(MaxFlow::new(MaxFlowConfig { gamma: 0.0, ..max_flow })?),
        PlannerName::Apora => by_gain::<Apora>(greedy)?,
        PlannerName::Rse => by_gain::<RearSideEntropy>(greedy)?,
        PlannerName::RearSideVoxel => by_gain::<RearSideVoxel>(greedy)?,
        PlannerName::OcclusionAware => by_gain::<OcclusionAware>(greedy)?,
        PlannerName::UnobservedVoxel => by_gain::<UnobservedVoxel>(greedy)?,
        PlannerName::ProximityCount => by_gain::<ProximityCount>(greedy)?,
        PlannerName::AverageEntropy => by_gain::<AverageEntropy>(greedy)?,
        PlannerName::Krainin => by_gain::<Krainin>(greedy)?,
        PlannerName::AreaFactor => by_gain::<AreaFactor>(greedy)?,
        PlannerName::Potthast => by_gain::<Potthast>(greedy)?,
        PlannerName::FrontierTour => Box::new(FrontierTour::new(frontier_tour.ray_spacing)?),
        PlannerName::PbNbv => Box::new(PbNbv),
        PlannerName::See => Box::new(See::default()),
        PlannerName::RecedingHorizon => Box::new(RecedingHorizon::new(receding_horizon.ray_spacing, seed)?),
        PlannerName::Kaba => Box::new(Kaba::new(kaba.ray_spacing)?),
        PlannerName::NbvNet => Box::new(config.nbv_net.planner()?),
        PlannerName::NbvRegression => Box::new(NbvRegression::default()),
        PlannerName::PcNbv => Box::new(PcNbv::default()),
        PlannerName::Batch => Box::new(Batch::new(batch)?),
        PlannerName::EvenViews => Box::new(EvenViews),
        PlannerName::Inspection => inspection(config.reference.as_ref())?,
        PlannerName::InOrder => Box::new(InOrder),
        PlannerName::Random => Box::new(RandomViews { seed }),
        PlannerName::Clairvoyant => clairvoyant.ok_or_else(|| {
            Fault::request("the clairvoyant planner needs the true object").with_remedy(
                "use it in a simulation, or set `recording.truth` to the mesh of a recorded object",
            )
        })?,
    })
}

#[cfg(feature = "simulated")]
fn inspection(reference: Option<&ReferenceConfig>) -> Result<Box<dyn ViewPlanner>, Fault> {
    reference.ok_or_else(no_reference)?.planner()
}

#[cfg(not(feature = "simulated"))]
fn inspection(_: Option<&ReferenceConfig>) -> Result<Box<dyn ViewPlanner>, Fault> {
    Err(Fault::request("this program reads no meshes, which the planner inspection needs"))
}

fn by_gain<G: InformationGain + 'static>(config: GreedyConfig) -> Result<Box<dyn ViewPlanner>, Fault> {
    Ok(Box::new(Greedy::<G>::new(config)?))
}
