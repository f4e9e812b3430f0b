#!/usr/bin/env bash
# The fastest program that this source makes: guided by a profile of the project's own scenes, for processors with AVX2.
#
#   benches/pgo.sh [OUT]      OUT: target/rayloom-pgo
#
# Two release builds (ten minutes and more each on two cores), and half a minute of rendering tests/scenes in between. Only this crate is
# built anew: the wrapper adds its flags to workspace members. CPU=x86-64 makes it run on any x86-64 processor. The pictures are the same.
# Needs rustup's component llvm-tools, and POV-Ray's include files where scenes ask for them (those that fail are no loss).
set -euo pipefail
cd "$(dirname "$0")/.."
out=${1:-target/rayloom-pgo}
cpu=${CPU:-x86-64-v3}
tools=$(dirname "$(find "$(rustc --print sysroot)" -name llvm-profdata -print -quit)")
[ -x "$tools/llvm-profdata" ] || { echo "llvm-profdata is missing: rustup component add llvm-tools"; exit 1; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

build() { # FLAGS...: a release build of this crate with more flags for rustc
    printf '#!/bin/bash\nexec "$@" %s\n' "$*" >"$work/rustc"
    chmod +x "$work/rustc"
    RUSTC_WORKSPACE_WRAPPER="$work/rustc" cargo build --release --bin rayloom
}

build "-Cprofile-generate=$work/raw"
cp target/release/rayloom "$work/trained"
find tests/scenes -name '*.pov' | sort | while read -r scene; do
    (cd "$(dirname "$scene")" && LLVM_PROFILE_FILE="$work/raw/%p-%m.profraw" timeout 20 "$work/trained" povray "+I$(basename "$scene")" \
        "+O$work/picture.png" +W96 +H72 -A -D +WT1 >"$work/log" 2>&1) || true
done
"$tools/llvm-profdata" merge -o "$work/profile" "$work"/raw/*.profraw
build "-Cprofile-use=$work/profile -Ctarget-cpu=$cpu"
cp target/release/rayloom "$out"
echo "$out"
