"""Compares three planners on two objects."""

import numpy as np

import nextview

PLANNERS = ["most-surface", "max-flow", "random"]

done = nextview.bench(
    {
        "name": "three-planners",
        "objects": ["builtin:mug", "builtin:bracket"],
        "scan": {"views": 6, "candidates": 100, "voxel_size_m": 0.01},
        "variant": [{"scan": {"planner": planner}} for planner in PLANNERS],
    }
)
assert done.failed == []

# `pandas.DataFrame(done.runs)` and `polars.DataFrame(done.runs)` make tables of these columns.
names = np.array(done.runs["variant"])
skill = {planner: float(done.runs["skill"][names == planner].mean()) for planner in PLANNERS}
for planner in PLANNERS:
    print(f"{planner:<14} skill {skill[planner]:5.2f}")
assert skill["most-surface"] > skill["random"]
