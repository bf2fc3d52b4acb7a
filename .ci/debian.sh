#!/usr/bin/env bash
# Installs packages of Debian, as far as that is possible here.
set -euo pipefail
as_root=()
[ "$(id -u)" -eq 0 ] || as_root=(sudo -n)
if "${as_root[@]}" apt-get update -qq &&
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "$@" >/dev/null; then
    echo "installed $*"
else
    echo "cannot install $* here: continuing without it; checks that need it will be SKIPPED or fail"
fi
