#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# Installs the add-on's zip file into a profile where nothing is, as a user does, and renders a film of two frames in
# another Blender.
#
#   install.sh BLENDER ZIP
set -euo pipefail

blender=$1
zip=$2
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
export BLENDER_USER_CONFIG=$folder/config BLENDER_USER_SCRIPTS=$folder/scripts
mkdir -p "$BLENDER_USER_CONFIG" "$BLENDER_USER_SCRIPTS"
"$blender" --background --python-exit-code 1 --python-expr "import bpy
bpy.ops.preferences.addon_install(filepath='$zip', overwrite=True)
bpy.ops.preferences.addon_enable(module='light_mesh')
bpy.ops.wm.save_userpref()
scene = bpy.context.scene
scene.render.engine = 'LIGHT_MESH'
scene.render.resolution_x, scene.render.resolution_y = 64, 36
bpy.ops.wm.save_as_mainfile(filepath='$folder/scene.blend')"
"$blender" --background "$folder/scene.blend" --python-exit-code 1 --render-output "$folder/frame-" --frame-start 1 \
    --frame-end 2 --render-anim
test -s "$folder/frame-0001.png"
test -s "$folder/frame-0002.png"
