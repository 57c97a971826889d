#!/bin/sh
# Installs into a temporary prefix, moves the tree elsewhere (so nothing may depend on where it was), then builds and
# runs a C program against it, found once through CMake's find_package and once through pkg-config.
#   test_install.sh <cmake> <build folder> <C compiler> <version> <libdir>
set -eu
cmake=$1 build=$2 compiler=$3 version=$4 libdir=$5
consumer=$(cd "$(dirname "$0")/consumer" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

"$cmake" --install "$build" --prefix "$work/first" >/dev/null
mv "$work/first" "$work/moved"
prefix=$work/moved

for file in include/diffaqua.h "$libdir/libdiffaqua.so" "$libdir/pkgconfig/diffaqua.pc" \
            "$libdir/cmake/diffaqua/diffaquaConfig.cmake" "$libdir/cmake/diffaqua/diffaquaConfigVersion.cmake" \
            "$libdir/cmake/diffaqua/diffaquaTargets.cmake"; do
    [ -e "$prefix/$file" ] || { echo "not installed: $file" >&2; exit 1; }
done
if grep -rlF -e "$work/first" -e "$build" "$prefix/$libdir/cmake" "$prefix/$libdir/pkgconfig"; then
    echo "the files above name the folder of the build or of the first installation" >&2
    exit 1
fi

echo "== find_package"
"$cmake" -S "$consumer" -B "$work/build" -DCMAKE_PREFIX_PATH="$prefix" -DCMAKE_C_COMPILER="$compiler" \
    -DEXPECTED_VERSION="$version" >/dev/null
"$cmake" --build "$work/build" >/dev/null
"$work/build/consumer" "$version"

echo "== pkg-config"
PKG_CONFIG_PATH=$prefix/$libdir/pkgconfig
export PKG_CONFIG_PATH
[ "$(pkg-config --modversion diffaqua)" = "$version" ]
# shellcheck disable=SC2046  # flags are meant to be split
"$compiler" -std=c99 -pedantic -Wall -Wextra -Werror -o "$work/consumer" "$consumer/main.c" \
    $(pkg-config --cflags --libs diffaqua) -Wl,-rpath,"$prefix/$libdir"
"$work/consumer" "$version"
