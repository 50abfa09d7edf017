#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# Installs what is missing, builds the renderer, and renders a house of 36 rooms with a visibility cache, with hard shadows,
# with rays to the lamps and with a light mesh: pictures, their differences to the rays, and a table.
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
"$build/examples/lightmesh-render" compare rooms --output "$pictures" "$@"

echo
echo "The pictures are in $pictures:"
echo "    sheet.png          the cache, hard shadows, rays to the lamps, and a light mesh"
echo "    differences.png    what the first, second and last have else than the rays, amplified"
