# SPDX-License-Identifier: MIT
"""Light units, cameras, geometry and textures against Cycles: the ratio of the pictures' means."""

import os
import sys
import unittest

import bpy
import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from support import SCENE, add, camera, lamp, material, picture, plane, reset, run  # noqa: E402


class Units(unittest.TestCase):
    ratios = []

    def setUp(self):
        reset()

    @classmethod
    def tearDownClass(cls):
        for limit in sorted({within for _, within, _ in cls.ratios}):
            cases = [(abs(ratio - 1), name, ratio) for ratio, within, name in cls.ratios if within == limit]
            _, name, ratio = max(cases)
            print(f'\nunits: of {len(cases)} cases that are to reach {1 - limit:.2f} to {1 + limit:.2f} the farthest from 1 is '
                  f'{ratio:.4f}, {name}')

    def compare(self, name, within=.01, alpha=True):
        cycles, ours = picture('CYCLES'), picture()
        self.assertEqual(cycles.shape, ours.shape, name)
        ratio = ours[..., :3].mean() / cycles[..., :3].mean()
        print(f'units: {name:40} ratio {ratio:.4f}, to reach {1 - within:.2f} to {1 + within:.2f}')
        self.ratios.append((ratio, within, name))
        with self.subTest(name):
            self.assertAlmostEqual(ratio, 1, delta=within)
            self.assertAlmostEqual(ours[..., 3].mean(), cycles[..., 3].mean(), delta=.005)

    def test_lights(self):
        for kind, settings in (
                ('POINT', {'shadow_soft_size': .01}), ('SUN', {'angle': .001}),
                ('SPOT', {'shadow_soft_size': .01, 'spot_size': 1.2, 'spot_blend': .5}),
                ('SPOT', {'shadow_soft_size': .01, 'spot_size': 2.2, 'spot_blend': 1}),
                ('SPOT', {'shadow_soft_size': .01, 'spot_size': .9, 'spot_blend': 0}), ('AREA', {'size': .2}),
                ('AREA', {'size': .02, 'shape': 'DISK'}), ('AREA', {'size': 1})):
            reset()
            plane()
            camera()
            lamp(kind, (0, 0, 4), 2 if kind == 'SUN' else 500, (0 if kind == 'POINT' else .3, 0, 0), color=(1, .5, .25),
                 **settings)
            self.compare(f'{kind} {settings}'.replace("'", ''))

    def test_principled(self):
        for roughness, metallic, specular in ((.5, 0, .5), (.2, 0, .5), (.8, 0, .5), (.4, 1, .5), (.3, 0, 0), (.3, 0, 1)):
            reset()
            plane(of=material('ShaderNodeBsdfPrincipled', Base_Color=(.8, .3, .1, 1), Roughness=roughness,
                              Metallic=metallic, Specular=specular))
            camera((0, -6, 6), (.785, 0, 0))
            lamp('POINT', (0, 4, 4), 500, shadow_soft_size=.01)
            self.compare(f'principled {roughness} {metallic} {specular}', .03)

    def test_panes(self):
        """Before a floor, where nobody sees their shadows, nor what shines on the floor: Cycles lets no lamp shine through
        glass, and surfaces that shine light others."""
        through = {'max_bounces': 8, 'diffuse_bounces': 0, 'glossy_bounces': 0, 'transmission_bounces': 8}
        for name, inputs, settings in (
                ('alpha', {'Alpha': .4}, {}),
                ('transmission', {'Transmission': 1, 'Roughness': 0, 'Specular': 0, 'IOR': 1}, through),
                ('half transmission', {'Transmission': .5, 'Roughness': 0, 'Specular': 0, 'IOR': 1}, through),
                ('emission', {'Emission': (.2, .6, 1, 1), 'Emission_Strength': 2}, {})):
            reset()
            shines = name == 'emission'
            if not shines:
                plane()
            plane(.8, (.1, 0, 8), material('ShaderNodeBsdfPrincipled', **({'Base_Color': (.8, .3, .1, 1)} | inputs)))
            camera()
            lamp('POINT', (2, 1, 10 if shines else 5), 500, shadow_soft_size=.01)
            lamp('SUN', (0, 0, 9), 1, (1.2, 0, 0), angle=.001)
            for setting, value in settings.items():
                setattr(SCENE.cycles, setting, value)
            self.compare(f'pane: {name}')

    def things(self, **settings):
        plane(8)
        bpy.ops.mesh.primitive_monkey_add(location=(.5, .3, 1.2))
        bpy.ops.object.shade_smooth()
        lamp('POINT', (2, -2, 5), 500, shadow='HARD', shadow_soft_size=.01)
        lamp('SUN', (0, 0, 9), 1, (.6, .2, 0), shadow='HARD', angle=.001)
        camera((0, -6, 7), (.7, 0, .1), **settings)

    def test_cameras(self):
        border = {'use_border': True, 'border_min_x': .25, 'border_max_x': .75, 'border_min_y': .1, 'border_max_y': .5}
        for name, of_camera, of_render in (
                ('perspective', {}, {}), ('shift', {'shift_x': .2, 'shift_y': -.1}, {}),
                ('vertical sensor', {'sensor_fit': 'VERTICAL', 'lens': 35}, {}),
                ('portrait', {'lens': 35}, {'resolution_x': 48, 'resolution_y': 64}),
                ('orthographic', {'type': 'ORTHO', 'ortho_scale': 7}, {}),
                ('orthographic shift', {'type': 'ORTHO', 'ortho_scale': 7, 'shift_x': .1}, {}),
                ('clip', {'clip_start': 8.3, 'clip_end': 9.6}, {}), ('pixel aspect', {}, {'pixel_aspect_x': 2}),
                ('half size', {}, {'resolution_percentage': 50}), ('border', {}, border),
                ('border crop', {}, border | {'use_crop_to_border': True}),
                ('border crop 33 %', {}, {'use_border': True, 'use_crop_to_border': True, 'resolution_percentage': 33,
                                          'border_min_x': .21, 'border_max_x': .77, 'border_min_y': .13,
                                          'border_max_y': .58}),
                ('transparent', {}, {'film_transparent': True})):
            reset()
            self.things(**of_camera)
            for setting, value in of_render.items():
                setattr(SCENE.render, setting, value)
            self.compare(f'camera: {name}')

    def test_modifiers_and_instances(self):
        self.things()
        monkey = SCENE.objects['Suzanne']
        monkey.modifiers.new('smooth', 'SUBSURF').render_levels = 2
        monkey.modifiers.new('array', 'ARRAY').count = 2
        self.compare('modifiers')
        collection = bpy.data.collections.new('Collection')
        collection.objects.link(monkey)
        SCENE.collection.objects.unlink(monkey)
        for i in range(3):
            empty = add('instance', None, (-1 + i, .5 * i, .2), (0, 0, i))
            empty.instance_type, empty.instance_collection, empty.scale = 'COLLECTION', collection, (.5, .5, -.8)
        self.compare('instances of a collection, mirrored')

    def test_text_curves_and_world(self):
        self.things()
        bpy.ops.object.text_add(location=(-1, -1, .5))
        bpy.context.object.data.extrude, bpy.context.object.scale = .1, (2, 2, 2)
        bpy.ops.curve.primitive_bezier_circle_add(location=(-2, 1, 1))
        bpy.context.object.data.bevel_depth = .2
        bpy.ops.object.metaball_add(location=(2, -1, .6))
        SCENE.world.color = .2, .3, .4
        SCENE.light_mesh.ambient_rays = 16
        SCENE.cycles.max_bounces, SCENE.cycles.samples = 1, 256
        SCENE.cycles.diffuse_bounces = 0
        self.compare('text, curve, metaball, world')

    def test_textures(self):
        camera()
        plane(6)
        image = bpy.data.images.new('noise', 32, 32)
        pixels = np.ones((32, 32, 4), np.float32)
        pixels[..., :3] = np.random.default_rng(1).random((32, 32, 3))
        image.pixels.foreach_set(pixels.ravel())
        image.pack()
        textured = material('ShaderNodeBsdfPrincipled', Roughness=.8)
        node = textured.node_tree.nodes.new('ShaderNodeTexImage')
        node.image = image
        textured.node_tree.links.new(node.outputs[0], textured.node_tree.nodes['Principled BSDF'].inputs[0])
        SCENE.objects['Plane'].data.materials[0] = textured
        lamp('SUN', (0, 0, 5), 3, angle=.001)
        self.compare('texture')


run()
