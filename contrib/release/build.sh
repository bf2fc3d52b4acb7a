#!/usr/bin/env bash
# Builds what is published into a folder: an archive of the program for Linux with glibc 2.17 or newer, with
# completions, manual pages, licences and the list of its parts; the wheel and source distribution of the Python
# package; and the checksums of all. Needs Rust and Python 3.11. Zig is the linker, since that of the system would ask
# for its own glibc.
# Usage: build.sh OUT
set -euo pipefail
out=$(realpath -m "${1:?usage: build.sh OUT}")
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
target=x86_64-unknown-linux-gnu

[ -d target/release-python ] || python3 -m venv target/release-python
target/release-python/bin/pip install --quiet cargo-zigbuild ziglang
PATH=$PWD/target/release-python/bin:$PATH
# As in the wheel; names of functions are of no use to users of the program.
CARGO_PROFILE_RELEASE_STRIP=symbols cargo zigbuild --release --locked --package nextview-cli --target $target.2.17
program=target/$target/release/nextview

version=$($program -V | cut -d' ' -f2)
name=nextview-$version-$target
mkdir -p "$out"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
folder=$work/$name
mkdir -p "$folder/completions"
cp $program README.md CHANGELOG.md CITATION.cff LICENSE-APACHE LICENSE-MIT NOTICE "$folder"
for shell in bash elvish fish powershell zsh; do
    $program completions $shell >"$folder/completions/nextview.$shell"
done
$program man --out "$folder/man/man1" >/dev/null
contrib/release/sbom.py $target >"$folder/sbom.cdx.json"
contrib/release/licenses.py "$folder/sbom.cdx.json" >"$folder/LICENSES-THIRD-PARTY.txt"
# The time of the commit, so that the same program makes the same archive.
time=$(git log -1 --format=%ct 2>/dev/null || stat -c %Y Cargo.lock)
tar --sort=name --mtime="@$time" --owner=0 --group=0 --numeric-owner -C "$work" -c "$name" |
    gzip -n -9 >"$out/$name.tar.gz"

NEXTVIEW_VENV=$PWD/target/release-python python/wheel.sh >/dev/null
cp python/dist/nextview-"$version"* "$out"

cd "$out"
sha256sum nextview-"$version"* >SHA256SUMS
ls -l
