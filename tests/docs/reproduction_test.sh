#!/bin/bash
# docs/reproduction.md equals its program's output, and covers every claim. Usage: reproduction_test.sh SOURCE PYTHON
set -euo pipefail
page=$1/docs/reproduction.md
"$2" -c 'import numpy, matplotlib' || exit 77
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
printed=$("$2" "$1/tools/figures/reproduction.py" "$folder")
[ -s "$folder/claims.svg" ] && [ -s "$folder/claims.png" ] || { echo "FAILED: its figure is not drawn" && exit 1; }
on_page=$(sed -n '/^<!-- printed by/,/^<!-- end/p' "$page" | grep '^|')
if [ "$printed" != "$on_page" ]; then
  diff <(echo "$on_page") <(echo "$printed") || true
  echo "FAILED: the table of docs/reproduction.md is not what the program prints"
  exit 1
fi
[ "$(echo "$printed" | grep -c '^| [0-9]')" = 17 ] || { echo "FAILED: there are not 17 claims" && exit 1; }
said=$(grep -oE '^\*\*[0-9, ]+:' "$page" | grep -oE '[0-9]+' | sort -n | tr '\n' ' ')
[ "$said" = "1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 " ] || { echo "FAILED: the page explains the claims $said" && exit 1; }
