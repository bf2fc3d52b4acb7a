#!/usr/bin/env bash
# Installs the package into a virtual environment of its own, and runs everything that it must pass: tests,
# types, doctests, examples. With a program `nextview` (NEXTVIEW_PROGRAM), its results are compared with the
# program's. With `--full`, the packages that it works with are installed, too: tests that need one are skipped
# without it.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
venv=${NEXTVIEW_VENV:-target/venv}
[ -d "$venv" ] || python3 -m venv "$venv"
venv=$(cd "$venv" && pwd)
"$venv/bin/pip" install --quiet --upgrade pip
"$venv/bin/pip" install --quiet pytest hypothesis mypy gymnasium
[ "${1:-}" != --full ] || "$venv/bin/pip" install --quiet -r tests/requirements-full.txt
start=$SECONDS
# Built as the tests of the workspace are, in their folder: what they have in common is compiled once.
MATURIN_PEP517_ARGS="--profile dev" CARGO_TARGET_DIR=$PWD/../target \
    "$venv/bin/pip" install --quiet --force-reinstall --no-deps .
"$venv/bin/pip" install --quiet numpy
echo "installed in $((SECONDS - start)) s"

# Not from here, so that the installed package is tested and not the sources.
here=$PWD
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cp -r tests examples pyproject.toml "$work"
cd "$work"
"$venv/bin/python" -m pytest -q -rs tests
# Hostile values for every argument: a sample of the calls, or more than 10,000 of them.
[ "${1:-}" = --full ] && every=9 || every=499
"$venv/bin/python" tests/boundary.py "$here/../crates/nextview-scan/schema/scan_config.json" --every $every
"$venv/bin/python" -m mypy --strict examples/*.py
"$venv/bin/python" -m mypy --strict "$here/nextview"
"$venv/bin/python" -m mypy.stubtest nextview._native
for module in "" .errors ._names ._camera ._planner ._scan ._simulated ._bench ._export .gym; do
    "$venv/bin/python" -c "import doctest, importlib, sys
failed, n = doctest.testmod(importlib.import_module('nextview$module'))
print('nextview$module:', n, 'doctest lines'); sys.exit(failed > 0)"
done
for example in examples/*.py; do
    echo "--- $example"
    [[ $example == *server.py ]] || "$venv/bin/python" "$example"
done
echo "--- docs/start.md"
awk '/^```python$/ { on = 1; next } /^```$/ { on = 0 } on' "$here/../docs/start.md" >start.py
"$venv/bin/python" start.py
if [ -z "${NEXTVIEW_PROGRAM:-}" ]; then
    "$here/../.ci/skipped" 09_server.py nextview "needs the program in NEXTVIEW_PROGRAM"
    exit
fi
"$NEXTVIEW_PROGRAM" serve --listen 127.0.0.1:0 --dir scans >printed &
server=$!
trap 'kill $server; rm -rf "$work"' EXIT
until grep -q '^page: ' printed; do
    kill -0 $server
    sleep 0.05
done
"$venv/bin/python" examples/09_server.py "$(sed -n 's/^listening on //p' printed)"
