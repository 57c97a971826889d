#!/bin/sh
# Installs into a temporary prefix, moves the tree elsewhere (so nothing may depend on where it was), then builds and
# runs two C programs against it, found once through CMake's find_package and once through pkg-config: one that asks who
# is there, and the installed example embed.c, whose swimmers swim. Installed programs run from there, too.
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

embed=$(find "$prefix" -name embed.c)
[ -n "$embed" ] || { echo "embed.c is not installed" >&2; exit 1; }
swims() {
    "$1" 20 >"$work/swims.txt" || { cat "$work/swims.txt" >&2; exit 1; }
    if [ "$(grep -c 'DQA_SUCCESS after 20 of 20 steps' "$work/swims.txt")" -ne 2 ]; then
        cat "$work/swims.txt" >&2
        echo "two swimmers should have swum" >&2
        exit 1
    fi
}

echo "== find_package"
"$cmake" -S "$consumer" -B "$work/build" -DCMAKE_PREFIX_PATH="$prefix" -DCMAKE_C_COMPILER="$compiler" \
    -DEXPECTED_VERSION="$version" -DEMBED="$embed" >/dev/null
"$cmake" --build "$work/build" >/dev/null
"$work/build/consumer" "$version"
swims "$work/build/embed"

echo "== pkg-config"
PKG_CONFIG_PATH=$prefix/$libdir/pkgconfig
export PKG_CONFIG_PATH
[ "$(pkg-config --modversion diffaqua)" = "$version" ]
# shellcheck disable=SC2046  # flags are meant to be split
"$compiler" -std=c99 -pedantic -Wall -Wextra -Werror -o "$work/consumer" "$consumer/main.c" \
    $(pkg-config --cflags --libs diffaqua) -Wl,-rpath,"$prefix/$libdir"
"$work/consumer" "$version"
# shellcheck disable=SC2046
"$compiler" -std=c99 -pedantic -Wall -Wextra -Werror -pthread -o "$work/embed" "$embed" \
    $(pkg-config --cflags --libs diffaqua) -lm -Wl,-rpath,"$prefix/$libdir"
swims "$work/embed"

# The shapes are found beside the program, wherever the tree lies; a build without examples has none.
if [ -e "$prefix/bin/codesign" ]; then
    echo "== installed programs"
    for page in "$prefix"/share/man/man1/*.1; do
        [ -x "$prefix/bin/$(basename "$page" .1)" ] || { echo "no program for $page" >&2; exit 1; }
    done
    (cd "$work" && unset DQA_SHAPES_DIR && "$prefix/bin/codesign" --quick --iterations 1 --steps 5 --grid 30x10x14 \
        --threads 1 >"$work/codesign.txt" 2>&1) || { cat "$work/codesign.txt" >&2; exit 1; }
    [ -s "$work/codesign-out/report.html" ]
fi
