#!/bin/bash
# Installs the build into an empty prefix, moves the prefix, and uses it from outside: the installed program, a program and a
# plug-in built outside of the tree. Then uninstalls; no file may be left.
#   install_test.sh SOURCE BUILD
set -eu
source=$1 build=$2
work=$(mktemp -d)
prefix="$work/first"
moved="$work/second place"

# A user's own installation from this build must stay uninstallable.
mkdir "$work/notes"
for note in "$build"/install_manifest*.txt "$build"/installed_folders.txt; do
  if [ -e "$note" ]; then mv "$note" "$work/notes"; fi
done
clean() {
  rm -f "$build"/install_manifest*.txt "$build"/installed_folders.txt
  find "$work/notes" -type f -exec mv {} "$build" \;
  rm -rf "$work"
}
trap clean EXIT

step() { echo "== $*"; }
fail() {
  echo "FAILED: $*" >&2
  exit 1
}
# configure NAME FOLDER ARGUMENT…: its output goes to NAME.log
configure() {
  local name=$1 folder=$2
  shift 2
  cmake -S "$folder" -B "$work/$name" -G Ninja "-DCMAKE_PREFIX_PATH=$moved" "$@" >"$work/$name.log" 2>&1
}
build_outside() {
  configure "$@" || { cat "$work/$1.log"; fail "$1 does not configure"; }
  cmake --build "$work/$1" >>"$work/$1.log" 2>&1 || { cat "$work/$1.log"; fail "$1 does not build"; }
}
# refused NAME PIECES ARGUMENT…: find_package fails with a message that matches PIECES
refused() {
  local name=$1 pieces=$2
  shift 2
  if configure "$name" "$work/finder" "$@"; then fail "$name was found"; fi
  tr -s ' \n' ' ' <"$work/$name.log" | grep -q "$pieces" || { cat "$work/$name.log"; fail "$name: does not say '$pieces'"; }
}

step "install into an empty prefix, and move it"
mkdir "$prefix"
cmake --install "$build" --prefix "$prefix" >"$work/install.log" || { cat "$work/install.log"; fail "does not install"; }
mv "$prefix" "$moved"
grep -rl --exclude-dir=doc -e "$source" -e "$build" "$moved" | while read -r file; do
  # Programs and libraries may name sources in their assertions; text may not.
  if grep -qI . "$file"; then fail "$file names the folder of the sources"; fi
done

step "a component needs that component alone; all of them need everything"
sed 's|/bin/palpa-read\b|/bin/not_built|g' "$build/cmake_install.cmake" >"$work/without_reader.cmake"
for component in library development; do
  cmake -DCMAKE_INSTALL_COMPONENT=$component "-DCMAKE_INSTALL_PREFIX=$work/$component" -P "$work/without_reader.cmake" >/dev/null ||
    fail "the component $component is not installed alone"
done
[ -e "$work/development/include/palpa/palpa.h" ] || fail "no header was installed"
if cmake "-DCMAKE_INSTALL_PREFIX=$work/nothing" -P "$work/without_reader.cmake" 2>"$work/refused.log"; then
  fail "all was installed without a reader"
fi
tr -s ' \n' ' ' <"$work/refused.log" | grep -q "not_built is not built yet; first: cmake --build" || { cat "$work/refused.log"; fail "no advice"; }
[ ! -e "$work/nothing" ] || fail "something was installed"

step "libraries beside each file, read-only tables, no executable stack, PIE"
bash "$(dirname "${BASH_SOURCE[0]}")/elf_test.sh" "$moved"

step "every installed header can be included, alone and with all others; there are few"
with_vtk=$(sed -n 's/^ *foreach(header \(.*\))$/\1/p' "$source/palpa/CMakeLists.txt")
[ -n "$with_vtk" ] || fail "the headers of the component vtk are not known"
find "$moved/include" -name '*.h' -printf '#include <%P>\n' | sort -r >"$work/every.cpp"
for header in $with_vtk; do
  grep -qxF "#include <palpa/$header>" "$work/every.cpp" || fail "$header is not installed"
done
printf '#include <palpa/%s>\n' $with_vtk | grep -vxF -f - "$work/every.cpp" >"$work/all.cpp"
g++ -std=c++20 -fsyntax-only -Wall -Wextra "-I$moved/include" "$work/all.cpp"
while read -r line; do
  g++ -std=c++20 -fsyntax-only -Wall -Wextra "-I$moved/include" -x c++ - <<<"$line" || fail "$line does not compile alone"
done <"$work/all.cpp"
[ "$(wc -l <"$work/all.cpp")" -le 34 ] || fail "$(wc -l <"$work/all.cpp") headers are installed"

