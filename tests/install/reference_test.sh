#!/bin/bash
# The man page and the completion hold every command and every option that --help shows.
#   reference_test.sh PALPA
set -eu
palpa=$1
fail() {
  echo "FAILED: $*" >&2
  exit 1
}
man_text=$("$palpa" --print man | sed 's/\\-/-/g')
eval "$("$palpa" --print bash)"

# complete WORD…: what is offered for the last one
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
if "$palpa" --print nonsense 2>/dev/null; then fail "prints nonsense"; fi

# What the formatter thinks of the page, where there is one.
if command -v groff >/dev/null; then
  complaints=$("$palpa" --print man | groff -k -man -Tutf8 -ww 2>&1 >/dev/null)
  [ -z "$complaints" ] || fail "groff: $complaints"
fi
echo "$options options of $(wc -w <<<"$commands") commands are in both"
