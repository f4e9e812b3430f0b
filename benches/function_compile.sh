#!/usr/bin/env bash
# What compiling and calling user functions takes, written out as WGSL and interpreted: scenes of N different functions that each call noise once, as surfaces
# and as pigments. Prints N, kind, form, seconds of compiling (the longest kernel), of rendering, and CPU seconds of the whole run, which renders twice.
# llvmpipe compiles when a kernel is first used: its rendering is mostly that, and CPU seconds are what to look at.
# usage: benches/function_compile.sh RAYLOOM [SIZE [LIMIT [N...]]]     (RAYLOOM_SOFTWARE=1 takes lavapipe; LIMIT: seconds for one scene)
set -u
rayloom=$1; size=${2:-640x480}; limit=${3:-60}; shift $(($# < 3 ? $# : 3))
counts=("$@"); [ ${#counts[@]} -gt 0 ] || counts=(4 8 16 32 64)
work=$(mktemp -d); trap 'rm -rf "$work"' EXIT
export RAYLOOM_PIPELINES= __GL_SHADER_DISK_CACHE=0 MESA_SHADER_CACHE_DISABLE=true
scene() { # N KIND
  awk -v n="$1" -v kind="$2" 'BEGIN {
    print "#version 3.7; global_settings { assumed_gamma 1 } camera { location <0, 6, -14> look_at 0 } light_source { <20, 30, -20> rgb 1 }"
    print "#declare N = function { internal(76) }"
    for (k = 0; k < n; k++) {
      text = "N(x*2, y*2, z*2)"
      # The shapes of no two are the same.
      for (b = k + 64; b > 0; b = int(b / 2)) text = (b % 2 ? "sin(" : "cos(") text ")"
      at = sprintf("translate <%g, 0, %g>", (k % 8) * 2.4 - 8.4, int(k / 8) * 2.4 - 3)
      if (kind == "surfaces")
        printf "isosurface { function { y + 0.6*(%s) } max_gradient 3 contained_by { box { -1, 1 } } pigment { rgb 0.8 } %s }\n", text, at
      else
        printf "sphere { 0, 1.1 pigment { function { %s } color_map { [0 rgb x][1 rgb z] } } %s }\n", text, at
    } }'
}
TIMEFORMAT=%U
echo "| functions | as | form | compiled s | rendered s | CPU s |"; echo "|---|---|---|---|---|---|"
for kind in pigments surfaces; do
  for n in "${counts[@]}"; do
    scene "$n" "$kind" > "$work/$kind.pov"
    for form in interpreted:0 written:1000000; do
      { time RAYLOOM_GPU_FUNCTIONS=${form#*:} timeout "$limit" "$rayloom" bench stages "$work/$kind.pov" --size "$size" --antialias off --backend gpu \
        ${RAYLOOM_SOFTWARE:+--software} >"$work/out" 2>&1; } 2>"$work/cpu"
      awk -v n="$n" -v kind="$kind" -v form="${form%:*}" -v cpu="$(tail -1 "$work/cpu")" -v limit="$limit" '
        $2 + 0 > most && $3 ~ /^[0-9]+$/ { most = $2 + 0 } / s rendering, / { seconds = $1 }
        END { if (seconds) printf "| %s | %s | %s | %.2f | %s | %s |\n", n, kind, form, most, seconds, cpu; else printf "| %s | %s | %s | not done in %s s | | %s |\n", n, kind, form, limit, cpu }' "$work/out"
    done
  done
done
