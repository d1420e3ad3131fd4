#!/bin/bash
# Builds the packages, installs them in a bare Debian 12, runs their programs, purges them, and compares the files before and
# after. Needs root, debootstrap and dpkg-dev, a Debian mirror as in this machine's apt, and up to 3 GB; so ctest leaves it out.
# By hand:
#   sudo tests/install/deb_test.sh BUILD [ROOT]
# BUILD is a finished build, configured with CMAKE_INSTALL_PREFIX=/usr and BUILD_TYPE Release. ROOT is a bare root made before
# (by debootstrap --variant=minbase, of this machine's release); it is copied, not changed.
set -eu
build=$(cd "$1" && pwd)
base=${2:-}
work=$(mktemp -d)
root=$work/root
clean() {
  if mountpoint -q "$root/proc"; then umount "$root/proc"; fi
  rm -rf --one-file-system "$work"
}
trap clean EXIT
fail() {
  echo "FAILED: $*" >&2
  exit 1
}
inside() { chroot "$root" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive "$@"; }
# All files but those of apt and dpkg themselves.
files() {
  (cd "$root" && find . -xdev \( -path ./proc -o -path ./tmp -o -path ./var/cache -o -path ./var/log -o -path ./var/lib/apt \
    -o -path ./var/lib/dpkg -o -path ./root \) -prune -o -print) | LC_ALL=C sort
}

echo "== packages"
rm -f "$build"/*.deb
(cd "$build" && cpack -G DEB >"$work/cpack.log") || { cat "$work/cpack.log"; fail "cpack"; }
ls -l "$build"/*.deb
mkdir "$work/unpacked"
for deb in "$build"/*.deb; do dpkg-deb -x "$deb" "$work/unpacked"; done
bash "$(dirname "${BASH_SOURCE[0]}")/elf_test.sh" "$work/unpacked"
rm -r "$work/unpacked"

echo "== a bare Debian 12"
if [ -n "$base" ]; then
  cp -a "$base" "$root"
else
  debootstrap --variant=minbase "$(. /etc/os-release && echo "$VERSION_CODENAME")" "$root" >"$work/debootstrap.log" || { tail "$work/debootstrap.log"; fail "debootstrap"; }
fi
cp /etc/resolv.conf "$root/etc/"
rm -f "$root/etc/apt/sources.list"
cp -a /etc/apt/apt.conf.d/. "$root/etc/apt/apt.conf.d/"
cp /etc/apt/sources.list.d/*.sources "$root/etc/apt/sources.list.d/" 2>/dev/null || true
if [ -s /etc/apt/sources.list ]; then cp /etc/apt/sources.list "$root/etc/apt/"; fi
mount -t proc proc "$root/proc"
inside apt-get -qq update
mkdir "$root/tmp/debs"
cp "$build"/*.deb "$root/tmp/debs/"

install_what_is_missing() {
  inside sh -c "apt-get -qq -y --no-install-recommends install $1" >"$work/apt.log" 2>&1 || { tail -30 "$work/apt.log"; fail "apt-get install $1"; }
}
# Dependencies stay: the comparison covers the packages' own files.
needed=$(for deb in "$build"/*.deb; do dpkg-deb -f "$deb" Depends; done | tr ',' '\n' | sed 's/|.*//; s/(.*//; s/ //g' |
  grep -v -e '^libpalpa' -e '^palpa' -e '^python3-palpa' | sort -u | tr '\n' ' ')
if [ -n "$(find "$build" -maxdepth 1 -name 'palpa-explorer*.deb')" ]; then needed="$needed xvfb xauth libgl1-mesa-dri"; fi
echo "== what they need: $needed"
install_what_is_missing "$needed"
files >"$work/before"

