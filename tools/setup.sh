# Shared parts of ./demo and ./test: package installation and build. Sourced by them, never run by itself. Needs from the
# sourcing script: $root (the repository), $command and $arguments (the user's call), $assume_yes (true or false) and $preset
# (for messages on a build by hand).
# shellcheck shell=bash disable=SC2154

added_list=$root/build/packages-added.txt  # beside the build folders, so that no rebuild clears it
jobs=$(nproc)
launcher=()  # prefix of compile and test commands

say() { printf '%s\n' "$*"; }
fail() {
  printf '%s: %s\n' "${command##*/}" "$*" >&2
  exit 2
}

# True if root's commands run without a password: as root, or by sudo.
is_root_at_hand() { [ "$(id -u)" = 0 ] || sudo -n true 2>/dev/null; }

# Continues only with a yes. Without a terminal no answer means yes where root's commands need no password, as in a container or
# on a CI machine; elsewhere it ends with a line of help.
ask() {
  if $assume_yes; then return; fi
  if [ ! -t 0 ]; then
    is_root_at_hand || fail "there is no terminal to answer at, and sudo needs a password; run in a terminal: $command${arguments:+ $arguments}"
    say "There is no terminal to answer at: going on as with --yes."
    return
  fi
  local answer
  read -r -p "$1 [Y/n] " answer || answer=n
  case $answer in
    '' | [Yy]*) ;;
    *)
      say "Nothing was installed."
      exit 1
      ;;
  esac
}

# The packages of the named groups, from packages.txt.
packages_of() {
  awk -v wanted=" $* " '/^\[/ { on = index(wanted, " " substr($0, 2, length($0) - 2) " ") } /^[a-z]/ && on { print $1 }' \
    "$root/packages.txt"
}

installed_packages() { dpkg-query -W -f '${db:Status-Abbrev} ${Package}\n' | awk '$1 == "ii" { print $2 }' | LC_ALL=C sort -u; }

# Apt's plan for these packages. Requests addresses only: the one command that never installs, under any configuration of apt,
# and needs no rights.
plan_for() { LC_ALL=C apt-get install --print-uris --no-install-recommends "$@" 2>&1; }

as_root() { if [ "$(id -u)" = 0 ]; then "$@"; else sudo "$@"; fi; }

record_added_packages() {
  trap - EXIT
  { installed_packages | LC_ALL=C comm -13 <(printf '%s\n' "$1") -; cat "$added_list" 2>/dev/null; } |
    LC_ALL=C sort -u >"$added_list.new"
  mv "$added_list.new" "$added_list"
}

