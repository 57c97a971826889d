#!/bin/sh
# SPDX-License-Identifier: MIT
# cpack's Debian packages: lintian finds no errors; unpacked, installed by dpkg into a root of their own, and a program
# of theirs swims; removed, nothing is left. With DQA_TEST_INSTALL=1 and as root they are installed on this machine too,
# with their dependencies checked, and removed again.
#   test_deb.sh CPACK BUILD COMPILER VERSION     77: a tool is not there
set -eu
cpack=$1 build=$2 compiler=$3 version=$4
consumer=$(cd "$(dirname "$0")/consumer" && pwd)/main.c
for tool in dpkg dpkg-deb dpkg-shlibdeps lintian gzip pkg-config; do
    command -v "$tool" >/dev/null || { echo "skipped: no $tool (Debian: dpkg-dev, lintian)"; exit 77; }
done
work=$(mktemp -d)
work=$(cd "$work" && pwd -P)
installed=
cleanup() {
    if [ -n "$installed" ]; then dpkg --purge $installed >/dev/null; fi
    rm -rf "$work"
}
trap cleanup EXIT
fail() { echo "$*" >&2; exit 1; }
source=$(sed -n 's/^CMAKE_HOME_DIRECTORY:INTERNAL=//p' "$build/CMakeCache.txt")

# Of what has been built: with this generator cpack does not build first, while other tests run.
(cd "$build" && "$cpack" -G DEB -D CPACK_CMAKE_GENERATOR="Ninja Multi-Config" -B "$work/deb") >"$work/log" 2>&1 ||
    { cat "$work/log" >&2; fail "cpack failed"; }
for package in "$work"/deb/*.deb; do
    dpkg-deb -f "$package" Package
    if dpkg-deb --fsys-tarfile "$package" | tar -xO | grep -aF -e "$build" -e "$source" >/dev/null; then
        fail "$package names the folder of its build or of its source"
    fi
done >"$work/packages"
packages=$(sort "$work/packages" | tr '\n' ' ')
echo "packages: $packages"
[ "$(wc -l <"$work/packages")" -eq 3 ] || fail "three packages were expected"
for depends in libstdc++6 libc6; do
    dpkg-deb -f "$work"/deb/libdiffaqua[0-9]*.deb Depends | grep -q "$depends" || fail "the library does not depend on $depends"
done

echo "== lintian"
lintian --allow-root --no-cfg --profile debian --fail-on error "$work"/deb/*.deb

try() { # the folder of the programs and of the library, both of the installed packages
    mkdir "$work/run"
    (cd "$work/run" && unset DQA_SHAPES_DIR && [ -x "$1/diffaqua-plane" ] && LD_LIBRARY_PATH=$2 OPENBLAS_NUM_THREADS=1 "$1/codesign" --quick --iterations 1 --steps 5 --grid 30x10x14 --threads 1 \
        >codesign.txt 2>&1 && [ -s codesign-out/report.html ]) || { cat "$work"/run/*.txt >&2; fail "the installed programs failed"; }
    rm -rf "$work/run"
}

echo "== a root of its own"
root=$work/root
mkdir -p "$root/var/lib/dpkg/info" "$root/var/lib/dpkg/updates" "$root/var/log"
: >"$root/var/lib/dpkg/status"
: >"$root/var/lib/dpkg/available"
listing() { (cd "$1" && find . -path ./var -prune -o -print | sort); }
listing "$root" >"$work/before"
# Maintainer scripts only call ldconfig: they need no chroot, and must leave the cache of this machine alone.
mkdir "$work/bin"
ln -s /bin/true "$work/bin/ldconfig"
private="env PATH=$work/bin:$PATH dpkg --root=$root --force-not-root --force-depends --force-script-chrootless --no-triggers --log=$work/dpkg.log"
$private --install "$work"/deb/*.deb >"$work/log" 2>&1 || { cat "$work/log" >&2; fail "dpkg could not install"; }
listing "$root" >"$work/with"
[ "$(wc -l <"$work/with")" -gt 60 ] || fail "few files were installed"
library=$(cd "$root" && find usr -name 'libdiffaqua.so.[0-9]' | head -n 1)
try "$root/usr/bin" "$root/$(dirname "$library")"
# shellcheck disable=SC2046  # flags are meant to be split
"$compiler" -std=c99 -o "$work/consumer" "$consumer" \
    $(PKG_CONFIG_PATH=$root/$(dirname "$library")/pkgconfig pkg-config --cflags --libs diffaqua)
LD_LIBRARY_PATH=$root/$(dirname "$library") "$work/consumer" "$version"
# shellcheck disable=SC2086  # one word each
$private --purge $packages >"$work/log" 2>&1 || { cat "$work/log" >&2; fail "dpkg could not remove"; }
listing "$root" >"$work/after"
diff "$work/before" "$work/after" || fail "the files above are left behind"

if [ "${DQA_TEST_INSTALL:-0}" = 1 ] && [ "$(id -u)" -eq 0 ]; then
    echo "== this machine"
    if dpkg-query -W -f '${Status}\n' $packages 2>/dev/null | grep -q "install ok installed"; then
        echo "skipped: one of them is installed here"
        exit 0
    fi
    installed=$packages
    dpkg --install "$work"/deb/*.deb >"$work/log" 2>&1 || { cat "$work/log" >&2; fail "dpkg could not install"; }
    dpkg -L $packages | sort -u >"$work/owned"
    dpkg --verify $packages || fail "dpkg finds files changed"
    try /usr/bin ""
    dpkg --purge $packages >/dev/null
    installed=
    while read -r path; do
        if [ -e "$path" ] && ! dpkg -S "$path" >/dev/null 2>&1; then fail "left behind: $path"; fi
    done <"$work/owned"
fi
echo "installed, used and removed without a trace"
