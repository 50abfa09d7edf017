# SPDX-License-Identifier: MIT
"""Small scenes, and pictures of them as arrays. To be run inside Blender."""

import os
import sys
import tempfile
import unittest

import bpy
import numpy as np

SCENE = bpy.context.scene


def reset():
    """Nothing but black: small pictures, one ray's worth of light, no filter."""
    for blocks in (bpy.data.objects, bpy.data.lights, bpy.data.cameras, bpy.data.meshes, bpy.data.materials,
                   bpy.data.images, bpy.data.collections):
        for block in list(blocks):
            if block.name != 'Render Result':
                blocks.remove(block)
    render = SCENE.render
    render.resolution_x, render.resolution_y, render.resolution_percentage = 64, 48, 100
    render.pixel_aspect_x = render.pixel_aspect_y = 1
    render.use_border = render.use_crop_to_border = render.film_transparent = False
    render.threads_mode, render.threads = 'FIXED', 1
    render.image_settings.file_format, render.image_settings.color_depth = 'OPEN_EXR', '32'
    render.image_settings.color_mode = 'RGBA'
    SCENE.world.use_nodes = False
    SCENE.world.color = 0, 0, 0
    SCENE.frame_set(1)
    cycles = SCENE.cycles
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    cycles.max_bounces, cycles.pixel_filter_type, cycles.light_sampling_threshold = 0, 'BOX', 0
    cycles.samples = 64
    for name in SCENE.light_mesh.bl_rna.properties.keys():
        SCENE.light_mesh.property_unset(name)
    SCENE.light_mesh.samples = 16


def read(path):
    """Rows from the bottom up, RGBA."""
    image = bpy.data.images.load(path)
    width, height = image.size
    pixels = np.empty(width * height * 4, np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    return pixels.reshape(height, width, 4)


def picture(engine='LIGHT_MESH'):
    SCENE.render.engine = engine
    with tempfile.TemporaryDirectory() as folder:
        SCENE.render.filepath = os.path.join(folder, 'picture.exr')
        bpy.ops.render.render(write_still=True)
        return read(SCENE.render.filepath)


def add(name, data, location=(0, 0, 0), rotation=(0, 0, 0)):
    thing = bpy.data.objects.new(name, data)
    thing.location, thing.rotation_euler = location, rotation
    SCENE.collection.objects.link(thing)
    return thing


def lamp(kind, location, energy, rotation=(0, 0, 0), shadow='REAL', **settings):
    data = bpy.data.lights.new(kind, kind)
    data.energy, data.light_mesh.shadow = energy, shadow
    for name, value in settings.items():
        setattr(data, name, value)
    return add(kind, data, location, rotation)


def camera(location=(0, 0, 10), rotation=(0, 0, 0), **settings):
    data = bpy.data.cameras.new('Camera')
    for name, value in settings.items():
        setattr(data, name, value)
    SCENE.camera = add('Camera', data, location, rotation)
    return SCENE.camera


def material(node_type='ShaderNodeBsdfDiffuse', **inputs):
    made = bpy.data.materials.new('Material')
    made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    node = tree.nodes.new(node_type)
    output = tree.nodes.new('ShaderNodeOutputMaterial')
    tree.links.new(node.outputs[0], output.inputs['Surface'])
    for name, value in (inputs or {'Color': (.8, .8, .8, 1)}).items():
        node.inputs[name.replace('_', ' ')].default_value = value
    return made


def plane(size=20, location=(0, 0, 0), of=None):
    bpy.ops.mesh.primitive_plane_add(size=size, location=location)
    bpy.context.object.data.materials.append(of or material())
    return bpy.context.object


def ball(radius, location, of=None):
    bpy.ops.mesh.primitive_uv_sphere_add(radius=radius, location=location, segments=48, ring_count=24)
    bpy.ops.object.shade_smooth()
    bpy.context.object.data.materials.append(of or material())
    return bpy.context.object


def box(size, location, of=None):
    bpy.ops.mesh.primitive_cube_add(size=1, location=location, scale=size)
    bpy.context.object.data.materials.append(of or material())
    return bpy.context.object


def run():
    """All cases of the script that is run, or those whose names follow `--`."""
    names = sys.argv[sys.argv.index('--') + 1:] if '--' in sys.argv else []
    arguments = ['test'] + [argument for name in names for argument in ('-k', name)]
    program = unittest.main(module='__main__', argv=arguments, exit=False, verbosity=1)
    if not program.result.wasSuccessful() or program.result.testsRun == 0:
        raise SystemExit(1)
