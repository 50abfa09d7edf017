#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# Installs what is missing, builds the Blender add-on, installs it into a Blender profile of its own, and renders a scene
# of many lamps with it.
#
#   examples/blender/run.sh [CYCLES]    with any argument also by Cycles, to compare: minutes
#
# LIGHTMESH_BUILD_DIR: where to build and to write, instead of build/ beside examples/.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
build=${LIGHTMESH_BUILD_DIR:-$root/build}/blender
shown=$build/shown
zip=$build/examples/blender/light_mesh.zip

"$root/cmake/setup-debian.sh" blender
if command -v ninja >/dev/null; then
    export CMAKE_GENERATOR=Ninja
fi
# Several files as one, in three parts of the renderer: the least time on two processors. g++ takes less where it looks for
# garbage only beyond its first gigabyte of memory.
flags=""
if ${CXX:-c++} --version | grep -q "Free Software Foundation"; then
    flags=--param=ggc-min-heapsize=1048576
fi
cmake -S "$root" -B "$build" -DCMAKE_BUILD_TYPE=Release -DLIGHTMESH_BUILD_TESTS=OFF -DLIGHTMESH_BUILD_BENCHMARKS=OFF \
    -DCMAKE_UNITY_BUILD=ON -DCMAKE_UNITY_BUILD_BATCH_SIZE=4 -DCMAKE_CXX_FLAGS="$flags"
cmake --build "$build" --parallel "$(nproc)" --target lightmesh-blender

# A clean profile: the user's own is left as it is.
export BLENDER_USER_CONFIG=$shown/profile/config BLENDER_USER_SCRIPTS=$shown/profile/scripts
rm -rf "$shown/profile"
mkdir -p "$BLENDER_USER_CONFIG" "$BLENDER_USER_SCRIPTS"
blender --background --python-exit-code 1 --python-expr "import bpy
bpy.ops.preferences.addon_install(filepath='$zip', overwrite=True)
bpy.ops.preferences.addon_enable(module='light_mesh')
bpy.ops.wm.save_userpref()"
pictures=("$shown/light-mesh.png")
if [ $# -gt 0 ]; then
    pictures+=("$shown/cycles.png")
fi
blender --background --python-exit-code 1 --python "$root/examples/blender/demo.py" -- "$shown/lamps.blend" \
    "${pictures[@]}" | grep -v '^Fra:'

cat <<END

The picture is $shown/light-mesh.png, its scene $shown/lamps.blend. To look around in it:
    BLENDER_USER_CONFIG=$BLENDER_USER_CONFIG BLENDER_USER_SCRIPTS=$BLENDER_USER_SCRIPTS blender $shown/lamps.blend
In your own Blender: Edit > Preferences > Add-ons > Install..., choose
    $zip
and switch "Light Mesh" on. Then:
    Render Properties > Render Engine > Light Mesh    samples, ambient light
    Object Data Properties of a light > Shadow         real lamp, light mesh, hard rays or none
    F12 renders a picture, Ctrl-F12 a film
END