step "a program and a plug-in outside of the tree"
build_outside program "$source/examples/05_own_program"
"$work/program/feel" | grep -q "touched the surface in [1-9]" || fail "the program felt nothing"
build_outside plugin "$source/examples/04_mode_plugin"

step "a program in C, by CMake and by pkg-config"
build_outside in_c "$source/examples/10_c"
"$work/in_c/feel_in_c" | grep -q "force 0.760 N" || fail "the program in C felt nothing"
pkg_config() { PKG_CONFIG_PATH=$(dirname "$(find "$moved" -name palpa.pc)") pkg-config "$@" palpa; }
[ "$(pkg_config --modversion)" = "$(sed -n 's/^project(palpa VERSION \([0-9.]*\).*/\1/p' "$source/CMakeLists.txt")" ] || fail "palpa.pc has another version"
eval "cc -std=c99 -pedantic -Werror '$source/examples/10_c/feel.c' -o '$work/by_pkg_config' $(pkg_config --cflags --libs)"
LD_LIBRARY_PATH=$(dirname "$(find "$moved" -name libpalpa.so)") "$work/by_pkg_config" | grep -q "force 0.760 N" || fail "nothing was felt"

by_hand=$(PKG_CONFIG_PATH=$(dirname "$(find "$moved" -name palpa-hand.pc)") pkg-config --cflags --libs palpa-hand)
eval "cc -std=c99 -pedantic -Werror '$source/tests/c/hand.c' -o '$work/hand' $by_hand -lm"
LD_LIBRARY_PATH=$(dirname "$(find "$moved" -name libpalpa-hand.so)") "$work/hand" | grep -q "a floor was felt" || fail "the hand felt nothing"

if [ -n "$(find "$moved" -name palpa-view-targets.cmake)" ]; then  # built with VTK
  step "a program that has VTK"
  build_outside viewer "$source/examples/07_vtk_program"
fi

step "core alone, and nothing else"
mkdir "$work/alone"
cat >"$work/alone/CMakeLists.txt" <<'TXT'
cmake_minimum_required(VERSION 3.24)
project(alone LANGUAGES CXX)
find_package(palpa 0.1 REQUIRED COMPONENTS core)
if(TARGET palpa::palpa)
  message(FATAL_ERROR "more than core was found")
endif()
add_executable(alone alone.cpp)
target_link_libraries(alone PRIVATE palpa::core)
TXT
cat >"$work/alone/alone.cpp" <<'TXT'
#include <palpa/solver/solver.h>
int main() {
  palpa::PrimitiveSet primitives;
  primitives.clear({});
  primitives.point(0, {}, 1.0);
  palpa::Solver law;
  const palpa::Balance balance = law.solve(primitives, {}, {0.01, 0, 0}, 500.0, 1e-3);
  return norm(balance.position_m - palpa::Vec3{0.008, 0, 0}) < 1e-9 ? 0 : 1;  // 1 N of a spring of 500 N/m is 2 mm
}
TXT
build_outside alone_build "$work/alone"
"$work/alone_build/alone" || fail "the balance is wrong"
if ldd "$work/alone_build/alone" | grep -q palpa; then fail "core needs a shared library of ours"; fi

step "symbols of other libraries stay inside"
library=$(find "$work" -name 'libpalpa.so.*' -type f | head -1)
if nm -D --defined-only "$library" | grep -E ' _Z(T[ISTV])?(N|NK|St)?(4toml|8nlohmann|St|Sa|Ss)'; then fail "libpalpa exports symbols of other libraries"; fi
nm -D --defined-only "$library" | grep -q _ZN5palpa7Session4tick || fail "libpalpa exports no Session::tick"

step "components and versions that are not there"
mkdir "$work/finder"
cat >"$work/finder/CMakeLists.txt" <<'TXT'
cmake_minimum_required(VERSION 3.24)
project(finder LANGUAGES CXX)
find_package(palpa ${VERSION} REQUIRED COMPONENTS ${COMPONENTS} OPTIONAL_COMPONENTS ${OPTIONAL})
message(STATUS "soup is found: ${palpa_soup_FOUND}")
foreach(component IN LISTS COMPONENTS)
  if(NOT TARGET palpa::${component})
    message(FATAL_ERROR "palpa::${component} is no target")
  endif()
endforeach()
TXT
refused unknown "no component 'soup'; there are core, palpa, hand, view, report and vtk" -DCOMPONENTS=soup
refused newer 'requested version "0.2"' -DVERSION=0.2 -DCOMPONENTS=core
configure optional "$work/finder" -DCOMPONENTS=palpa -DOPTIONAL=soup || fail "an optional component is not needed"
grep -q "soup is found: FALSE" "$work/optional.log" || fail "an optional component that is not there was found"
for component in view report; do
  if [ -e "$(find "$moved" -name "palpa-$component-targets.cmake")" ]; then
    configure "with_$component" "$work/finder" -DCOMPONENTS=$component || { cat "$work/with_$component.log"; fail $component; }
  else
    refused "without_$component" "was built without the component" -DCOMPONENTS=$component
  fi
