#!/usr/bin/env bash
# Checks what build.sh made: checksums, no symbol of a newer glibc, the archive's program, completions, manual pages
# and list of parts, and the wheel.
# Usage: check.sh OUT PYTHON; the Python needs cyclonedx-python-lib[json-validation], objdump is of binutils.
set -euo pipefail
out=$(realpath "$1")
python=$(realpath -s "$2")
here=$(realpath "$(dirname "${BASH_SOURCE[0]}")")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

# The highest version of glibc that a file needs, which must not be above 2.17.
needs_no_new_glibc() {
    local highest
    highest=$(objdump -T "$1" | grep -o 'GLIBC_[0-9.]*' | sort -uV | tail -1)
    echo "$(basename "$1") needs ${highest:?no symbol of glibc: not the expected file}"
    [ "$(printf '%s\n' GLIBC_2.17 "$highest" | sort -V | tail -1)" = GLIBC_2.17 ]
}

(cd "$out" && sha256sum --check --quiet SHA256SUMS)

tar -xzf "$out"/nextview-*-linux-gnu.tar.gz
cd nextview-*-linux-gnu
needs_no_new_glibc nextview
./nextview --version
./nextview scan builtin:mug --views 3 --candidates 50 --out "$work/mug" | tail -1
bash -n completions/nextview.bash
for file in LICENSE-MIT LICENSE-APACHE NOTICE LICENSES-THIRD-PARTY.txt completions/nextview.zsh man/man1/nextview-scan.1; do
    [ -s $file ]
done
"$python" "$here/check_sbom.py" sbom.cdx.json

"$python" -m zipfile -e "$out"/nextview-*-manylinux*2014*.whl "$work/wheel"
needs_no_new_glibc "$work"/wheel/nextview/_native*.so
echo "release checked"
