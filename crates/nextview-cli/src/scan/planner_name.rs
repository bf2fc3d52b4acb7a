use crate::Failure;
use clap::ValueEnum;
use nextview::gain::{
    Apora, AreaFactor, AverageEntropy, InformationGain, Krainin, OcclusionAware, ProximityCount,
    RearSideEntropy, RearSideVoxel, UnobservedVoxel,
};
use nextview::planner::{
    Batch, BatchConfig, Greedy, GreedyConfig, InOrder, MaxFlow, MaxFlowConfig, MostSurface,
    MostSurfaceConfig, RandomViews, ViewPlanner,
};
use nextview_nbv_net::{NbvNet, Network};
use nextview_sim::baseline::Clairvoyant;
use nextview_sim::truth::TrueVisibility;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;

/// A planner, by the name users give it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum PlannerName {
    /// Ours: the most surface that a learned prior expects to be seen anew
    MostSurface,
    /// The paper's: local information gain and the views of a maximum flow
    MaxFlow,
    /// The paper's local information gain alone (gamma = 0)
    Local,
    /// APORA's gain, Daudelin & Campbell 2017: entropy near the frontier
    Apora,
    /// Rear side entropy, Isler et al. 2016: the unknown behind surfaces
    Rse,
    /// Rays that meet a surface from behind, Isler et al. 2016
    RearSideVoxel,
    /// Visible entropy, Isler et al. 2016
    OcclusionAware,
    /// Visible entropy of unknown voxels, Isler et al. 2016
    UnobservedVoxel,
    /// Unknown voxels close behind measured surfaces, Isler et al. 2016
    ProximityCount,
    /// Mean entropy on rays that end at a surface, Kriegel et al. 2015
    AverageEntropy,
    /// Entropy on rays that end at a surface, Krainin et al. 2011
    Krainin,
    /// Shares of surface and occlusion plane, Vasquez-Gomez et al. 2014
    AreaFactor,
    /// NBV-Net, Mendoza et al. 2020: the one of 14 views that a network has learned to name
    NbvNet,
    /// Several views at once that together show most, and the shortest tour through them
    Batch,
    /// The views in the order of their numbers: that of a recording
    InOrder,
    /// A random view: the baseline
    Random,
    /// Knows the object: the upper bound, where the truth is known
    Clairvoyant,
}

/// Parameters of NBV-Net.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct NbvNetConfig {
    /// A safetensors file; by default the library's own weights.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weights: Option<PathBuf>,
}

/// The parameters of all planners.
#[derive(Clone, Debug, Default)]
pub(crate) struct PlannerConfigs {
    pub most_surface: MostSurfaceConfig,
    pub max_flow: MaxFlowConfig,
    /// Of all planners that are named after a gain.
    pub greedy: GreedyConfig,
    pub batch: BatchConfig,
    pub nbv_net: NbvNetConfig,
}

impl NbvNetConfig {
    /// The planner; fails if the weights cannot be read.
    pub fn planner(&self) -> Result<NbvNet, Failure> {
        let Some(path) = &self.weights else { return Ok(NbvNet::default()) };
        let file =
            std::fs::read(path).map_err(|e| Failure::data(format!("cannot be read: {e}")).in_file(path))?;
        let network = Network::from_safetensors(&file).map_err(|e| {
            Failure::data(e)
                .in_file(path)
                .with_hint("training/nbv_net.py trains such weights and converts published ones")
        })?;
        Ok(NbvNet::new(network))
    }
}

impl fmt::Display for PlannerName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.to_possible_value().map_or(Ok(()), |value| f.pad(value.get_name()))
    }
}

impl PlannerName {
    /// The planner, where the true object is known.
    pub fn build(
        self,
        configs: PlannerConfigs,
        seed: u64,
        truth: Option<Arc<TrueVisibility>>,
    ) -> Result<Box<dyn ViewPlanner>, Failure> {
        match (self, truth) {
            (Self::Clairvoyant, Some(truth)) => Ok(Box::new(Clairvoyant::new(truth))),
            (Self::ProximityCount, _) => by_gain::<ProximityCount>(configs.greedy),
            _ => self.without_truth(configs, seed),
        }
    }

    /// The planner, where nothing but the map is known.
    pub fn without_truth(self, configs: PlannerConfigs, seed: u64) -> Result<Box<dyn ViewPlanner>, Failure> {
        let PlannerConfigs { most_surface, max_flow, greedy, batch, nbv_net } = configs;
        match self {
            Self::MostSurface => Ok(Box::new(MostSurface::new(most_surface)?)),
            Self::MaxFlow => Ok(Box::new(MaxFlow::new(max_flow)?)),
            Self::Local => Ok(Box::new(MaxFlow::new(MaxFlowConfig { gamma: 0.0, ..max_flow })?)),
            Self::Apora => by_gain::<Apora>(greedy),
            Self::Rse => by_gain::<RearSideEntropy>(greedy),
            Self::RearSideVoxel => by_gain::<RearSideVoxel>(greedy),
            Self::OcclusionAware => by_gain::<OcclusionAware>(greedy),
            Self::UnobservedVoxel => by_gain::<UnobservedVoxel>(greedy),
            Self::ProximityCount => Err(Failure::usage(
                "the proximity count needs the depth images behind the map, which a map file does not hold",
            )
            .with_hint("use it with `nextview scan`")),
            Self::AverageEntropy => by_gain::<AverageEntropy>(greedy),
            Self::Krainin => by_gain::<Krainin>(greedy),
            Self::AreaFactor => by_gain::<AreaFactor>(greedy),
            Self::NbvNet => Ok(Box::new(nbv_net.planner()?)),
            Self::Batch => Ok(Box::new(Batch::new(batch)?)),
            Self::InOrder => Ok(Box::new(InOrder)),
            Self::Random => Ok(Box::new(RandomViews { seed })),
            Self::Clairvoyant => Err(Failure::usage(
                "the clairvoyant planner needs the true object, which only a simulation knows",
            )
            .with_hint("use it with `nextview scan`")),
        }
    }
}

fn by_gain<G: InformationGain + 'static>(config: GreedyConfig) -> Result<Box<dyn ViewPlanner>, Failure> {
    Ok(Box::new(Greedy::<G>::new(config)?))
}
