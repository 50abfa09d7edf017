#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# Builds what computes on GPUs, holds it against the CPU and times it. Without a GPU it runs on Mesa's lavapipe, in
# small: then it is about the bits, not about times. Ends with an error where values are not the CPU's.
#
#   benchmarks/gpu.sh                  the first GPU that there is
#   benchmarks/gpu.sh --device NAME    a device by a part of its name, or by its number
#
# LIGHTMESH_BUILD_DIR: where to build, instead of build/ beside this folder.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build=${LIGHTMESH_BUILD_DIR:-$root/build}/benchmarks
benchmarks=(lightmesh-gpu-benchmark lightmesh-gpu-cache-benchmark lightmesh-gpu-frame-benchmark)

"$root/cmake/setup-debian.sh" benchmarks
cmake -S "$root" -B "$build" -DCMAKE_BUILD_TYPE=Release -DLIGHTMESH_NATIVE=ON -DLIGHTMESH_BUILD_TESTS=OFF
cmake --build "$build" --parallel "$(nproc)" --target "${benchmarks[@]}"
echo "built after $SECONDS s"

status=0
for benchmark in "${benchmarks[@]}"; do
    echo
    "$build/benchmarks/$benchmark" "$@" || status=$?
    echo "after $SECONDS s"
done
exit $status
