use super::PlannerProperties;
use super::names::named;
use crate::{Fault, files};
use nextview_learned::nbv_net::{NbvNet, Network};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Declares the planners with their properties; a row leaves out those with their default value.
macro_rules! planners {
    ($(#[$meta:meta])* pub enum $type:ident {
        $($(#[$attribute:meta])* $planner:ident = $name:literal: $about:literal,
            { $($property:ident: $value:expr),* };)+
    }) => {
        named! {
            $(#[$meta])*
            pub enum $type { $($(#[$attribute])* $planner = $name: $about,)+ }
        }

        impl $type {
            /// What the planner needs, offers and reads.
            pub fn properties(self) -> PlannerProperties {
                match self {
                    $(Self::$planner => PlannerProperties {
                        $($property: $value,)*
                        ..PlannerProperties::default()
                    },)+
                }
            }
        }
    };
}

planners! {
    /// A planner by name.
    #[derive(Default)]
    pub enum PlannerName {
        #[default] MostSurface = "most-surface": "Ours: the most new surface, as expected by a learned prior",
            { section: Some("most_surface"), estimates_completeness: true, takes_second_looks: true, counts_seconds: true };
        MaxFlow = "max-flow": "The paper's: local information gain and the views of a maximum flow",
            { section: Some("max_flow") };
        Local = "local": "The paper's local information gain alone (gamma = 0)",
            { section: Some("max_flow"), fixes_gamma: true };
        Apora = "apora": "APORA's gain, Daudelin & Campbell 2017: entropy near the frontier",
            { section: Some("greedy") };
        Rse = "rse": "Rear side entropy, Isler et al. 2016: the unknown behind surfaces",
            { section: Some("greedy") };
        RearSideVoxel = "rear-side-voxel": "Rays that meet a surface from behind, Isler et al. 2016",
            { section: Some("greedy") };
        OcclusionAware = "occlusion-aware": "Visible entropy, Isler et al. 2016",
            { section: Some("greedy") };
        UnobservedVoxel = "unobserved-voxel": "Visible entropy of unknown voxels, Isler et al. 2016",
            { section: Some("greedy") };
        ProximityCount = "proximity-count": "Unknown voxels close behind measured surfaces, Isler et al. 2016",
            { section: Some("greedy"), needs_frames: true };
        AverageEntropy = "average-entropy": "Mean entropy on rays that end at a surface, Kriegel et al. 2015",
            { section: Some("greedy") };
        Krainin = "krainin": "Entropy on rays that end at a surface, Krainin et al. 2011",
            { section: Some("greedy") };
        AreaFactor = "area-factor": "Shares of surface and occlusion plane, Vasquez-Gomez et al. 2014",
            { section: Some("greedy") };
        Potthast = "potthast": "Expected loss of entropy along rays, Potthast & Sukhatme 2014",
            { section: Some("greedy") };
        FrontierTour = "frontier-tour": "First view of the shortest tour past the frontier, Meng et al. 2017",
            { section: Some("frontier_tour") };
        PbNbv = "pb-nbv": "Image area of ellipsoids around frontier and surface, Jia et al. 2025",
            {};
        See = "see": "Views onto the edges of dense points, Border & Gammell 2024",
            { needs_frames: true };
        RecedingHorizon = "receding-horizon": "First view of the best branch of a random tree, Bircher et al. 2016",
            { section: Some("receding_horizon") };
        Kaba = "kaba": "Gain minus the remaining boundary, weighted by reinforcement learning, Kaba et al. 2017",
            { section: Some("kaba") };
        NbvNet = "nbv-net": "NBV-Net, Mendoza et al. 2020: one of 14 views, chosen by a network",
            { section: Some("nbv_net"), is_network: true };
        NbvRegression = "nbv-regression": "A direction predicted by a network, Vasquez-Gomez et al. 2021",
            { is_network: true };
        PcNbv = "pc-nbv": "PC-NBV, Zeng et al. 2020: the one of 33 views with the most new surface, by a network",
            { is_network: true };
        Batch = "batch": "Several views at once that together show the most, and the shortest tour through them",
            { section: Some("batch") };
        EvenViews = "even-views": "Views from all around: the direction farthest from all views taken; for reference views",
            {};
        Inspection = "inspection": "Knows the part's CAD model: the fewest views that show its surfaces as required",
            { needs_frames: true, needs_reference: true };
        InOrder = "in-order": "The views in the order of their numbers, such as a recording's",
            { is_in_order: true };
        Random = "random": "A random view: the baseline",
            { is_random: true };
        Clairvoyant = "clairvoyant": "Knows the object: the upper bound, if the ground truth is known",
            { needs_truth: true };
    }
}

/// Parameters of NBV-Net.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct NbvNetConfig {
    /// A safetensors file. Default: the library's own weights.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weights: Option<PathBuf>,
}

/// Maximum size of a weights file in bytes: ten times that of NBV-Net in 32 bits.
const MAX_WEIGHTS_BYTES: u64 = 1 << 26;

impl NbvNetConfig {
    /// Builds the planner. Fails if the weights cannot be read.
    pub fn planner(&self) -> Result<NbvNet, Fault> {
        let Some(path) = &self.weights else { return Ok(NbvNet::default()) };
        let file = files::read(path, MAX_WEIGHTS_BYTES)?;
        let network = Network::from_safetensors(&file).map_err(|e| {
            Fault::data(e)
                .in_file(path)
                .with_remedy("training/nbv_net.py trains such weights and converts published ones")
        })?;
        Ok(NbvNet::new(network))
    }
}

/// The fault of the planner inspection without a CAD model.
pub(super) fn no_reference() -> Fault {
    let fault = Fault::request("the planner inspection needs the CAD model of the part");
    fault.with_remedy("set `reference.mesh`")
}