echo "== installed and run"
install_what_is_missing "/tmp/debs/*.deb"
inside dpkg-query -W -f '${Package} ${Version} ${Installed-Size} kB\n' 'libpalpa*' 'palpa*' 'python3-palpa*'
# As an ordinary user without write permission.
inside setpriv --reuid 65534 --regid 65534 --clear-groups sh -c 'cd / && palpa demo' >"$work/demo" || fail "palpa demo"
sed -n 1,12p "$work/demo"
grep -q "head_phantom.toml, felt by" "$work/demo" || fail "palpa demo shows no table"
if compgen -G "$root/usr/lib/*/libpalpa_report.so*" >/dev/null; then
  inside sh -c 'mkdir /tmp/felt && chmod 777 /tmp/felt'
  inside setpriv --reuid 65534 --regid 65534 --clear-groups sh -c 'cd /tmp/felt && palpa demo wing' >"$work/wing" || fail "palpa demo wing"
  for made in report.html pictures/scene.png pictures/moment.png; do
    [ -s "$root/tmp/felt/palpa-demo/wing/$made" ] || fail "the demo makes no $made"
  done
fi
printf 'NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: ascii\n\n0 1 2 3 4 5 6 7\n' >"$root/tmp/eight.nrrd"
if [ -e "$root/usr/libexec/palpa/palpa-read" ]; then inside palpa info /tmp/eight.nrrd | grep uint8 || fail "palpa info"; fi
if [ -e "$root/usr/bin/palpa-explorer" ]; then
  status=0
  inside palpa explore 2>"$work/window" || status=$?
  if [ $status != 2 ] || ! grep -q "no display" "$work/window"; then fail "palpa explore without a display: $(cat "$work/window")"; fi
  # As an ordinary user again; it runs until it is ended.
  status=0
  inside setpriv --reuid 65534 --regid 65534 --clear-groups sh -c \
    'cd /tmp/felt && HOME=/tmp/felt timeout 10 xvfb-run -a palpa explore /usr/share/palpa/scenes/head_phantom.toml' \
    >"$work/window" 2>&1 || status=$?
  cat "$work/window"
  if [ $status != 124 ] || grep -q "palpa" "$work/window"; then fail "palpa explore ended with $status"; fi
  [ -s "$root/usr/share/applications/palpa-explorer.desktop" ] || fail "no desktop entry"
  inside dpkg --verify palpa-explorer || fail "files of the window are not as packed"
fi
[ -s "$root/usr/include/palpa/vtk/from_vtk.h" ] || fail "no headers for programs that have VTK"
inside sh -c 'cd /tmp && palpa run /usr/share/palpa/scenes/head_phantom.toml --hand sim:press --duration-s 0.1 --out traced >/dev/null &&
  palpa export traced felt.vtp && palpa export traced felt.h5' || fail "palpa export"
if [ -e "$root/usr/lib/python3/dist-packages/palpa" ]; then
  inside setpriv --reuid 65534 --regid 65534 --clear-groups sh -c "cd / && python3 -c '
import palpa
scene = palpa.Scene()
scene.add(\"v\", palpa.read_volume(\"/tmp/eight.nrrd\"))
print(palpa.__version__, palpa.Session(scene).tick((0, 0, 0), 1e-3))'" || fail "import palpa"
fi
for name in palpa libpalpa-dev; do
  [ -s "$root/usr/share/doc/$name/copyright" ] || fail "$name has no copyright file"
done
inside dpkg --verify palpa || fail "files are not as packed"

echo "== purged"
inside sh -c "dpkg --purge \$(dpkg-query -W -f '\${Package} ' 'libpalpa*' 'palpa*' 'python3-palpa*')" >"$work/purge.log" 2>&1 || { cat "$work/purge.log"; fail "purge"; }
files >"$work/after"
diff "$work/before" "$work/after" || fail "purging left the above behind"
[ -z "$(inside dpkg-query -W -f '${Package} ' 'libpalpa*' 'palpa*' 'python3-palpa*' 2>/dev/null)" ] || fail "dpkg still knows the packages"
echo "$(wc -l <"$work/after") files, the same as before"