done

step "as a part of another project: the library alone"
mkdir "$work/part"
cat >"$work/part/CMakeLists.txt" <<'TXT'
cmake_minimum_required(VERSION 3.24)
project(part LANGUAGES C CXX)
include(CTest)
add_subdirectory(${SOURCE} palpa)
foreach(target palpa::core palpa::palpa)
  if(NOT TARGET ${target})
    message(FATAL_ERROR "${target} is not there")
  endif()
endforeach()
foreach(target palpa_cli palpa-read palpa_view uninstall palpa_reference test_plugin feel)
  if(TARGET ${target})
    message(FATAL_ERROR "${target} came along")
  endif()
endforeach()
TXT
configure part_build "$work/part" "-DSOURCE=$source" || { cat "$work/part_build.log"; fail "is no part of another project"; }
mkdir "$work/part_prefix"
cmake --install "$work/part_build" --prefix "$work/part_prefix" >"$work/part.log" 2>&1 || { cat "$work/part.log"; fail "part"; }
[ -z "$(find "$work/part_prefix" -mindepth 1)" ] || fail "the part installs something"

package=$(dirname "$(find "$moved" -path '*/palpa/__init__.py')")
if [ "$package" != . ]; then
  step "the installed package for Python"
  (cd / && PYTHONDONTWRITEBYTECODE=1 PYTHONPATH=$(dirname "$package") "$(command -v -p python3)" -c '
import palpa, sys
assert palpa.__file__.startswith(sys.argv[1]), palpa.__file__
libraries = {line.split(maxsplit=5)[-1].strip() for line in open("/proc/self/maps") if "libpalpa" in line}
assert all(library.startswith(sys.argv[1]) for library in libraries), libraries
scene = palpa.Scene()
scene.add("head", palpa.head_phantom())
palpa.Session(scene).tick((0, 0, 0), 1e-3)' "$moved") || fail "the installed package cannot be imported"
fi

if [ -e "$moved/bin/palpa" ]; then
  step "the installed program"
  cd "$work"
  env -u PALPA_SCENES -u PALPA_DATA XDG_DATA_HOME="$work/no_data" "$moved/bin/palpa" demo >demo.txt  # without the tester's own scans
  grep -q "head_phantom.toml, felt by" demo.txt || fail "the demo shows no table"
  "$moved/bin/palpa" run "$source/examples/04_mode_plugin/ridge.toml" --hand sim:press --duration-s 2 \
    --plugin plugin/ridge.so --out trace | grep -q "max 0.600 N" || fail "the ridge is not felt"
  grep -q "^plugins = \[\"$work/plugin/ridge.so\"\]" trace/trace.toml || fail "the trace does not name its plug-in"
  "$moved/bin/palpa" replay trace --plugin plugin/ridge.so | grep -q "identical in all 2000 ticks" || fail "replay differs"
  if "$moved/bin/palpa" replay trace 2>error.txt; then fail "replay took a plug-in that nobody named"; fi
  grep -q "recorded with the plug-in $work/plugin/ridge.so; name it with --plugin" error.txt || fail "$(cat error.txt)"
  if [ -e "$build/bin/palpa-read" ]; then
    [ -x "$moved/libexec/palpa/palpa-read" ] || fail "palpa-read is not installed"
    printf 'NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: ascii\n\n0 1 2 3 4 5 6 7\n' >eight.nrrd
    env -u PALPA_READER "$moved/bin/palpa" info eight.nrrd | grep -q uint8 || fail "the installed palpa-read reads nothing"
  fi
  gzip -dc "$moved/share/man/man1/palpa.1.gz" | grep -q '^.TH PALPA 1' || fail "no man page"
  cd - >/dev/null
fi

step "uninstall"
mv "$moved" "$prefix"
mkdir -p "$prefix/lib/of_another"
touch "$prefix/share/of_another"
cmake --build "$build" --target uninstall >"$work/uninstall.log" || { cat "$work/uninstall.log"; fail "does not uninstall"; }
[ "$(cd "$prefix" && find . -mindepth 1 | sort | tr '\n' ' ')" = "./lib ./lib/of_another ./share ./share/of_another " ] ||
  { find "$prefix"; fail "uninstalling left something, or took what is not ours"; }
if cmake --build "$build" --target uninstall >/dev/null 2>&1; then fail "uninstalled twice"; fi
echo "all as promised"
