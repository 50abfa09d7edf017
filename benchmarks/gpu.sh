#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# Builds what computes on GPUs, holds it against the CPU and times it. Without a GPU it runs on Mesa's lavapipe, in
# small: then it is about the bits, not about times. Ends with an error where values are not the CPU's: of queries none may
# differ, of rays, words of links and long tests, shares of lamps and pixels one in 1,000, since two tracers see edges
# otherwise. At the end stand the figures to reach, of all programs. On a GPU all is to be done within six minutes.
#
#   benchmarks/gpu.sh                  the first GPU that there is
#   benchmarks/gpu.sh --device NAME    a device by a part of its name, or by its number
#   benchmarks/gpu.sh --gpu-rays bvh   without the ray queries of a GPU that has them; else first hits and hard shadows are
#                                      timed by both
#   benchmarks/gpu.sh --frames         only whole pictures, without a GPU of 160x120 pixels; that takes lavapipe half an hour
#                                      on two cores, most of it for the cache of the park. --device may follow
#   benchmarks/gpu.sh --frames spheres   the same of one scene: park, rooms or spheres
#
# LIGHTMESH_BUILD_DIR: where to build, instead of build/ beside this folder.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build=${LIGHTMESH_BUILD_DIR:-$root/build}/benchmarks
most_seconds=360
benchmarks=(lightmesh-gpu-benchmark lightmesh-gpu-cache-benchmark lightmesh-gpu-frame-benchmark)
if [ "${1:-}" = --frames ]; then
    benchmarks=(lightmesh-gpu-frame-benchmark)
fi

"$root/cmake/setup-debian.sh" benchmarks
cmake -S "$root" -B "$build" -DCMAKE_BUILD_TYPE=Release -DLIGHTMESH_NATIVE=ON -DLIGHTMESH_BUILD_TESTS=OFF
cmake --build "$build" --parallel "$(nproc)" --target "${benchmarks[@]}"
echo "built after $SECONDS s"

status=0
for benchmark in "${benchmarks[@]}"; do
    echo
    "$build/benchmarks/$benchmark" "$@" | tee "$build/$benchmark.txt" || status=$?
    echo "after $SECONDS s"
done
echo
if [ $status -eq 0 ]; then
    echo "all values are the CPU's"
else
    echo "VALUES DIFFER from the CPU's, or something failed" >&2
fi
tables=("${benchmarks[@]/#/$build/}")
echo
head -1 "${tables[0]}.txt"
echo
# One table of all, with the head of the first.
awk 'FNR == 1 || /^$/ { is_row = 0 } /^\| what \|/ { is_row = 1; if (heads++) { getline; next } } is_row' "${tables[@]/%/.txt}"
echo
if head -1 "${tables[0]}.txt" | grep -qi llvmpipe; then
    echo "in all $SECONDS s, on a CPU that plays a GPU"
elif [ $SECONDS -le $most_seconds ]; then
    echo "in all $SECONDS s, at most $most_seconds s: reached"
else
    echo "in all $SECONDS s, at most $most_seconds s: missed"
fi
exit $status
