#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# Installs what is missing, builds the renderer, and renders the park by hard shadows (whitted), by a light mesh
# (lmm) and by Express (express): pictures, their differences, and a table.
#
#   examples/run.sh [OPTIONS]    options for lightmesh-render compare, such as --width 1920 --height 1440
#
# LIGHTMESH_BUILD_DIR: where to build and to write, instead of build/ beside this folder.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build=${LIGHTMESH_BUILD_DIR:-$root/build}/examples
pictures=$build/pictures

"$root/cmake/setup-debian.sh" examples
cmake -S "$root" -B "$build" -DCMAKE_BUILD_TYPE=Release -DLIGHTMESH_NATIVE=ON -DLIGHTMESH_BUILD_TESTS=OFF \
    -DLIGHTMESH_BUILD_BENCHMARKS=OFF
cmake --build "$build" --parallel "$(nproc)" --target lightmesh-render
"$build/examples/lightmesh-render" compare park --algorithms whitted,lmm,express --reference lmm \
    --output "$pictures" "$@"

echo
echo "The pictures are in $pictures:"
echo "    sheet.png          side by side"
echo "    differences.png    each one's difference to lmm, amplified"
