#!/usr/bin/env bash
# The Blender extension, headless: builds the zip, installs it in fresh profiles, renders by F12's operator, checks pixels.
#   tests/blender/run.sh [VERSION] [--scenes DIR] [CASE ...]      VERSION of the bpy module: 4.5 (default), 4.2, 5.0
# Downloads the bpy module once (350 MB, from PyPI, Python 3.11) into target/blender/. RAYLOOM_BINARY: a renderer that is already built.
# Exit code 77: the module can't be had here (no Python 3.11, no way to PyPI, a system library that it needs), so nothing was tested.
set -euo pipefail
cd "$(dirname "$0")/../.."
version=4.5
if [[ "${1:-}" =~ ^[0-9]+\.[0-9]+$ ]]; then version=$1; shift; fi
venv=${RAYLOOM_BPY_VENV:-target/blender/venv-$version}
if ! "$venv/bin/python" -c 'import bpy' >/dev/null 2>&1; then
  if ! { python3.11 -m venv "$venv" && "$venv/bin/pip" install --quiet "bpy==$version.*" numpy jsonschema OpenEXR && "$venv/bin/python" -c 'import bpy'; }; then
    echo "the bpy module $version can't be had here" >&2
    exit 77
  fi
fi
binary=${RAYLOOM_BINARY:-}
if [ -z "$binary" ]; then cargo build; binary=target/debug/rayloom; fi
"$venv/bin/python" addons/build.py --binary "$binary" --output target/blender
zip=$(ls -t target/blender/rayloom_blender-*.zip | head -1)
exec "$venv/bin/python" tests/blender/run_cases.py --zip "$zip" "$@"
