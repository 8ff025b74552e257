#!/bin/sh
# Every public header compiles alone, without warnings, as C17 and as C++17; those of the algorithms
# leave the dialect's words to the program, and compile with 8 and 16 lanes as well.
set -eu

warnings="-Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror"
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
failed=0
checked=0

# compile COMPILER FILE FLAG...
compile() {
    compiler=$1
    file=$2
    shift 2
    checked=$((checked + 1))
    if ! "$compiler" "$@" $warnings -I "$SOURCE/include" -c "$file" -o "$folder/out.o"; then
        echo "FAILED: <$header> with $compiler $*"
        failed=1
    fi
}

cd "$SOURCE/include"
for header in gnomon/*.h gnomon/shadow/*.h; do
    # Twice: guards hold. Then ordinary names, which a macro left behind would break.
    cat >"$folder/unit.c" <<END
#include <$header>
#include <$header>
int gn_unit(int real, int lint, int luint, int mask, int K);
int gn_unit(int real, int lint, int luint, int mask, int K)
{
    return real + lint + luint + mask + K;
}
END
    cp "$folder/unit.c" "$folder/unit.cpp"
    # The two halves of the dialect are made to go together.
    [ "$header" != gnomon/shadow/dialect.h ] ||
        sed -i '2a #include <gnomon/shadow/dialect_end.h>' "$folder/unit.c" "$folder/unit.cpp"
    compile "$CC" "$folder/unit.c" -std=c17
    compile "$CXX" "$folder/unit.cpp" -std=c++17
    case $header in
    gnomon/shadow/*)
        for lanes in 8 16; do
            # Vectors of GNU C, and what is said about passing them without AVX does not matter to
            # functions that are inlined.
            compile "$CC" "$folder/unit.c" -std=gnu17 -Wno-psabi -DGN_LANES=$lanes
        done
        ;;
    esac
done
echo "$checked compilations"
[ "$checked" -gt 0 ] && exit $failed
