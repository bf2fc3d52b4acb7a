"""Scans a mesh with a simulated camera: ten views, and what they show of the object.

python 01_scan.py [MESH]
"""

import sys

import nextview

mesh = sys.argv[1] if len(sys.argv) > 1 else "builtin:teapot"
done = nextview.scan(
    mesh,
    candidates=200,
    on_step=lambda step: print(f"view {step['step']}: {100 * step['reachable_coverage']:.1f} % seen"),
)
assert done.cloud is not None and done.mesh is not None

print(f"skill {done.record['skill']:.2f} (0 = random views, 1 = knows the object)")
print(f"{len(done.cloud.points)} points, {len(done.mesh.triangles)} triangles")
assert done.record["reachable_coverage"] > 0.7
