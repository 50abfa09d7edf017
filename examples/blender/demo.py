# SPDX-License-Identifier: MIT
"""Makes a small scene of many lamps, saves it as a .blend file, and renders it.

    blender --background --addons light_mesh --python demo.py -- SCENE.blend PICTURE.png [CYCLES.png]

With a third file also by Cycles, with 256 samples of direct light.
"""

import math
import random
import sys
import time

import bpy


def material(name, colour, roughness=.6, metallic=0.0):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    made.diffuse_color = *colour, 1
    inputs = made.node_tree.nodes['Principled BSDF'].inputs
    inputs['Base Color'].default_value = *colour, 1
    inputs['Roughness'].default_value, inputs['Metallic'].default_value = roughness, metallic
    return made


def give(thing, its_material):
    thing.data.materials.append(its_material)
    return thing


def box(size, location, its_material):
    bpy.ops.mesh.primitive_cube_add(size=1, location=location, scale=size)
    return give(bpy.context.object, its_material)


def lamp(kind, location, energy, colour=(1, 1, 1), rotation=(0, 0, 0), **settings):
    data = bpy.data.lights.new(kind.title(), kind)
    data.energy, data.color = energy, colour
    data.light_mesh.spacing = .1
    for name, value in settings.items():
        setattr(data, name, value)
    thing = bpy.data.objects.new(data.name, data)
    thing.location, thing.rotation_euler = location, rotation
    bpy.context.collection.objects.link(thing)
    return thing


def build():
    for thing in list(bpy.data.objects):
        bpy.data.objects.remove(thing)
    stone = material('Stone', (.55, .52, .48), .8)
    wood = material('Wood', (.35, .18, .08))
    clay = material('Clay', (.65, .2, .12), .45)
    bpy.ops.mesh.primitive_plane_add(size=30)
    give(bpy.context.object, stone)
    box((12, .2, 3), (0, 3.2, 1.5), stone)
    for i in range(21):
        box((.07, .07, 1.1), (-4 + .4 * i, 1.2, .55), wood)
    for height in (.35, .9):
        box((8.3, .05, .08), (0, 1.2, height), wood)
    bpy.ops.mesh.primitive_monkey_add(size=1.6, location=(-1.3, -.6, .6), rotation=(-.55, 0, .35))
    monkey = give(bpy.context.object, clay)
    monkey.modifiers.new('Smooth', 'SUBSURF').render_levels = 2
    bpy.ops.object.shade_smooth()
    bpy.ops.mesh.primitive_uv_sphere_add(radius=.55, location=(1.1, -.9, .55), segments=64, ring_count=32)
    bpy.ops.object.shade_smooth()
    give(bpy.context.object, material('Ivory', (.8, .75, .62), .35))
    bpy.ops.object.text_add(location=(1.9, .2, .2), rotation=(math.pi / 2, 0, -.25))
    text = give(bpy.context.object, wood)
    text.data.body, text.data.extrude, text.data.size = 'lamps', .06, .75
    # A string of bulbs behind the fence, each with a shadow of its own.
    chance = random.Random(4)
    for i in range(5):
        x = 1.8 * i - 3.6
        warm = .45 + .3 * chance.random()
        lamp('POINT', (x, 2.6, 1.7 + .08 * x * x), 75, (1, warm, .4 * warm), shadow_soft_size=.05 + .03 * i)
    lamp('AREA', (-3, -4, 4), 110, (.55, .7, 1), (.75, -.55, 0), size=1.2)
    eye = bpy.data.objects.new('Camera', bpy.data.cameras.new('Camera'))
    eye.location, eye.rotation_euler = (.4, -6.6, 3.6), (1.13, 0, .04)
    eye.data.lens = 34
    bpy.context.collection.objects.link(eye)
    scene = bpy.context.scene
    scene.camera = eye
    scene.world.use_nodes = False
    scene.world.color = .03, .035, .05
    scene.view_settings.view_transform = 'Standard'
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 720, 450, 100
    return scene


def render(scene, engine, path):
    scene.render.engine, scene.render.filepath = engine, path
    start, used = time.perf_counter(), time.process_time()
    bpy.ops.render.render(write_still=True)
    print(f'{engine}: {time.perf_counter() - start:.1f} s, {time.process_time() - used:.1f} s of processor time, {path}')


def main():
    blend, picture, *cycles = sys.argv[sys.argv.index('--') + 1:]
    scene = build()
    scene.render.engine = 'LIGHT_MESH'
    bpy.ops.wm.save_as_mainfile(filepath=blend)
    render(scene, 'LIGHT_MESH', picture)
    if cycles:
        scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.use_adaptive_sampling = 256, False, False
        scene.cycles.max_bounces = 0
        render(scene, 'CYCLES', cycles[0])


main()
