#!/bin/bash
# The documentation's site builds without a warning, its links resolve, it loads nothing from other machines, and wrong links
# and pages are found.
# Usage: site_test.sh SOURCE FOLDER      exit status 77: its packages are missing
set -euo pipefail
source=$1
folder=$2
for program in sphinx-build doxygen; do
  command -v "$program" >/dev/null || { echo "there is no $program (packages.txt, [docs])" && exit 77; }
done
# Checked in the Python that runs Sphinx, which need not be the first on the path.
"$(sed -n '1s/^#! *//p' "$(command -v sphinx-build)")" -c 'import myst_parser, furo' 2>/dev/null || { echo "there is no myst_parser or no furo (packages.txt, [docs])" && exit 77; }
failed=0
expect() {
  if ! "${@:2}"; then
    echo "FAILED: $1"
    failed=1
  fi
}

rm -rf "$folder"
"$source/tools/make-docs" "$folder/site" || { echo "FAILED: no site" && exit 1; }

# Required pages and parts.
for page in index docs/start docs/concepts docs/modes/README docs/modes/viscosity docs/scene docs/data docs/devices docs/safety docs/explorer \
  docs/python docs/theory docs/felt docs/gallery docs/design api/index api/session-session api/mode-modes search; do
  expect "$page.html is there" test -s "$folder/site/$page.html"
done
if [ -e "${PALPA_PYTHON_PACKAGE:-}/palpa/__init__.pyi" ]; then
  for page in api/python api/python-Session api/python-SurfaceAndFriction api/python-functions; do
    expect "$page.html is there" test -s "$folder/site/$page.html"
  done
  expect "a docstring stands in the reference" grep -q "rows.mode_force_n\|mode_force_n" "$folder/site/api/python-Ticks.html"
fi
expect "search knows a word of a page" grep -q syrup "$folder/site/searchindex.js"
expect "search knows the reference" grep -q error_bound_m "$folder/site/searchindex.js"
expect "a function's words stand in the reference" grep -q "Allocates nothing" "$folder/site/api/solver-coupling.html"

# No external scripts, styles, pictures or fonts.
loads() { grep -rhoE '<(script|img|link|iframe)[^>]*(src|href)="(https?:)?//[^"]*"' "$folder/site" --include='*.html' | grep -v 'rel="canonical"'; }
expect "no page loads anything from another machine" test -z "$(loads | sort -u | head -5)"
expect "no style loads anything from another machine" test -z "$(grep -rhoE 'url\(.?(https?:)?//[^)]*|@import[^;]*//[^;]*' "$folder/site/_static" --include='*.css' | head -5)"

# Planted errors are found.
cp -r "$folder/site" "$folder/broken"
sed -i 's|href="concepts.html"|href="concept.html"|' "$folder/broken/docs/start.html"
expect "a link that leads nowhere is an error" bash -c "! python3 '$source/tools/docs_site/check_links.py' '$folder/broken' >/dev/null 2>&1"
mkdir "$folder/mine" && echo mine >"$folder/mine/file"
expect "another folder is not replaced" bash -c "! '$source/tools/make-docs' '$folder/mine' 2>/dev/null && test -e '$folder/mine/file'"
exit $failed
