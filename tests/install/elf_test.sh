#!/bin/bash
# Hardening of every program and library:
# - libraries are searched beside the file alone ($ORIGIN): an empty or relative element of a RUNPATH would load a file of a
#   library's name from the current folder, an absolute element from the build's former folder;
# - its tables of addresses are read-only once it runs (RELRO, and bound at the start);
# - its stack is not executable, and a program's address is random (PIE).
#   elf_test.sh FOLDER
set -eu
# Prints the faults of an ELF file, a line each.
faults() {
  local dynamic segments
  dynamic=$(readelf -dW "$1") segments=$(readelf -lW "$1")
  sed -n 's/.*(R\(UN\)\?PATH).*\[\(.*\)\]$/\2:/p' <<<"$dynamic" | tr ':' '\n' | sed '$d' | grep -v -e '^\$ORIGIN\(/\|$\)' |
    sed "s/.*/looks for libraries in '&', not beside itself/" || true
  grep -q '(RPATH)' <<<"$dynamic" && echo "has an RPATH, which cannot be overruled; a RUNPATH is right"
  grep -q ' GNU_RELRO ' <<<"$segments" || echo "has no RELRO; link with -z relro"
  grep -q -e '(BIND_NOW)' -e '(FLAGS).*BIND_NOW' -e '(FLAGS_1).*NOW' <<<"$dynamic" || echo "is bound late; link with -z now"
  grep ' GNU_STACK ' <<<"$segments" | grep -q -v ' RWE ' || echo "has an executable stack; link with -z noexecstack"
  if grep -q ' INTERP ' <<<"$segments" && ! readelf -hW "$1" | grep -q 'Type: *DYN'; then
    echo "lies at a fixed address; link with -pie"
  fi
  return 0
}

# The check must find each fault, and none in a faultless file.
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
hard=(-fPIE -pie -Wl,-z,relro,-z,now,-z,noexecstack)
planted() { echo 'int main() {}' | g++ -x c++ - -o "$work/planted" "${hard[@]}" "$@" 2>/dev/null; }
planted '-Wl,--enable-new-dtags,-rpath,$ORIGIN/../lib:$ORIGIN'
[ -z "$(faults "$work/planted")" ] || { echo "FAILED: a sound file is found to be wrong: $(faults "$work/planted")" >&2; exit 1; }
while IFS='|' read -r option fault; do
  planted $option
  faults "$work/planted" | grep -q "$fault" || { echo "FAILED: $option is not seen" >&2; exit 1; }
done <<'OPTIONS'
-Wl,-rpath,/usr/lib:|''
-Wl,-rpath,:|''
-Wl,-rpath,$ORIGIN::$ORIGIN|''
-Wl,-rpath,lib|'lib'
-Wl,-rpath,$ORIGINAL|'$ORIGINAL'
-Wl,-rpath,$ORIGIN:/home/me/build/lib|'/home/me/build/lib'
-Wl,--disable-new-dtags,-rpath,$ORIGIN|RPATH
-Wl,-z,norelro|RELRO
-Wl,-z,lazy|late
-Wl,-z,execstack|stack
-no-pie|fixed
OPTIONS

files=0 failed=0
while IFS= read -r -d '' file; do
  readelf -hW "$file" 2>/dev/null | grep -q 'Type: *\(DYN\|EXEC\)' || continue
  files=$((files + 1))
  while IFS= read -r fault; do
    echo "FAILED: $file $fault" >&2
    failed=1
  done < <(faults "$file")
done < <(find "$1" -name CMakeFiles -prune -o -type f \( -perm -u+x -o -name '*.so*' \) -print0)
[ $files -gt 0 ] || { echo "FAILED: no program in $1" >&2; exit 1; }
[ $failed = 0 ] || exit 1
echo "$files programs and libraries, all beyond reproach"
