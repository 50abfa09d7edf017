#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# Installs what is missing, builds the Blender add-on for this machine's processor, and prints the rows of "Fast Light Mesh
# Method in Blender": minutes. After those that take time come those of units and shadows, as its tests print them.
#
# LIGHTMESH_BUILD_DIR: where to build, instead of build/ beside this folder.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
build=${LIGHTMESH_BUILD_DIR:-$root/build}/benchmarks-blender

"$root/cmake/setup-debian.sh" blender
if command -v ninja >/dev/null; then
    export CMAKE_GENERATOR=Ninja
fi
cmake -S "$root" -B "$build" -DCMAKE_BUILD_TYPE=Release -DLIGHTMESH_NATIVE=ON -DLIGHTMESH_BUILD_TESTS=OFF \
    -DLIGHTMESH_BUILD_BENCHMARKS=OFF -DCMAKE_UNITY_BUILD=ON -DCMAKE_UNITY_BUILD_BATCH_SIZE=4
cmake --build "$build" --parallel "$(nproc)" --target lightmesh-blender

export BLENDER_USER_SCRIPTS=$build/examples/blender/scripts BLENDER_USER_CONFIG=$build/profile
export PYTHONDONTWRITEBYTECODE=1
inside() {
    blender --background --factory-startup --addons light_mesh --python-exit-code 1 --python "$@"
}
inside "$root/benchmarks/blender_rows.py" | grep --line-buffered '^|'
fresh=$(mktemp -d)
trap 'rm -rf "$fresh"' EXIT
start=$SECONDS
CCACHE_DISABLE=1 LIGHTMESH_BUILD_DIR=$fresh "$root/examples/blender/run.sh" >/dev/null
seconds=$((SECONDS - start))
echo "| examples/blender/run.sh from nothing but packages: build, install in a clean profile, a picture, s | $seconds | <= 60 |" \
    "$([ $seconds -le 60 ] && echo yes || echo no) | on $(nproc) processors |"
for script in units shadows; do
    inside "$root/tests/blender/$script.py" 2>&1 | grep --line-buffered "^$script:"
done
