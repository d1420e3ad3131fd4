#!/bin/bash
# The same session gives the same bytes: felt twice by this build, and once by the build without
# optimisation (build/dev, which ./test makes). Compared is every CSV of the trace but timing.csv.
set -u
root=$1
bin=$2
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
dev=$root/build/dev/bin/palpa
status=0

feel() {  # feel PROGRAM TRACE ARGUMENTS…
  local program=$1 trace=$2
  shift 2
  if ! "$program" run "$@" --out "$folder/$trace" >"$folder/said" 2>&1; then
    cat "$folder/said"
    exit 1
  fi
}
compare() {  # compare WHAT TRACE TRACE
  local file compared=0
  for file in "$folder/$2"/*.csv; do
    [ "${file##*/}" = timing.csv ] && continue
    compared=$((compared + 1))
    if ! cmp "$file" "$folder/$3/${file##*/}"; then status=1; fi
  done
  [ "$(wc -l <"$folder/$2/ticks.csv")" -gt 1000 ] || { printf 'too few ticks to compare\n'; status=1; }
  printf '%s: %d files compared\n' "$1" "$compared"
}
feel_and_compare() {  # feel_and_compare NAME ARGUMENTS…
  local name=$1
  shift
  feel "$bin/palpa" "$name-once" "$@"
  feel "$bin/palpa" "$name-twice" "$@"
  compare "$name, twice" "$name-once" "$name-twice"
  [ -x "$dev" ] || return
  feel "$dev" "$name-dev" "$@"
  compare "$name, with build/dev" "$name-once" "$name-dev"
}

feel_and_compare phantom "$root/scenes/head_phantom.toml" --hand sim:stroke --duration-s 2 --primitives

data=$root/../shared/data
if [ -x "$bin/palpa-read" ] && [ -d "$data/ct_head_cranium" ]; then
  export PALPA_READER=$bin/palpa-read  # for build/dev, which has none
  feel_and_compare head "$root/scenes/head.toml" --data "$data" --primitives --duration-s 2 --hand-hold firm \
    --hand "$data/trajectories/inverse3_woodcarving_20231121_102837.csv"
fi

if [ "$status" = 0 ] && [ ! -x "$dev" ]; then
  printf 'SKIPPED: the same twice, but build/dev is not there to compare with; ./test makes it\n'
  exit 77
fi
exit $status
