"""A campaign with a planner of your own: each planner on three objects, with its numbers in numpy."""

import numpy as np

import nextview


class Farthest(nextview.Planner):
    """Chooses the view that is farthest from all frames so far."""

    def plan(self, situation: nextview.Situation) -> tuple[int, float]:
        positions = situation.candidates[situation.open_views, :3, 3]
        offsets = positions[:, None] - situation.frame_poses[None, :, :3, 3]
        nearest = np.linalg.norm(offsets, axis=2).min(axis=1)
        best = int(np.argmax(nearest))
        return int(situation.open_views[best]), float(nearest[best])


done = nextview.bench(
    {
        "name": "own-planner",
        "objects": ["builtin:mug", "builtin:bracket", "builtin:torus-knot"],
        "scan": {"views": 6, "candidates": 100, "voxel_size_m": 0.01},
        "variant": [{"sweep": {"planner": ["random", Farthest, "most-surface"]}}],
    }
)
assert done.failed == []

variants = np.array(done.runs["variant"])
skill = np.array(done.runs["skill"])
mean = {name: float(skill[variants == name].mean()) for name in np.unique(variants)}
for name, value in mean.items():
    print(f"{name:<28} mean skill {value:5.2f}")

# How the coverage grows: a row per view of each run.
of_farthest = np.array(done.steps["variant"]) == "python:__main__:Farthest"
views = np.array(done.steps["step"])[of_farthest]
coverage = np.array(done.steps["reachable_coverage"])[of_farthest]
curve = [float(coverage[views == view].mean()) for view in range(1, 7)]
print("farthest:", " ".join(f"{100 * share:.1f} %" for share in curve))

assert len(mean) == 3 and sorted(curve) == curve
assert mean["random"] < mean["python:__main__:Farthest"] < mean["most-surface"]
