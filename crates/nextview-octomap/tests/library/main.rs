//! Files of OctoMap: its own tools, files that others wrote, and what the paper's authors computed from theirs.

mod octomap_tools;
mod octree_files;
mod paper_weights;
