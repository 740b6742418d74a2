#!/usr/bin/env bash
# The package on Linux aarch64, under user-mode emulation on a Debian machine of another processor.
#
#     scripts/aarch64.sh                 the smoke test of two arms and the kernels' tests
#     scripts/aarch64.sh FILE ...        any Python program
#
# Run it in the project's virtual environment. The first run downloads 540 MB into FTCFA_AARCH64
# (by default ~/.cache/ftcfa-aarch64): the emulator and an arm64 Python from Debian's packages, and
# the wheels of this environment's packages for aarch64. Nothing is installed on this machine, and
# no root is needed. Where something cannot be had, it says what, and exits with 77 (skipped).
set -euo pipefail

root=$(cd "$(dirname "$0")/.." && pwd)
folder=${FTCFA_AARCH64:-${XDG_CACHE_HOME:-$HOME/.cache}/ftcfa-aarch64}
site=$folder/root/usr/lib/python3/dist-packages
unneeded="build|glfw|hatchling|mujoco|mypy|pdoc|pip|pre_commit|ruff|setuptools"
unneeded+="|embreex|manifold3d|vhacdx" # without a wheel for aarch64

skip() {
  echo "skipped: $1" >&2
  exit 77
}

arm64() { # apt-get as on an arm64 machine on which nothing is installed
  apt-get -qq -y -o APT::Architecture=arm64 -o APT::Architectures=arm64 -o Debug::NoLocking=1 \
    -o Dir::State::status="$folder/apt/status" -o Dir::State::Lists="$folder/apt/lists" \
    -o Dir::Cache="$folder/apt/cache" "$@"
}

unpack() { # the packages DEB ... into the folder TO
  local to=$1 && shift
  for deb in "$@"; do dpkg-deb -x "$deb" "$to"; done
}

machine() { # the emulator and an arm64 Python
  command -v apt-get > /dev/null || skip "apt-get is not here; the emulator is taken from Debian"
  mkdir -p "$folder"/{root,emulator} "$folder"/apt/{lists,cache/archives}/partial
  touch "$folder/apt/status"
  (cd "$folder/apt" && apt-get -qq download qemu-user-static 2> /dev/null) ||
    skip "the package qemu-user-static cannot be downloaded (apt-get update?)"
  arm64 update && arm64 --download-only --no-install-recommends install python3 libgomp1 libstdc++6 \
    > /dev/null || skip "arm64's Python cannot be downloaded"
  unpack "$folder/emulator" "$folder"/apt/qemu-user-static*.deb
  unpack "$folder/root" "$folder"/apt/cache/archives/*.deb
}

wheels() { # this environment's packages, and the project itself
  local version platforms=() wanted=$folder/wanted.txt
  version=$(cd "$folder/root/usr/lib" && echo python3.* | sed 's/python//')
  python -c "import sys; sys.exit(sys.version_info[:2] != tuple(map(int, '$version'.split('.'))))" ||
    skip "Debian's Python is $version, this environment has $(python --version)"
  for glibc in 2_17 2_27 2_28 2_34; do platforms+=(--platform "manylinux_${glibc}_aarch64"); done
  python -m pip list --format=freeze --exclude ftcfa | grep -vE "^($unneeded)" > "$wanted"
  cmp -s "$wanted" "$folder/installed.txt" && return
  rm -rf "$site" && mkdir -p "$site"
  python -m pip install --quiet --no-deps --no-compile --only-binary=:all: --target "$site" \
    --python-version "$version" "${platforms[@]}" -r "$wanted" || skip "wheels for aarch64 are missing"
  cp "$wanted" "$folder/installed.txt"
}

[ -e "$folder/emulator/usr/bin/qemu-aarch64-static" ] || machine
wheels
rm -rf "$site"/ftcfa*
python -m pip install --quiet --no-deps --no-compile --target "$site" "$root"

if [ $# -eq 0 ]; then
  cd "$root"
  set -- -m pytest -q -o addopts= -p no:cacheprovider -p no:xdist \
    -k "test_kernels or over_a_second and (double_pendulum or panda)" \
    tests/engine/test_compiled.py tests/engine/compiler/test_kernels.py
fi
exec "$folder/emulator/usr/bin/qemu-aarch64-static" -L "$folder/root" \
  "$folder/root/usr/bin/python3" "$@"
