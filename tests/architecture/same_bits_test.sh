#!/bin/bash
# Byte-identical sessions: ticks of this build and of an unoptimised build, and the trace of a repeated run. Compared: all
# numbers of ticks and primitives, and every CSV of the trace but timing.csv.
set -u
root=$1
build=$2
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
status=0

feel_by_both_builds() {  # feel_by_both_builds NAME ARGUMENTS…
  local name=$1 suffix
  shift
  for suffix in "" _unoptimised; do
    "$build/tests/ticks_to_compare$suffix" "$@" >"$folder/$name$suffix" || exit 1
  done
  cmp "$folder/$name" "$folder/${name}_unoptimised" || status=1
  [ "$(wc -l <"$folder/$name")" -gt 2000 ] || { printf 'too few ticks to compare\n'; status=1; }
  printf '%s, by both builds: %d lines compared\n' "$name" "$(wc -l <"$folder/$name")"
}
run_twice() {  # run_twice NAME ARGUMENTS…
  local name=$1 time file compared=0
  shift
  for time in once twice; do
    if ! "$build/bin/palpa" run "$@" --out "$folder/$name-$time" >"$folder/said" 2>&1; then
      cat "$folder/said"
      exit 1
    fi
  done
  for file in "$folder/$name-once"/*.csv; do
    [ "${file##*/}" = timing.csv ] && continue
    compared=$((compared + 1))
    cmp "$file" "$folder/$name-twice/${file##*/}" || status=1
  done
  [ "$(wc -l <"$folder/$name-once/ticks.csv")" -gt 1000 ] || { printf 'too few ticks to compare\n'; status=1; }
  printf '%s, twice: %d files compared\n' "$name" "$compared"
}

feel_by_both_builds phantom "$root/scenes/head_phantom.toml" sim:stroke 2
if [ -x "$build/bin/palpa" ]; then run_twice phantom "$root/scenes/head_phantom.toml" --hand sim:stroke --duration-s 2 --primitives; fi

data=${PALPA_SHARED:-$root/../shared}/data
hand=$data/trajectories/inverse3_woodcarving_20231121_102837.csv
if [ -x "$build/bin/palpa-read" ] && [ -d "$data/ct_head_cranium" ]; then
  export PALPA_READER=$build/bin/palpa-read
  feel_by_both_builds head "$root/scenes/head.toml" "$hand" 2 "$data"
  run_twice head "$root/scenes/head.toml" --data "$data" --primitives --duration-s 2 --hand-hold firm --hand "$hand"
fi
exit $status
