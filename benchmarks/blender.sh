#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# Installs what is missing, builds the Blender add-on for this machine's processor, and prints the rows of "Fast Light Mesh
# Method in Blender" that take time: minutes. Units and shadows are rows of its tests.
#
# LIGHTMESH_BUILD_DIR: where to build, instead of build/ beside this folder.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build=${LIGHTMESH_BUILD_DIR:-$root/build}/benchmarks-blender

"$root/cmake/setup-debian.sh" blender
cmake -S "$root" -B "$build" -DCMAKE_BUILD_TYPE=Release -DLIGHTMESH_NATIVE=ON -DLIGHTMESH_BUILD_TESTS=OFF \
    -DLIGHTMESH_BUILD_BENCHMARKS=OFF
cmake --build "$build" --parallel "$(nproc)" --target lightmesh-blender

export BLENDER_USER_SCRIPTS=$build/examples/blender/scripts BLENDER_USER_CONFIG=$build/profile
export PYTHONDONTWRITEBYTECODE=1
blender --background --factory-startup --addons light_mesh --python-exit-code 1 \
    --python "$root/benchmarks/blender_rows.py" | grep --line-buffered '^|'
