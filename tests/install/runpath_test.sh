#!/bin/bash
# No program and no library looks for libraries in the current folder: an element of a RUNPATH that is empty or relative
# would run whatever lies there under a library's name.
#   runpath_test.sh FOLDER
set -eu
# Those elements of FILE's RUNPATH or RPATH, one a line.
unsafe_elements() {
  readelf -d "$1" 2>/dev/null | sed -n 's/.*(R\(UN\)\?PATH).*\[\(.*\)\]$/\2/p' | tr ':' '\n' | grep -v -e '^/' -e '^\$ORIGIN' || true
}

# The check itself must see one.
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
for path in '/usr/lib:' ':' 'lib' '/usr/lib::/lib'; do
  echo 'int main() {}' | g++ -x c++ - -o "$work/planted" "-Wl,-rpath,$path"
  [ "$(unsafe_elements "$work/planted" | wc -l)" -gt 0 ] || { echo "FAILED: '$path' is not seen" >&2; exit 1; }
done

files=0 failed=0
while IFS= read -r -d '' file; do
  readelf -h "$file" >/dev/null 2>&1 || continue
  files=$((files + 1))
  if [ "$(unsafe_elements "$file" | wc -l)" -gt 0 ]; then
    echo "FAILED: $file: $(readelf -d "$file" | grep -E 'R(UN)?PATH')" >&2
    failed=1
  fi
done < <(find "$1" -name CMakeFiles -prune -o -type f \( -perm -u+x -o -name '*.so*' \) -print0)
[ $files -gt 0 ] || { echo "FAILED: no program in $1" >&2; exit 1; }
[ $failed = 0 ] || exit 1
echo "$files programs and libraries, none of which looks in the current folder"
