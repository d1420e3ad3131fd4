#!/bin/bash
# Source, size and checksum in scenes/README.md of every file of a scene.
set -u
root=$1
data=${PALPA_SHARED:-$root/../shared}/data
failures=0
fail() {
  printf 'FAILED: %s\n' "$*" >&2
  failures=$((failures + 1))
}
rows=$(sed -n 's/^|[^|]*| `\([^`]*\)` | \([0-9]*\) | `\([0-9a-f]*\)` | [^|]* | [^|]* |$/\1 \2 \3/p' "$root/scenes/README.md")
named=0
for scene in "$root"/scenes/*.toml "$root"/scenes/tools/*.toml; do
  while read -r file; do
    named=$((named + 1))
    grep -q "^$file " <<<"$rows" || fail "${scene##*/} reads $file, of which scenes/README.md says nothing"
    grep -q "^#.*scenes/README.md" "$scene" || fail "${scene##*/} does not say where $file comes from"
  done < <(sed -n 's/^file *= *"\([^"]*\)".*/\1/p' "$scene")
done
[ "$named" -gt 0 ] || fail "no scene reads a file"
if [ -d "$data" ]; then
  while read -r file bytes checksum; do
    [ "$(stat -c %s "$data/$file")" = "$bytes" ] || fail "$file has $(stat -c %s "$data/$file") bytes"
    [ "$(sha256sum <"$data/$file")" = "$checksum  -" ] || fail "$file has another checksum"
  done <<<"$rows"
else
  echo "sizes and checksums are left out: $data is not there"
fi
[ "$failures" = 0 ]
