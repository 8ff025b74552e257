#!/bin/sh
# Installs the build into a folder of its own, then builds a C and a C++ program against the
# installed copy, through pkg-config and through find_package(gnomon), and runs them.
set -eu

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
prefix=$folder/prefix
here=$SOURCE/tests/install

"$CMAKE" --install "$BUILD" --prefix "$prefix" >"$folder/log"

# Nothing of the source tree is left: move the copy, so that absolute paths would show.
mv "$prefix" "$folder/moved"
prefix=$folder/moved
"$prefix/bin/gnomon" --help >/dev/null

PKG_CONFIG_PATH=$(dirname "$(find "$prefix" -name gnomon.pc)")
LD_LIBRARY_PATH=$(dirname "$(find "$prefix" -name 'libgnomon.*' | head -n 1)")
export PKG_CONFIG_PATH LD_LIBRARY_PATH
flags=$(pkg-config --cflags --libs gnomon)
"$CC" -std=c17 -Wall -Wextra -Wpedantic -Werror "$here/program.c" $flags -o "$folder/c"
"$CXX" -std=c++17 -Wall -Wextra -Wpedantic -Werror "$here/program.cpp" $flags -o "$folder/cpp"
echo "pkg-config, C:      $("$folder/c")"
echo "pkg-config, C++:    $("$folder/cpp")"

"$CMAKE" -S "$here" -B "$folder/build" -DCMAKE_PREFIX_PATH="$prefix" \
    -DCMAKE_C_COMPILER="$CC" -DCMAKE_CXX_COMPILER="$CXX" >"$folder/log" 2>&1 &&
    "$CMAKE" --build "$folder/build" >>"$folder/log" 2>&1 || {
    cat "$folder/log"
    exit 1
}
echo "find_package, C:    $("$folder/build/program-c")"
echo "find_package, C++:  $("$folder/build/program-cpp")"
