# SPDX-License-Identifier: MIT
"""Errors, films, cancelling, what is left out, and the add-on off and on."""

import os
import sys
import threading
import time
import unittest

import addon_utils
import bpy
import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from support import SCENE, add, ball, box, camera, lamp, material, picture, plane, reset, run  # noqa: E402

import light_mesh  # noqa: E402
from light_mesh import core, engine, export, panels  # noqa: E402


def scene(shadow='REAL'):
    plane(12)
    ball(.6, (0, 0, 1))
    bpy.ops.object.shade_flat()  # smooth normals differ in their last bits each time Blender finds them
    lamp('POINT', (2, 1, 4), 500, shadow=shadow, shadow_soft_size=.2)
    camera((0, -7, 5), (.95, 0, 0))


class Behaviour(unittest.TestCase):
    def setUp(self):
        reset()
        engine.forget()
        SCENE.light_mesh.samples = 2

    def test_the_same_picture_whenever(self):
        scene()
        first = picture()
        self.assertTrue(np.isfinite(first).all())
        engine.forget()
        SCENE.render.threads = 4
        self.assertTrue((picture() == first).all())

    def test_errors(self):
        for what, message, spoil in (
                ('no camera', 'no camera', lambda: setattr(SCENE, 'camera', None)),
                ('a light for a camera', 'is a light', lambda: setattr(SCENE, 'camera', SCENE.objects['POINT'])),
                ('a panorama', 'panoramic', lambda: setattr(SCENE.camera.data, 'type', 'PANO')),
                ('not a number', "mesh 'Sphere' is not finite",
                 lambda: setattr(SCENE.objects['Sphere'].data.vertices[3], 'co', (float('nan'), 0, 0))),
                ('an empty border', 'too small|x 0 pixels',
                 lambda: [setattr(SCENE.render, name, value) for name, value in
                          (('use_border', True), ('border_min_x', .5), ('border_max_x', .505))])):
            reset()
            scene()
            spoil()
            SCENE.render.engine = engine.ENGINE
            with self.subTest(what), self.assertRaisesRegex(RuntimeError, message):
                bpy.ops.render.render()
        reset()
        scene()
        self.assertGreater(picture()[..., :3].mean(), 0)  # and it goes on

    def test_nothing_to_see(self):
        camera()
        SCENE.world.color = .25, .5, 1
        self.assertTrue(np.allclose(picture()[0, 0], (.25, .5, 1, 1)))

    def test_what_is_left_out_is_said_once(self):
        scene()
        glow = material('ShaderNodeEmission', Strength=2.0)
        SCENE.objects['Sphere'].data.materials[0] = glow
        SCENE.camera.data.dof.use_dof = True
        add('Volume', bpy.data.volumes.new('Volume'))
        brushed = add('Brushed', SCENE.objects['Sphere'].data.copy())
        brushed.data.materials[0] = material('ShaderNodeBsdfGlossy', Roughness=.5)
        picture()
        said = set(engine._said)
        for text in ('depth of field', 'it shines, but lights nothing', '"Volume" is left out', 'it is rough'):
            self.assertTrue(any(text in line for line in said), (text, said))
        picture()
        self.assertEqual(engine._said, said)

    def test_each_shadow(self):
        """By darkness: below the ball for all kinds but none."""
        brightness = {}
        for shadow in ('REAL', 'MESH', 'MESH_ATK', 'HARD', 'NONE'):
            reset()
            scene(shadow)
            SCENE.objects['POINT'].data.light_mesh.radius = .3
            brightness[shadow] = picture()[..., :3].mean()
        for shadow in ('REAL', 'MESH', 'MESH_ATK'):
            self.assertAlmostEqual(brightness[shadow] / brightness['HARD'], 1, delta=.03, msg=brightness)
        self.assertGreater(brightness['NONE'] / brightness['HARD'], 1.02, brightness)
        SCENE.objects['POINT'].data.use_shadow = False
        self.assertAlmostEqual(picture()[..., :3].mean(), brightness['NONE'], delta=1e-5)

    def test_meshes_are_counted(self):
        scene('MESH')
        other = lamp('POINT', (-2, 0, 4), 100, shadow='MESH')
        lamp('SUN', (0, 0, 4), 1, shadow='HARD')
        self.assertEqual(panels.group_count(SCENE), 1)
        other.data.light_mesh.radius = .7
        self.assertEqual(panels.group_count(SCENE), 2)
        picture()
        self.assertEqual(engine.statistics['groups'], 3)  # and hard rays

    def test_a_film_is_its_stills(self):
        scene()
        mover = box((.5, .5, .5), (-1.5, 0, .5))
        lamp('SPOT', (-2, -1, 4), 300, (.3, -.4, 0), shadow='MESH', spot_size=1.5)
        for thing, index, values in ((mover, 0, (-1.5, 1.5)), (SCENE.objects['POINT'], 1, (1, -1)),
                                     (SCENE.camera, 0, (0, .5))):
            for frame, value in ((1, values[0]), (4, values[1])):
                thing.location[index] = value
                thing.keyframe_insert('location', frame=frame)
        film = []
        for frame in (1, 2, 3, 4):
            SCENE.frame_set(frame)
            film.append(picture())
            self.assertEqual(engine.statistics['is_new_scene'], int(frame == 1))
            self.assertEqual(engine.statistics['groups_kept'], 0 if frame == 1 else 2)
        for frame, from_film in zip((1, 2, 3, 4), film):
            engine.forget()
            SCENE.frame_set(frame)
            self.assertTrue((picture() == from_film).all(), frame)
        self.assertFalse((film[0] == film[1]).all())

    def test_instances_are_kept_once(self):
        """Linked duplicates, instances of a collection and of geometry nodes, drawn as copies are."""
        plane(12)
        first = ball(.5, (-2, 0, .6))
        linked = add('Linked', first.data, (0, .5, .6), (0, .5, 1))
        linked.scale = .8, 1.2, -1
        collection = bpy.data.collections.new('Balls')
        collection.objects.link(add('In the collection', first.data, (0, 0, .5)))
        SCENE.collection.objects.unlink(SCENE.objects['In the collection'])
        empty = add('Empty', None, (2, 0, 0), (0, 0, 1))
        empty.instance_type, empty.instance_collection = 'COLLECTION', collection
        nodes = bpy.data.node_groups.new('Nodes', 'GeometryNodeTree')
        nodes.outputs.new('NodeSocketGeometry', 'Geometry')
        points, info, on_points, out = (nodes.nodes.new(kind) for kind in (
            'GeometryNodeMeshLine', 'GeometryNodeCollectionInfo', 'GeometryNodeInstanceOnPoints', 'NodeGroupOutput'))
        points.inputs['Count'].default_value = 4
        points.inputs['Start Location'].default_value = -2, -2, 0
        points.inputs['Offset'].default_value = 1.3, 0, 0
        info.inputs['Collection'].default_value = collection
        for from_socket, to_socket in ((points.outputs['Mesh'], on_points.inputs['Points']),
                                       (info.outputs[0], on_points.inputs['Instance']),
                                       (on_points.outputs[0], out.inputs[0])):
            nodes.links.new(from_socket, to_socket)
        scattered = add('Scattered', bpy.data.meshes.new('Nothing'))
        scattered.modifiers.new('Nodes', 'NODES').node_group = nodes
        lamp('POINT', (2, 1, 4), 500, shadow_soft_size=.2)
        camera((0, -7, 5), (.95, 0, 0))
        bpy.context.view_layer.update()
        SCENE.light_mesh.samples = 8
        shared = picture()
        of_ball = 2 * 48 * 23
        self.assertEqual(engine.statistics['triangles'], 7 * of_ball + 2)
        self.assertEqual(engine.statistics['stored_triangles'], of_ball + 2)
        # The same, moved, as in a film.
        linked.location.x = .3
        moved = picture()
        self.assertEqual(engine.statistics['is_new_scene'], 0)
        self.assertEqual(engine.statistics['groups_kept'], 1)
        linked.location.x = 0
        # Copies with a mesh of their own each.
        depsgraph = bpy.context.evaluated_depsgraph_get()
        places = [instance.matrix_world.copy() for instance in depsgraph.object_instances
                  if instance.object.type == 'MESH' and len(instance.object.data.polygons) > 100]
        self.assertEqual(len(places), 7)
        data = first.data
        for thing in (first, linked, empty, scattered):
            bpy.data.objects.remove(thing)
        for i, place in enumerate(places):
            own = add('Copy', data.copy())
            own.matrix_world = place
            own.data.vertices[0].co.x += 1e-6 * (i + 1)
        copied = picture()
        self.assertEqual(engine.statistics['stored_triangles'], 7 * of_ball + 2)
        self.assertLess(np.abs(shared - copied).mean(), 1e-4)
        self.assertGreater(np.abs(shared - moved).mean(), 1e-3)

    def test_cancel(self):
        """The core ends a picture of a day within a second."""
        scene()
        session = core.Session()
        export.export(session, bpy.context.evaluated_depsgraph_get(), print)
        view = core.View(ahead=core.Float3(0, 0, -1), up=core.Float3(0, 1, 0), eye=core.Float3(0, 0, 9),
                         edges=(core.c.c_float * 4)(-1, 1, -1, 1), z_far=100, width=8192, height=8192, samples=1024,
                         threads=1)
        session.render(view)
        self.assertEqual(session.poll(.01)[0], core.RUNNING)
        timer = threading.Timer(.1, session.cancel)
        timer.start()
        start = time.perf_counter()
        while session.poll(.1)[0] == core.RUNNING:
            self.assertLess(time.perf_counter() - start, 20)
        self.assertEqual(session.poll(0)[0], core.CANCELLED)
        timer.join()
        session.close()

    def test_view_layers(self):
        scene()
        ball_collection = bpy.data.collections.new('Balls')
        SCENE.collection.children.link(ball_collection)
        sphere = SCENE.objects['Sphere']
        SCENE.collection.objects.unlink(sphere)
        ball_collection.objects.link(sphere)
        both = picture()
        SCENE.view_layers[0].layer_collection.children['Balls'].exclude = True
        self.assertFalse((picture() == both).all())

    def test_off_and_on(self):
        scene()
        before = picture()
        for _ in range(2):
            addon_utils.disable('light_mesh')
            self.assertFalse(hasattr(bpy.types.Scene, 'light_mesh'))
            self.assertFalse(any(engine.ENGINE in getattr(panel, 'COMPAT_ENGINES', ())
                                 for panel in bpy.types.Panel.__subclasses__() if not panel.__name__.startswith('LIGHT_MESH')))
            self.assertIsNotNone(addon_utils.enable('light_mesh'))
        self.assertTrue((picture() == before).all())

    def test_the_manifest_says_what_bl_info_says(self):
        with open(os.path.join(os.path.dirname(light_mesh.__file__), 'blender_manifest.toml'), 'rb') as file:
            import tomllib
            manifest = tomllib.load(file)
        self.assertEqual(manifest['version'], '.'.join(map(str, light_mesh.bl_info['version'])))
        self.assertEqual(manifest['name'], light_mesh.bl_info['name'])


run()
