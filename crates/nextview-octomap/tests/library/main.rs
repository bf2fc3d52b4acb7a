//! Files of OctoMap: against its own tools, from other programs, and against the authors' values.

mod nonsense;
mod octomap_tools;
mod octree_files;
mod paper_weights;
