#!/usr/bin/env bash
# All checks: format, lints, documentation, tests (the GPU's on lavapipe), pictures against POV-Ray's.
# Installs what it needs where it may; what it had to leave out it says in a line at the end.
set -euo pipefail
cd "$(dirname "$0")"
left_out=()
step() { printf '\n== %s\n' "$*"; "$@"; }

# A Vulkan driver that runs on any machine (Mesa's lavapipe) for the GPU tests; POV-Ray's fonts for the text scene.
has_vulkan() { ls /usr/share/vulkan/icd.d/*.json >/dev/null 2>&1; }
has_fonts() { [ -d /usr/share/povray-3.7/include ]; }
if { ! has_vulkan || ! has_fonts; } && command -v apt-get >/dev/null && [ "$(id -u)" = 0 ]; then
  echo "installing mesa-vulkan-drivers (lavapipe) and povray-includes for the tests"
  { apt-get update && DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends mesa-vulkan-drivers libvulkan1 povray-includes; } >/dev/null 2>&1 || true
fi
# With a driver in place a test that finds no device is a failure, not a skip.
machines=()
if has_vulkan; then export RAYLOOM_REQUIRE_GPU=1; machines=(--backend cpu --backend gpu); else left_out+=("GPU tests (no Vulkan driver; install mesa-vulkan-drivers)"); fi
has_fonts || left_out+=("the text scene (no fonts of POV-Ray; install povray-includes)")

if cargo fmt --version >/dev/null 2>&1; then step cargo fmt --check; else left_out+=("format check (no rustfmt)"); fi
if cargo clippy --version >/dev/null 2>&1; then
  step cargo clippy --all-targets -- -D warnings
  step cargo clippy --all-targets --no-default-features -- -D warnings
else
  left_out+=("lints (no clippy)")
fi
RUSTDOCFLAGS="-D warnings" step cargo doc --no-deps --quiet
step cargo test
if python3 -c 'import numpy' 2>/dev/null; then
  step python3 tests/blender/test_core.py
else
  left_out+=("the Blender extension's core (no python3 with numpy)")
fi
# The extension in Blender 4.5 itself (the bpy module, 350 MB); code 77 says that the module can't be had here.
blender=0
RAYLOOM_BINARY=target/debug/rayloom step tests/blender/run.sh 4.5 || blender=$?
case $blender in
  0) ;;
  77) left_out+=("the extension in Blender (no bpy module: it wants Python 3.11 and PyPI)") ;;
  *) exit "$blender" ;;
esac
# The picture suite on both machines; its report is target/suite/report.html.
step cargo run --quiet -- suite tests/scenes --out target/suite --junit target/suite/junit.xml --quiet "${machines[@]}"

echo
for what in "${left_out[@]:-}"; do [ -z "$what" ] || echo "left out: $what"; done
echo "all checks passed"
