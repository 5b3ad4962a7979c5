#!/bin/bash
# Install Kandil into a folder, build the sample project outside of the tree against it in every way that is
# offered, and run it.
#
#     check.sh BUILD SOURCE
set -euo pipefail
build=$1
source=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() {
    echo "$1" >&2
    exit 1
}

cmake --install "$build" --prefix "$work/prefix" > "$work/install.log"
mv "$work/prefix" "$work/moved" # nothing installed may know where it was put
lib=$(dirname "$(find "$work/moved" -name libkandil.so)")
export PKG_CONFIG_PATH="$lib/pkgconfig" LD_LIBRARY_PATH="$lib" KANDIL_CACHE=
cp -r "$source/samples/extension" "$work/project"
cd "$work/project"

others=$(nm -D --defined-only "$lib/libkandil.so" | awk '$3 !~ /^(kd_|ecs_)/ { print $3 }')
[ -z "$others" ] || fail "libkandil.so exports what is not its interface: $others"

strict="-Wall -Wextra -Wpedantic -Werror"
for cc in gcc clang; do
    for debug in "" -DNDEBUG; do
        make -s -B CC="$cc" CFLAGS="-O2 $strict $debug"
    done
done
# shellcheck disable=SC2046 # lists of flags
for cxx in g++ clang++; do
    "$cxx" -std=c++17 -Wall -Werror "$source/tests/library/spawn.cpp" -o spawn $(pkg-config --cflags --libs kandil)
    ./spawn || fail "$cxx: the world from C++ is not as it should be"
done
# shellcheck disable=SC2046
for cc in gcc clang; do
    "$cc" -std=c11 $strict "$source/tests/library/snapshot.c" -o snapshot $(pkg-config --cflags --libs kandil)
    ./snapshot || fail "$cc: the snapshot is not as it should be"
done
# Static linking by the flags of pkg-config alone: in a folder without the shared library the linker takes the other.
mkdir "$work/alone"
cp "$lib/libkandil.a" "$work/alone/"
# shellcheck disable=SC2046
gcc carousel.c -o carousel_static $(pkg-config --cflags kandil) -L"$work/alone" \
    $(pkg-config --static --libs kandil | sed -E 's|-L[^ ]+||g')
if ldd carousel_static | grep -q libkandil; then
    fail "carousel_static needs the shared library"
fi
cmake -B by_cmake -DCMAKE_PREFIX_PATH="$work/moved" > cmake.log
cmake --build by_cmake > cmake.log

run="run carousel.lua --frames 3 --size 160x90 --set voxels.span=0.05"
for program in ./carousel ./carousel_static by_cmake/carousel; do
    "$program" $run --out picture.png --profile table > profile.txt
    [ -s picture.png ] || fail "$program wrote no picture"
    grep -q '^ *turn ' profile.txt || fail "$program: the profile lacks the system turn"
    grep -q '^ *darken ' profile.txt || fail "$program: the profile lacks the system darken"
done
./carousel $run --out plain.png --set lens.vignette.strength=0 --quiet
cmp -s picture.png plain.png && fail "the vignette changes nothing"
./carousel $run --out still.png --set disc.spin.turns_per_s=0 --quiet
cmp -s picture.png still.png && fail "the disc does not turn"
./carousel help scenario | grep -q turns_per_s || fail "the reference lacks spin"
./carousel reference carousel.lua --frame 1 --size 32x18 --spp 1 --out traced.png --quiet
[ -s traced.png ] || fail "the path tracer wrote no picture"
if ./carousel $run --set disc.spin.turns_per_s=many 2> message.txt; then
    fail "a bad value was taken"
fi
grep -q turns_per_s message.txt || fail "the message does not name the field"

man -l --warnings "$work/moved/share/man/man1/kandil.1" > manual.txt 2> warnings.txt || true
[ ! -s warnings.txt ] || grep -q 'not found' warnings.txt || fail "the manual page: $(head -3 warnings.txt)"
bash -n "$work/moved/share/bash-completion/completions/kandil"
# What zsh offers after `kandil run --gi`: its completion runs, with compadd and _files put in place of the editor.
if command -v zsh > /dev/null; then # a shell that few have
    zsh -f "$source/tests/library/complete.zsh" "$work/moved/share/zsh/site-functions/_kandil" > offered.txt
    grep -q 'cones' offered.txt || fail "zsh does not offer the techniques"
    grep -q 'reference:' offered.txt || fail "zsh does not offer the commands"
    grep -q 'voxels.span=' offered.txt || fail "zsh does not offer the settings"
fi
