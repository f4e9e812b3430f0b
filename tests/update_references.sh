#!/usr/bin/env bash
# Renders POV-Ray's own pictures of tests/scenes into references/povray-3.7.0.10/.
# Needs Debian's povray 1:3.7.0.10 (`apt-get install povray povray-includes`). Give case names (area/name) to renew those alone.
set -eu
cd "$(dirname "$0")/scenes"
out=$PWD/../../references/povray-3.7.0.10
for f in ${*:-$(find . -name 'scene.pov' -printf '%h\n' | sort)}; do
  f=${f#./}
  opts=$(sed -n 's|^options = "\(.*\)"|\1|p' "$f/test.toml")
  mkdir -p "$out/$(dirname "$f")"
  (cd "$f" && povray +Iscene.pov +O"$out/$f.png" +W128 +H96 +FN -D -P +WT1 -A $opts) >/dev/null 2>/tmp/povray.log || { echo "$f failed"; tail -5 /tmp/povray.log; exit 1; }
done
