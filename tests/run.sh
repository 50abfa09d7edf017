#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# Installs what is missing, builds with both compilers and with sanitizers, and runs all tests.
#
#   tests/run.sh           all stages
#   tests/run.sh gcc ...   some: style, gcc, clang, address, thread
#
# LIGHTMESH_BUILD_DIR: where to build, instead of build/ beside this folder.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
builds=${LIGHTMESH_BUILD_DIR:-$root/build}
jobs=$(nproc)
# It keeps all processors busy to the end.
if command -v ninja >/dev/null; then
    export CMAKE_GENERATOR=Ninja
fi

say() { printf '\n== %s\n' "$*"; }

# build_and_test NAME COMPILER [options of cmake]
build_and_test() {
    local build=$builds/tests-$1 compiler=$2
    shift 2
    CXX=$compiler cmake -S "$root" -B "$build" -DCMAKE_COMPILE_WARNING_AS_ERROR=ON "$@"
    cmake --build "$build" --parallel "$jobs"
    # Some wait: for windows, for other programs, for pipes.
    ctest --test-dir "$build" --parallel $((jobs + 1)) --output-on-failure --no-tests=error
}

style() {
    say "every file as clang-format writes it, and clang-tidy over the library"
    clang-tidy-14 --quiet --warnings-as-errors='*' "$root/tests/odr.cpp" -- -std=c++20 -I"$root/include" &
    find "$root"/{include,examples,tests,benchmarks} \( -name '*.hpp' -o -name '*.cpp' \) -print0 |
        xargs -0 clang-format-14 --dry-run -Werror
    wait $!
}

# Kernels are chosen at run time: the tests run all that this processor can. g++ compiles in less time where it looks for
# garbage only beyond its first gigabyte of memory.
gcc() {
    say "g++, for any processor: all programs, each header alone"
    build_and_test gcc g++ -DCMAKE_BUILD_TYPE=Release "${compiled_for_tests[@]}" \
        -DCMAKE_CXX_FLAGS=--param=ggc-min-heapsize=1048576
}

# Both compilers use the same standard library and GLM: that a header lacks an include, or minds a macro, one of them
# tells. What examples do is tested with the other one: of all but the library clang++ says what it warns of, in each
# file alone, as users compile them.
clang() {
    say "clang++, for this processor: the library, and that all else compiles"
    build_and_test clang clang++ -DCMAKE_BUILD_TYPE=None -DLIGHTMESH_NATIVE=ON -DLIGHTMESH_TEST_HEADERS=OFF \
        -DLIGHTMESH_TEST_EXAMPLES=OFF -DLIGHTMESH_TEST_OPTIONS=-O1
}

address() {
    say "address and undefined sanitizers: the library, and snapshots of libFuzzer's"
    build_and_test address clang++ "${sanitized[@]}" -DLIGHTMESH_SANITIZE=address,undefined -DLIGHTMESH_FUZZ=ON
}

# The library only: what oneTBB does looks like races.
thread() {
    say "thread sanitizer: the library, where tests make threads"
    build_and_test thread clang++ "${sanitized[@]}" -DLIGHTMESH_SANITIZE=thread
}

# Many files of a program or library as one, whose templates have mostly the same instances.
compiled_for_tests=(-DLIGHTMESH_TEST_OPTIONS=-O1 -DCMAKE_UNITY_BUILD=ON -DCMAKE_UNITY_BUILD_BATCH_SIZE=32)
library_only=(-DLIGHTMESH_BUILD_EXAMPLES=OFF -DLIGHTMESH_BUILD_BENCHMARKS=OFF)
sanitized=(-DCMAKE_BUILD_TYPE=None "-DCMAKE_CXX_FLAGS=-O1 -gline-tables-only" -DLIGHTMESH_NATIVE=ON "${library_only[@]}")

"$root/cmake/setup-debian.sh" tests
if [ $# -eq 0 ]; then
    set -- style gcc clang address thread
fi
times=""
for stage in "$@"; do
    began=$SECONDS
    case $stage in
    style | gcc | clang | address | thread) "$stage" ;;
    *)
        echo "tests/run.sh: there is no stage '$stage'" >&2
        exit 2
        ;;
    esac
    times+=$(printf '%8d s  %s' $((SECONDS - began)) "$stage")$'\n'
done
say "all passed: $*"
printf '%s%8d s  all of tests/run.sh on %d cores\n' "$times" "$SECONDS" "$jobs"
