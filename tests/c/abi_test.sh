#!/bin/bash
# The functions and structs that programs in C were built with: abi.txt. Lines may be added, with a larger abi; none may change.
#   abi_test.sh LAYOUT_PROGRAM LIBRARY HAND_LIBRARY
set -eu
here=$(dirname "${BASH_SOURCE[0]}")
exported() { nm -D --defined-only "$1" | awk '$3 !~ /^_Z/ {print $3}' | LC_ALL=C sort; }
diff "$here/abi.txt" <("$1" && exported "$2") ||
  { echo "the interface for C has changed; if by additions alone, raise PALPA_ABI and add them to abi.txt" >&2; exit 1; }
[ "$(grep -c '^palpa_[a-z0-9_]*$' "$here/abi.txt")" -le 60 ] || { echo "the header for C has more than 60 functions" >&2; exit 1; }
if nm -D --defined-only "$2" | awk '$3 !~ /^(palpa_|_Z(T[ISTV]|Th[n0-9_]*|Tv[n0-9_]*|Z|ZN?|GV|GVZ)?(N|NK)5palpa)/ {print $3}' | grep .; then
  echo "libpalpa exports symbols of others" >&2
  exit 1
fi
# The hand's library: its section and that of the library, nothing in C++, and the standard library alone.
diff <(grep -E '^palpa_(abi|free|last_error|version|hand_[a-z]+)$' "$here/abi.txt") <(nm -D --defined-only "$3" | awk '{print $3}' | LC_ALL=C sort) ||
  { echo "libpalpa-hand does not export what c.h says" >&2; exit 1; }
if readelf -d "$3" | sed -n 's/.*(NEEDED).*\[\(.*\)\]/\1/p' | grep -vE '^lib(c|m|gcc_s|stdc\+\+|asan|ubsan|tsan)\.so|^ld-linux'; then
  echo "libpalpa-hand needs more than the standard library" >&2
  exit 1
fi
