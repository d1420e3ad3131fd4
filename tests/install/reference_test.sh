#!/bin/bash
# Man page and completion contain every command and option of --help, with their values.
#   reference_test.sh PALPA
set -eu
palpa=$1
fail() {
  echo "FAILED: $*" >&2
  exit 1
}
man_text=$("$palpa" --print man | sed 's/\\-/-/g')
eval "$("$palpa" --print bash)"

# complete WORD…: completions of the last word
complete_words() {
  COMP_WORDS=(palpa "$@")
  COMP_CWORD=$#
  _palpa
  printf '%s\n' "${COMPREPLY[@]:-}"
}

commands=$("$palpa" --help | sed -n '/^Subcommands:/,/^$/s/^  \([a-z]*\) .*/\1/p')
[ "$(wc -w <<<"$commands")" -ge 5 ] || fail "--help lists no commands"
options=0
for command in '' $commands; do
  [ -z "$command" ] || grep -q "^.SS palpa $command\$" <<<"$man_text" || fail "the man page has no command $command"
  [ -z "$command" ] || complete_words "${command:0:2}" | grep -qx -e "$command" || fail "no completion of $command"
  section=$(sed -n "/^.S[HS] ${command:+palpa }${command:-OPTIONS}\$/,/^.S[HS]/p" <<<"$man_text" | sed 1d)
  for option in $("$palpa" $command --help | grep -o -E '^ +(-[a-z],)?--[a-z0-9-]+' | grep -o -e '--[a-z0-9-]*'); do
    options=$((options + 1))
    grep -q -E -e "^.B (-[a-z],)?$option( |\$)" <<<"$section" || fail "the man page has no $command $option"
    complete_words $command "${option:0:4}" | grep -qx -e "$option" || fail "no completion of $command $option"
  done
done
[ $options -gt 25 ] || fail "--help lists no options"
complete_words run --hand-hold re | grep -qx relaxed || fail "no completion of a word that an option takes"
[ -z "$(complete_words run nosuchfile)" ] || fail "a scene is completed to a word"

# Completed hands, settings and types are accepted by this program.
here=$(mktemp -d)
trap 'rm -rf "$here"' EXIT
cat >"$here/scene.toml" <<'TOML'
palpa = 1
[volume.ball]
analytic = "sphere"
[[mode]]
name = "wall"
type = "surface_and_friction"
field = "ball"
[[mode.level]]
name = "outside"
value = 0.0
TOML
touch "$here/hand.csv"
PATH=$(dirname "$palpa"):$PATH
taken() { "$palpa" run "$here/scene.toml" --hand sim:press --dry-run "$@" 2>&1 | grep -e 'unknown key' -e 'no such path' && fail "$*" || true; }
hands=$(complete_words run --hand sim:)
[ "$(wc -w <<<"$hands")" -ge 5 ] || fail "no completion of hands"
for hand in $hands; do "$palpa" run "$here/scene.toml" --dry-run --hand "$hand" >/dev/null || fail "$hand is no hand"; done
keys=$(complete_words run --hand sim:press,)
[ "$(wc -w <<<"$keys")" -ge 4 ] || fail "no completion of a hand's keys"
for key in $keys; do "$palpa" run "$here/scene.toml" --dry-run --hand "${key}1" 2>&1 | grep 'unknown key' && fail "$key"; done
complete_words run --hand "$here/h" | grep -qx "$here/hand.csv" || fail "no completion of recordings"
complete_words run --device om | grep -qx omega || fail "no completion of devices"
complete_words run --device touch,en | grep -qx touch,encoder_step_m= || fail "no completion of a device's keys"
complete_words modes vor | grep -qx vortex_plane || fail "no completion of types of modes"
complete_words info --set length_unit=c | grep -qx length_unit=cm || fail "no completion of how a file is read"
complete_words run "$here/scene.toml" --set mode. | grep -qx mode.wall. || fail "no completion of a mode's name"
complete_words run "$here/scene.toml" --set mode.wall.level.outside.str | grep -qx mode.wall.level.outside.strength_n= || fail "no completion of a level's keys"
complete_words run "$here/scene.toml" --set law.method=no | grep -qx law.method=no-proxy || fail "no completion of a choice"
complete_words run "$here/nowhere.toml" --set cou | grep -qx coupling. || fail "no completion without a scene"
settings=$("$palpa" --print-sets "$here/scene.toml")
[ "$(wc -l <<<"$settings")" -gt 60 ] || fail "few settings"
while IFS= read -r setting; do taken --set "$setting"; done <<<"$settings"
# A real shell cuts a word at ':' and '=', and appends completions after the last of them.
COMP_LINE="palpa run --hand sim:st" COMP_POINT=23
COMP_WORDS=(palpa run --hand sim : st)
COMP_CWORD=5
_palpa
[ "${COMPREPLY[*]}" = stroke ] || fail "a cut word is completed to ${COMPREPLY[*]:-nothing}"
unset COMP_LINE COMP_POINT

if "$palpa" --print nonsense 2>/dev/null; then fail "prints nonsense"; fi

# The formatter's warnings, if it is installed.
if command -v groff >/dev/null; then
  complaints=$("$palpa" --print man | groff -k -man -Tutf8 -ww 2>&1 >/dev/null)
  [ -z "$complaints" ] || fail "groff: $complaints"
fi
echo "$options options of $(wc -w <<<"$commands") commands are in both"
