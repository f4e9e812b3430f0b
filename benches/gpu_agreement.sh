#!/usr/bin/env bash
# Renders scenes on the CPU and on the GPU with the same command, compares the pictures, prints a table in Markdown.
# usage: benches/gpu_agreement.sh RAYLOOM WxH SCENE...        (times are rayloom's own, of the render stage: --stats)
set -u
rayloom=$1; size=$2; shift 2
work=$(mktemp -d); trap 'rm -rf "$work"' EXIT
seconds() { sed -n 's/.*"render": \([0-9.e-]*\).*/\1/p' "$1" 2>/dev/null | head -1; }
"$rayloom" info 2>/dev/null | sed 's/^/# /'
echo "| scene ($size) | pixels within 2/255 | CPU s | GPU s, first | GPU s, again | note |"
echo "|---|---|---|---|---|---|"
for scene in "$@"; do
  name=$(basename "$scene")
  render() { "$rayloom" render "$scene" -o "$work/$1.png" --size "$size" --backend "$2" --stats "$work/$1.json" --progress none 2>"$work/$1.log"; }
  render cpu cpu || { echo "| $name | - | failed | | | $(grep -m1 error "$work/cpu.log") |"; continue; }
  render gpu gpu || { echo "| $name | - | $(seconds "$work/cpu.json") | failed | | $(grep -m1 error: "$work/gpu.log") |"; continue; }
  note=$(grep -m1 -o 'rendered on the CPU.*' "$work/gpu.log")
  render again gpu
  share=$("$rayloom" diff "$work/cpu.png" "$work/gpu.png" --fail 0.0079 --percent 0.5 --json 2>/dev/null | sed -n 's/.*"percent_beyond_fail": *\([0-9.e-]*\).*/\1/p' | head -1)
  within=$(awk -v b="${share:-nan}" 'BEGIN { printf b == "nan" ? "?" : "%.3f %%", 100 - b }')
  echo "| $name | $within | $(seconds "$work/cpu.json") | $(seconds "$work/gpu.json") | $(seconds "$work/again.json") | $note |"
done
