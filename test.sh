#!/usr/bin/env bash
# All checks: format, lints, documentation, tests (the GPU's on lavapipe), pictures against POV-Ray's.
# Installs what it needs where it may; what it had to leave out it says in a line at the end.
set -euo pipefail
cd "$(dirname "$0")"
left_out=()
step() { printf '\n== %s\n' "$*"; "$@"; }

# A Vulkan driver that runs on any machine (Mesa's lavapipe), for the GPU tests.
if ! ls /usr/share/vulkan/icd.d/*.json >/dev/null 2>&1; then
  if command -v apt-get >/dev/null && [ "$(id -u)" = 0 ]; then
    echo "installing mesa-vulkan-drivers (lavapipe) for the GPU tests"
    { apt-get update && DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends mesa-vulkan-drivers libvulkan1; } >/dev/null 2>&1 || true
  fi
  ls /usr/share/vulkan/icd.d/*.json >/dev/null 2>&1 || left_out+=("GPU tests (no Vulkan driver; install mesa-vulkan-drivers)")
fi

if cargo fmt --version >/dev/null 2>&1; then step cargo fmt --check; else left_out+=("format check (no rustfmt)"); fi
if cargo clippy --version >/dev/null 2>&1; then
  step cargo clippy --all-targets -- -D warnings
  step cargo clippy --all-targets --no-default-features -- -D warnings
else
  left_out+=("lints (no clippy)")
fi
RUSTDOCFLAGS="-D warnings" step cargo doc --no-deps --quiet
step cargo test

echo
for what in "${left_out[@]:-}"; do [ -z "$what" ] || echo "left out: $what"; done
echo "all checks passed"
