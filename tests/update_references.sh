#!/usr/bin/env bash
# Renders POV-Ray's own pictures of tests/scenes into references/povray-3.7.0.10/.
# Needs Debian's povray 1:3.7.0.10 (`apt-get install povray povray-includes`). Give case names (area/name) to renew those alone.
set -eu
cd "$(dirname "$0")/scenes"
out=$PWD/../../references/povray-3.7.0.10
for f in ${*:-$(find . -name '*.pov' | sort)}; do
  f=${f#./}; f=${f%.pov}
  opts=$(sed -n 's|^// options: ||p' "$f.pov" | head -1)
  mkdir -p "$out/$(dirname "$f")"
  povray +I"$f.pov" +O"$out/$f.png" +W128 +H96 +FN -D -P +WT1 -A $opts >/dev/null 2>/tmp/povray.log || { echo "$f failed"; tail -5 /tmp/povray.log; exit 1; }
done