# Installs missing packages of the named groups; lists them and asks for confirmation first.
install_packages() {
  local wanted missing plan count download disk before updated=false log=$root/build/apt.log
  mapfile -t wanted < <(packages_of "$@")
  if ! command -v apt-get >/dev/null || ! command -v dpkg-query >/dev/null; then
    fail "no apt here: this script installs packages on Debian 12 and its kin only. Elsewhere, install what these
  packages bring (${wanted[*]}),
  then build by hand in $root:
    cmake --preset $preset && cmake --build --preset $preset
  and find the program palpa in build/$preset/bin, or run the tests with: ctest --preset $preset"
  fi
  mapfile -t missing < <(printf '%s\n' "${wanted[@]}" | LC_ALL=C sort -u | LC_ALL=C comm -23 - <(installed_packages))
  [ ${#missing[@]} -gt 0 ] || return 0

  if [ "$(id -u)" != 0 ] && ! command -v sudo >/dev/null; then
    fail "packages are missing, and only root may install them (there is no sudo here). As root, run:
    apt-get update && apt-get install --no-install-recommends ${missing[*]}
  then run $command again"
  fi
  if ! plan=$(plan_for "${missing[@]}"); then
    say "apt does not know all of these packages yet: ${missing[*]}"
    ask "Fetch the current package lists first (apt-get update, about 10 MB)?"
    as_root apt-get update || say "apt-get update reported errors; going on with the lists that are there."
    updated=true
    plan=$(plan_for "${missing[@]}") || fail "apt cannot install these packages; they are those of Debian 12 and 13 (main):
$(printf '%s\n' "$plan" | grep '^E:')"
  fi
  count=$(printf '%s\n' "$plan" | sed -n 's/.* \([0-9]*\) newly installed.*/\1/p')
  download=$(printf '%s\n' "$plan" | sed -n 's|^Need to get \([^/]*\).* of archives\.$|\1|p')
  disk=$(printf '%s\n' "$plan" | sed -n 's/^After this operation, \(.*\) of additional disk space will be used\.$/\1/p')
  say "Palpa needs these Debian packages: ${missing[*]}"
  say "With what they need themselves that makes $count packages: $download to download, $disk on disk."
  ask "Install them?"

  mkdir -p "$root/build"
  before=$(installed_packages)
  trap 'record_added_packages "$before"' EXIT
  say "Installing; waiting for the download. What apt says goes to build/apt.log."
  # A failing foreign source does not stop the script: apt-get install reports missing packages.
  $updated || as_root apt-get update >"$log" 2>&1 || true
  if ! as_root env DEBIAN_FRONTEND=noninteractive apt-get install --yes --no-install-recommends "${missing[@]}" >>"$log" 2>&1; then
    tail -n 15 "$log" >&2
    fail "apt-get install failed (above: its last words); run it by hand to see more:
    sudo apt-get install --no-install-recommends ${missing[*]}"
  fi
  record_added_packages "$before"
}

# True if a configured folder has all of these KEY=VALUE options.
has_options() {
  local folder=$1 option
  shift
  [ -f "$folder/build.ninja" ] || return 1
  for option in "$@"; do grep -q "^${option%%=*}:[A-Z]*=${option#*=}\$" "$folder/CMakeCache.txt" || return 1; done
}

# Filters a build's output. Of its steps "[12/340] Building …" a terminal shows the number of finished steps and an estimate of
# the remaining time, on one line that is overwritten; elsewhere a line appears every half minute. All else is passed on
# unchanged.
follow_build() {
  local line step=0 steps left begin=$SECONDS said=$SECONDS terminal=false
  if [ -t 1 ]; then terminal=true; fi
  while IFS= read -r line || [ -n "$line" ]; do
    if [[ $line =~ ^\[([0-9]+)/([0-9]+)\]\  ]]; then
      step=${BASH_REMATCH[1]} steps=${BASH_REMATCH[2]}
      left=$(((SECONDS - begin) * (steps - step) / (step > 0 ? step : 1)))
      if [ $left -ge 90 ]; then left="$(((left + 30) / 60)) min"; else left="$left s"; fi
      if $terminal; then
        printf '\r\033[K%s of %s steps done, about %s left' "$step" "$steps" "$left"
      elif [ $((SECONDS - said)) -ge 30 ]; then
        said=$SECONDS
        say "$step of $steps steps done, about $left left"
      fi
    else
      if $terminal && [ "$step" != 0 ]; then printf '\r\033[K'; fi
      say "$line"
    fi
  done
  if $terminal && [ "$step" != 0 ]; then printf '\r\033[K'; fi
}

# build PRESET "NEEDS" "AT FIRST" TARGET…: builds the targets of a preset. NEEDS are required options of the folder; those AT
# FIRST only spare a fresh folder work, and an existing folder keeps its own.
build() {
  local preset=$1 needs first folder=$root/build/$1 option options=()
  read -ra needs <<<"$2"
  read -ra first <<<"$3"
  shift 3
  if ! has_options "$folder" "${needs[@]}"; then
    [ -f "$folder/build.ninja" ] || options=("${first[@]}")
    options+=("${needs[@]}")
    say "Configuring build/$preset."
    mkdir -p "$folder"
    if ! (cd "$root" && cmake --preset "$preset" "${options[@]/#/-D}") >"$folder/configure.log" 2>&1; then
      tail -n 25 "$folder/configure.log" >&2
      fail "CMake could not configure build/$preset (above: its last words, all of them in $folder/configure.log)"
    fi
  fi
  "${launcher[@]}" cmake --build "$folder" --parallel "$jobs" --target "$@" 2>&1 | follow_build
  [ "${PIPESTATUS[0]}" = 0 ] || fail "build/$preset did not compile (above: what the compiler said)"
}
