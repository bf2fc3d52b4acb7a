#!/usr/bin/env bash
# Builds what is published into `dist`: a wheel for Linux on x86-64 with glibc 2.17 or newer (manylinux2014),
# for Python 3.10 and all later versions, and the source distribution. Zig is the linker, since that of the
# system would ask for its own glibc.
#
# For aarch64 (untested): rustup target add aarch64-unknown-linux-gnu, then
# TARGET=aarch64-unknown-linux-gnu ./wheel.sh
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
target=${TARGET:-x86_64-unknown-linux-gnu}
venv=${NEXTVIEW_VENV:-target/wheel-venv}
[ -d "$venv" ] || python3 -m venv "$venv"
"$venv/bin/pip" install --quiet 'maturin>=1.9,<2' ziglang
PATH="$(cd "$venv" && pwd)/bin:$PATH"
maturin build --release --locked --zig --target "$target" --compatibility manylinux2014 --out dist
maturin sdist --out dist
ls -l dist
