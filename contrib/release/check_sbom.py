"""Checks that the list of the program's parts is complete and follows the schema of CycloneDX 1.6.

Usage: check_sbom.py SBOM; needs cyclonedx-python-lib[json-validation].
"""

import json
import sys
from pathlib import Path

from cyclonedx.schema import SchemaVersion
from cyclonedx.validation.json import JsonStrictValidator

text = Path(sys.argv[1]).read_text()
fault = JsonStrictValidator(SchemaVersion.V1_6).validate_str(text)
if fault is not None:
    sys.exit(f"{sys.argv[1]}: {fault}")
bom = json.loads(text)
crates = bom["components"]
for crate in crates:
    is_ours = crate["name"].startswith("nextview")
    if "hashes" not in crate and not is_ours:
        sys.exit(f"{sys.argv[1]}: {crate['purl']} has no checksum")
known = {crate["bom-ref"] for crate in [*crates, bom["metadata"]["component"]]}
linked = {ref for node in bom["dependencies"] for ref in [node["ref"], *node["dependsOn"]]}
if known != linked:
    sys.exit(f"{sys.argv[1]}: crates without a place in the graph: {sorted(known ^ linked)}")
print(f"{len(crates)} crates, {sum(crate['scope'] == 'required' for crate in crates)} of them in the program")
