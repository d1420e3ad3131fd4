#!/bin/bash
# Messages and commands of ./demo and ./test on a fake machine: apt, sudo, CMake and the program are stand-ins that log their
# calls.
set -u
source_root=$1
here=$(mktemp -d)
trap 'rm -rf "$here"' EXIT
failures=0

expect() {  # expect NAME CONDITION…
  local name=$1
  shift
  if "$@"; then
    printf 'ok       %s\n' "$name"
  else
    printf 'FAILED   %s\n--- said:\n%s\n--- called:\n%s\n---\n' "$name" "$(cat "$here/said")" "$(cat "$here/calls")"
    failures=$((failures + 1))
  fi
}
said() { grep -qF -- "$1" "$here/said"; }
called() { grep -qxE -- "$1" "$here/calls"; }
never_called() { ! grep -qE -- "$1" "$here/calls"; }
exited() { [ "$status" = "$1" ]; }
failed() { [ "$status" != 0 ]; }

stand_in() {  # stand_in NAME, its script from standard input
  { printf '#!/bin/bash\necho "%s $*" >>"%s/calls"\n' "$1" "$here"; cat; } >"$here/bin/$1"
  chmod +x "$here/bin/$1"
}

# A repository and a machine with only Debian's basic tools.
fresh_machine() {
  rm -rf "${here:?}"/*
  mkdir -p "$here/bin" "$here/palpa/tools" "$here/elsewhere/data"
  cp "$source_root"/{demo,test,packages.txt} "$here/palpa/"
  cp "$source_root/tools/setup.sh" "$here/palpa/tools/"
  local tool
  for tool in bash cat grep awk sed sort comm paste fold tail mkdir mv rm find dirname chmod env nproc true; do
    ln -s "$(command -v "$tool")" "$here/bin/$tool"
  done
  printf 'coreutils\n' >"$here/installed"
  : >"$here/calls"
  stand_in id <<<"echo 0"
  stand_in dpkg-query <<<"sed 's/^/ii  /' '$here/installed'"
  stand_in apt-get <<TXT
case "\$*" in
  *--print-uris*)
    [ -e "$here/no-lists" ] && { echo "E: Unable to locate package cmake"; exit 100; }
    echo "0 upgraded, 76 newly installed, 0 to remove and 0 not upgraded."
    echo "Need to get 91.0 MB of archives."
    echo "After this operation, 359 MB of additional disk space will be used."
    ;;
  update) rm -f "$here/no-lists" ;;
  install*)
    [ -e "$here/broken" ] && { echo "E: no route to host"; exit 100; }
    for word; do case \$word in install | -*) ;; *) echo "\$word" >>"$here/installed" ;; esac; done
    echo libneeded1 >>"$here/installed"
    ;;
esac
TXT
  stand_in cmake <<TXT
case "\$*" in
  *--preset*)
    folder=build/\${2}
    : >"\$folder/build.ninja"
    for word; do case \$word in -D*) word=\${word#-D}; echo "\${word%%=*}:BOOL=\${word#*=}" ;; esac; done >"\$folder/CMakeCache.txt"
    ;;
  --build*)
    mkdir -p "\$2/bin"
    echo "[1/3] Building one.o"
    echo "one.cpp:1: warning: of a compiler"
    echo "[2/3] Building two.o"
    [ ! -e "$here/damaged" ] || { echo "FAILED: two.o"; exit 1; }
    printf '#!/bin/bash\necho "palpa \$*" >>"$here/calls"\n' >"\$2/bin/palpa"
    chmod +x "\$2/bin/palpa"
    ;;
esac
TXT
  stand_in ctest <<<"exit 0"
  stand_in setarch <<<'shift; "$@"'
}
run() {  # run SCRIPT ARGUMENTS…, from a folder that is not the repository
  : >"$here/calls"
  (cd "$here/elsewhere" && PATH=$here/bin "$here/palpa/$1" "${@:2}") >"$here/said" 2>&1 </dev/null
  status=$?
}

fresh_machine
run demo --core
expect "without a terminal root goes on" called 'apt-get install --yes --no-install-recommends ccache cmake g\+\+ .*'
expect "… said so" said "going on as with --yes"
expect "… said what is installed" said "Palpa needs these Debian packages: ccache cmake g++"
expect "… and how large that is" said "76 packages: 91.0 MB to download, 359 MB on disk."
expect "… exits 0" exited 0

fresh_machine
stand_in id <<<"echo 1000"
stand_in sudo <<<'[ "$1" = -n ] && exit 1; "$@"'
for script in demo test; do
  run $script --core
  expect "./$script without a terminal and with a password for sudo installs nothing" never_called '^(sudo )?(env .*)?apt-get install .*--yes'
  expect "… it exits 2" exited 2
  expect "… says what would be installed" said "Palpa needs these Debian packages: ccache cmake g++"
  expect "… and what to run" said "run in a terminal: $here/palpa/$script --core"
done
stand_in sudo <<<'[ "$1" = -n ] && shift; "$@"'
for script in demo test; do
  rm -f "$here/palpa/build/packages-added.txt" && printf 'coreutils\n' >"$here/installed"
  run $script --core
  expect "./$script without a terminal and with free sudo installs" called 'sudo env DEBIAN_FRONTEND=noninteractive apt-get install --yes .*'
  expect "… exits 0" exited 0
done

fresh_machine
run demo --core --yes
expect "--yes installs the core group" called 'apt-get install --yes --no-install-recommends ccache cmake g\+\+ libblosc-dev libcli11-dev .*'
expect "… without VTK, ITK or tests" never_called 'apt-get install.*(vtk|insight|gtest)'
expect "… as root without sudo" never_called '^sudo'
expect "… builds the core preset without tests" called 'cmake --preset core -DPALPA_TESTS=OFF'
expect "… does not print every step" eval '! said "Building one.o"'
expect "… but what the compiler says" said "one.cpp:1: warning: of a compiler"
expect "… runs the main job" called 'palpa demo'
expect "… exits 0" exited 0

run demo --core
expect "a second run asks apt nothing" never_called '^apt-get'
expect "… and does not configure again" never_called '^cmake --preset'
expect "… and exits 0" exited 0

run demo --remove
expect "--remove keeps nothing of the build" [ ! -e "$here/palpa/build/core" ]
expect "… names the packages it added" said "cmake"
expect "… with those that they needed" said "libneeded1"
expect "… and not those of others" eval '! said coreutils'
expect "… which stay" never_called 'apt-get'
printf 'coreutils\n' >"$here/installed"
run demo --remove
expect "--remove takes the list, too, once the packages are gone" [ ! -e "$here/palpa/build" ]

fresh_machine
run demo --yes --data data
expect "the real head needs the reader" called 'cmake --preset release -DPALPA_TESTS=OFF -DPALPA_READER=ON'
expect "… its packages" called 'apt-get install --yes .*libinsighttoolkit5-dev.*libvtk9-dev.*'
expect "… and gets the folder" called 'palpa demo head --data data'
run test --yes
expect "./test after ./demo turns the tests on" called 'cmake --preset release .*-DPALPA_TESTS=ON .*'
expect "… runs them" called 'ctest --test-dir .*/build/release .*'
expect "… and exits 0" exited 0
run test --yes --without-data
expect "./test --without-data hides the data" called 'cmake -DPALPA_HIDE_DATA=ON .*/build/release'
expect "… runs what uses them" called 'ctest .* --label-regex .*'
expect "… and shows them again" called 'cmake -DPALPA_HIDE_DATA=OFF .*'
run demo
expect "./demo after ./test leaves the tests in" never_called '^cmake --preset'
run test --sanitize
expect "--sanitize runs the tests under both" called 'ctest --test-dir .*/build/asan .*'
expect "… asan and tsan" called 'ctest --test-dir .*/build/tsan .*'
stand_in ctest <<<'exit 8'
run test
expect "a failing test fails ./test" failed
run test --sanitize
expect "… and ./test --sanitize" failed
expect "… which still runs the other sanitizer" called 'ctest --test-dir .*/build/tsan .*'

fresh_machine
stand_in id <<<"echo 1000"
run demo --core --yes
expect "a user without sudo is told what root has to run" said "apt-get install --no-install-recommends ccache cmake g++"
expect "… exit 2" exited 2
stand_in sudo <<<'"$@"'
run demo --core --yes
expect "a user with sudo installs with it" called 'sudo env DEBIAN_FRONTEND=noninteractive apt-get install --yes .*'
expect "… but builds without" never_called '^sudo .*cmake --'

fresh_machine
touch "$here/no-lists"
run demo --core --yes
expect "missing package lists are fetched" called 'apt-get update'
expect "… and then it goes on" exited 0

fresh_machine
touch "$here/broken"
run demo --core --yes
expect "apt's failure is shown" said "no route to host"
expect "… exit 2" exited 2
expect "… nothing is built" never_called '^cmake'

fresh_machine
touch "$here/damaged"
run demo --core --yes
expect "what does not compile is shown" said "FAILED: two.o"
expect "… exit 2" exited 2
expect "… and nothing is run" never_called '^palpa'

fresh_machine
# Output on a terminal; script(1) is the terminal.
if command -v script >/dev/null; then
  printf '[1/4] a\n[2/4] b\nwords of a compiler\n[4/4] c\n' >"$here/steps"
  script -qec "bash -c 'root=. command=x arguments= assume_yes=true preset=x; . $here/palpa/tools/setup.sh; follow_build <$here/steps'" /dev/null \
    >"$here/said" 2>&1 </dev/null
  expect "a terminal is shown the steps done and the time left" said "2 of 4 steps done, about 0 s left"
  expect "… and what the compiler says" said "words of a compiler"
fi

fresh_machine
rm "$here/bin/apt-get" "$here/bin/dpkg-query"
run demo --core --yes
expect "without apt it says how to build by hand" said "cmake --preset core && cmake --build --preset core"
expect "… exit 2" exited 2

fresh_machine
run demo --core --data data
expect "--core with --data is refused" exited 2
run demo --data nowhere
expect "a data folder that is not there is refused" exited 2
run test --sanitise
expect "an unknown option is refused" exited 2

[ "$failures" = 0 ] || { printf '%d failed\n' "$failures"; exit 1; }
