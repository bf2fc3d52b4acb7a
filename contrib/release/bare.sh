#!/usr/bin/env bash
# Runs a command of README where there is nothing but Rust and a linker: no shell, no git, no Python, no pkg-config, no
# network. Packages are fetched before. Prints what the command prints, and how long it took.
# Usage, as root on Linux: bare.sh [COMMAND...]; by default `cargo run --release -- scan`.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
[ $# -gt 0 ] || set -- cargo run --release -- scan
root=$(mktemp -d)
trap 'rm -rf --one-file-system "$root"' EXIT

cargo fetch --locked --quiet
mkdir "$root/source"
git archive HEAD | tar -x -C "$root/source"

# The toolchain, the packages, and the compiler driver with all that it calls to link.
rust=$(rustc --print sysroot)
registry=${CARGO_HOME:-$HOME/.cargo}/registry
visible=("$rust" "$registry" /lib64 /usr/lib64 /lib/x86_64-linux-gnu /usr/lib/x86_64-linux-gnu /usr/lib/gcc /usr/libexec/gcc)
for tool in cc ld; do
    visible+=("/usr/bin/$tool" "$(readlink -f "/usr/bin/$tool")")
done

export root rust registry
export visible_paths="${visible[*]}"
unshare --mount --net -- bash -euo pipefail -c '
    for path in $visible_paths; do
        [ -e "$path" ] || continue
        if [ -d "$path" ]; then mkdir -p "$root$path"; else mkdir -p "$root${path%/*}"; touch "$root$path"; fi
        mount --bind "$path" "$root$path"
    done
    mkdir -p "$root/dev" "$root/proc" "$root/tmp" "$root/cargo"
    mount --bind /dev "$root/dev"
    mount --bind /proc "$root/proc"
    mkdir -p "$root/cargo/registry"
    mount --bind "$registry" "$root/cargo/registry"
    time env -i PATH="$rust/bin:/usr/bin" HOME=/tmp CARGO_HOME=/cargo CARGO_NET_OFFLINE=true \
        unshare --root="$root" --wd=/source "$rust/bin/$1" "${@:2}"
' bare "$@"
