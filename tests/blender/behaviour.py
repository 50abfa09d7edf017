# SPDX-License-Identifier: MIT
"""Errors, films, cancelling, what is left out, and the add-on off and on."""

import os
import sys
import tempfile
import threading
import time
import types
import unittest

import addon_utils
import bpy
import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from support import SCENE, add, ball, box, camera, lamp, material, picture, plane, reset, run  # noqa: E402

import light_mesh  # noqa: E402
from light_mesh import core, engine, export, materials, panels, viewport  # noqa: E402


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

    def test_each_thing_that_is_left_out_has_a_name(self):
        scene()
        sphere, light = SCENE.objects['Sphere'], SCENE.objects['POINT']
        portal = lamp('AREA', (0, 0, 3), 10)
        portal.name, portal.data.cycles.is_portal = 'Window', True
        textured = material('ShaderNodeBsdfPrincipled', Roughness=.5)
        node = textured.node_tree.nodes.new('ShaderNodeTexImage')
        node.image = bpy.data.images.new('Holes', 8, 8, alpha=True)
        node.image.pixels[3] = .5
        textured.node_tree.links.new(node.outputs[0], textured.node_tree.nodes['Principled BSDF'].inputs[0])
        sphere.data.materials[0] = textured
        tinted = box((1, 1, 1), (3, 0, 0), material('ShaderNodeBsdfPrincipled', Specular_Tint=.5, Transmission_Roughness=.5))
        child = bpy.data.collections.new('Behind')
        SCENE.collection.children.link(child)
        layer = bpy.context.view_layer.layer_collection.children['Behind']
        view_layer = bpy.context.view_layer
        world = SCENE.world
        world.use_nodes = True
        scatter = world.node_tree.nodes.new('ShaderNodeVolumeScatter')
        self.addCleanup(world.node_tree.nodes.remove, scatter)
        self.addCleanup(setattr, view_layer, 'material_override', None)

        def link_volume():
            world.node_tree.links.new(scatter.outputs[0], world.node_tree.nodes['World Output'].inputs['Volume'])

        for text, ask in (
                ('light "Window" is left out: it is a portal', None),
                ('image "Holes": that its alpha darkens its colours', None),
                (f'material "{tinted.data.materials[0].name}": Specular Tint, Transmission Roughness left out', None),
                ('object "Sphere": that it is a holdout', lambda: setattr(sphere, 'is_holdout', True)),
                ('object "Sphere": that it is a shadow catcher', lambda: setattr(sphere, 'is_shadow_catcher', True)),
                *((f'object "Sphere": that it is hidden from rays of {name.replace("_", " ")} ',
                   lambda name=name: [setattr(sphere, f'visible_{other}', other != name) for other in export.RAYS])
                  for name in export.RAYS),
                ('object "POINT": that it is hidden from rays of glossy', lambda: setattr(light, 'visible_glossy', False)),
                ('collection "Behind": that it is a holdout', lambda: setattr(layer, 'holdout', True)),
                ('collection "Behind": that it is indirect only', lambda: setattr(layer, 'indirect_only', True)),
                ('its material override', lambda: setattr(view_layer, 'material_override', tinted.data.materials[0])),
                ('its volume', link_volume),
                ('image "Holes": its premultiplied alpha', lambda: setattr(node.image, 'alpha_mode', 'PREMUL'))):
            with self.subTest(text):
                picture()
                self.assertFalse(any(text in line for line in engine._said) and ask, engine._said)
                if ask:
                    ask()
                picture()
                lines = [line for line in engine._said if text in line]
                self.assertEqual(len(lines), 1, engine._said)

    def test_inputs_of_later_versions(self):
        def socket(value=0., is_linked=False):
            return types.SimpleNamespace(default_value=value, is_linked=is_linked)

        node = types.SimpleNamespace(inputs={
            'Coat Normal': socket((0, 0, 0), True), 'Thin Film Thickness': socket(100.), 'Coat Weight': socket(.5),
            'Specular Tint': socket((1, .5, 1, 1)), 'Diffuse Roughness': socket(), 'Normal': socket((0, 0, 0))})
        self.assertEqual(set(materials.left_out_of(node)),
                         {'Coat Normal', 'Thin Film Thickness', 'Coat Weight', 'Specular Tint'})
        node.inputs['Specular Tint'] = socket((1, 1, 1, 1))
        self.assertNotIn('Specular Tint', materials.left_out_of(node))

    def test_a_core_of_another_version_is_refused(self):
        abi, core.ABI = core.ABI, core.ABI + 1
        try:
            with self.assertRaisesRegex(ImportError, f'has interface {abi}, and this add-on needs {abi + 1}'):
                core._load()
        finally:
            core.ABI = abi

    def test_statistics_are_replaced(self):
        """The panel may read those of the last picture while the next ones come."""
        scene()
        picture()
        kept = engine.statistics
        copied = dict(kept)
        picture()
        engine.forget()
        self.assertEqual(kept, copied)
        self.assertIn('seconds', kept)

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
        self.assertEqual(panels.group_count(bpy.context.view_layer), 1)
        other.data.light_mesh.radius = .7
        self.assertEqual(panels.group_count(bpy.context.view_layer), 2)
        picture()
        self.assertEqual(engine.statistics['groups'], 3)  # and hard rays
        # Only what is in the picture counts: also through an instance.
        view_layer = bpy.context.view_layer
        other.hide_render = True
        self.assertEqual(panels.group_count(view_layer), 1)
        other.hide_render = False
        apart = bpy.data.collections.new('Apart')
        SCENE.collection.children.link(apart)
        SCENE.collection.objects.unlink(other)
        apart.objects.link(other)
        self.assertEqual(panels.group_count(view_layer), 2)
        apart.hide_render = True
        self.assertEqual(panels.group_count(view_layer), 1)
        apart.hide_render = False
        view_layer.layer_collection.children['Apart'].exclude = True
        self.assertEqual(panels.group_count(view_layer), 1)
        empty = add('Empty', None)
        empty.instance_type, empty.instance_collection = 'COLLECTION', apart
        self.assertEqual(panels.group_count(view_layer), 2)
        picture()
        self.assertEqual(engine.statistics['groups'], 3)

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

    def test_bending_and_colours_keep_what_was_found(self):
        """Beside glass with holes; each frame is a new session's."""
        scene()
        lamp('POINT', (-2, 1, 4), 200, shadow='MESH')
        wood = material('ShaderNodeBsdfPrincipled', Roughness=.5)
        glass = material('ShaderNodeBsdfPrincipled', Alpha=.5)
        box((.8, .8, .05), (1.5, -1, .8), glass)
        bpy.ops.mesh.primitive_grid_add(x_subdivisions=6, y_subdivisions=6, size=1.5, location=(-1.5, -1, .8))
        grid = bpy.context.object
        grid.data.materials.append(wood)
        grid.shape_key_add(name='Basis')
        bent = grid.shape_key_add(name='Bent')
        for point in bent.data:
            point.co.z = .3 * np.sin(3 * point.co.x) * np.sin(2 * point.co.y)
        look = wood.node_tree.nodes['Principled BSDF'].inputs
        of_glass = glass.node_tree.nodes['Principled BSDF'].inputs

        def edit(what):
            """What a session says that draws before and after it, and how many rays each picture took."""
            picture()
            rays_before = engine.statistics['kept_rays']
            what()
            drawn = picture()
            found = engine.statistics
            engine.forget()
            self.assertTrue((picture() == drawn).all())
            engine.forget()
            return found, found['kept_rays'] - rays_before, rays_before

        _, again, before = edit(lambda: None)  # some places are found each time
        self.assertLess(again, before / 500)
        found, new, before = edit(lambda: setattr(bent, 'value', .7))
        self.assertEqual((found['is_new_scene'], found['groups_kept']), (0, 2))
        self.assertGreater(found['moved_boxes'], 0)
        self.assertLess(new, before)
        for socket, value in ((look['Base Color'], (.9, .2, .1, 1)), (look['Roughness'], .3),
                              (of_glass['Base Color'], (.1, .9, .1, 1)), (of_glass['Roughness'], .4)):
            with self.subTest(socket.name):
                found, new, _ = edit(lambda: setattr(socket, 'default_value', value))
                self.assertEqual((found['is_new_scene'], found['groups_kept'], found['moved_boxes']), (0, 2, 0))
                self.assertEqual(new, again)
        found, new, before = edit(lambda: setattr(of_glass['Alpha'], 'default_value', .8))
        self.assertEqual((found['is_new_scene'], found['groups_kept']), (0, 2))
        self.assertGreater(found['moved_boxes'], 0)
        self.assertLess(new, before)

    def test_what_comes_goes_or_grows_leaves_the_rest(self):
        """Each frame of a film is a new session's, and costs what is around the change."""
        scene()
        lamp('POINT', (-2, 1, 4), 200, shadow='MESH')
        lamp('SPOT', (-2, -1, 4), 300, (.3, -.4, 0), shadow='MESH_ATK', spot_size=1.5)
        things = {frame: box((.4, .4, .4), (-1.5 + .5 * frame, -1.2, .3)) for frame in (2, 3)}
        for appears, thing in things.items():
            for frame in (1, 2, 3, 4, 5):
                thing.hide_render = frame not in (appears, appears + 1)
                thing.keyframe_insert('hide_render', frame=frame)
        glass = material('ShaderNodeBsdfPrincipled', Alpha=.5)
        row = box((.2, .2, .2), (1, -1.5, .2), glass)
        array = row.modifiers.new('Array', 'ARRAY')
        array.relative_offset_displace = 1.5, 0, 0
        for frame in (1, 2, 3, 4, 5):
            array.count = 3 if frame == 4 else 2
            array.keyframe_insert('count', frame=frame)
        film, rays = [], [0]
        for frame in (1, 2, 3, 4, 5, 5):
            SCENE.frame_set(frame)
            film.append(picture())
            rays.append(engine.statistics['kept_rays'])
            self.assertEqual(engine.statistics['is_new_scene'], int(frame == 1))
            self.assertEqual(engine.statistics['groups_kept'], 0 if frame == 1 else 3)
        for frame, from_film in enumerate(film[:5], 1):
            engine.forget()
            SCENE.frame_set(frame)
            self.assertTrue((picture() == from_film).all(), frame)
        for a, b in zip(film[:4], film[1:]):
            self.assertFalse((a == b).all())
        found = [b - a for a, b in zip(rays, rays[1:])]
        self.assertLess(max(found[1:]), found[0] / 2, found)
        self.assertLess(found[5], found[0] / 100, found)

    def test_a_lamp_that_comes_or_goes_leaves_the_others(self):
        scene()
        lamps = [lamp('POINT', (x, -1, 4), 200, shadow_soft_size=.2) for x in (-2, 0, 2)]
        drawn = [picture()]
        rays = engine.statistics['kept_rays']
        lamps[0].hide_render = True
        drawn.append(picture())
        self.assertEqual(engine.statistics['groups_kept'], 1)
        self.assertLess(engine.statistics['kept_rays'] - rays, rays / 100)
        lamps[2].data.light_mesh.spacing = .3
        drawn.append(picture())
        self.assertEqual((engine.statistics['groups'], engine.statistics['groups_kept']), (2, 1))
        collection = bpy.data.collections.new('Lamps')
        collection.objects.link(lamps[1])
        SCENE.collection.objects.unlink(lamps[1])
        for x in (-1, 1):
            empty = add('Empty', None, (x, 0, 0))
            empty.instance_type, empty.instance_collection = 'COLLECTION', collection
        drawn.append(picture())
        self.assertEqual((engine.statistics['groups'], engine.statistics['groups_kept']), (2, 2))
        engine.forget()
        self.assertTrue((picture() == drawn[3]).all())
        for a, b in zip(drawn, drawn[1:]):
            self.assertFalse((a == b).all())

    def test_images_are_read_when_they_changed(self):
        plane(4)
        camera()
        SCENE.world.color = 1, 1, 1
        textured = SCENE.objects['Plane'].data.materials[0] = material('ShaderNodeBsdfPrincipled', Roughness=.8)
        node = textured.node_tree.nodes.new('ShaderNodeTexImage')
        node.interpolation = 'Closest'
        textured.node_tree.links.new(node.outputs[0], textured.node_tree.nodes['Principled BSDF'].inputs[0])
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        counts = {'read': 0, 'copied': 0}
        read, add_image = materials._pixels, core.Session.add_image

        def count(name, function, *arguments):
            counts[name] += 1
            return function(*arguments)

        materials._pixels = lambda *arguments: count('read', read, *arguments)
        core.Session.add_image = lambda *arguments: count('copied', add_image, *arguments)
        self.addCleanup(setattr, materials, '_pixels', read)
        self.addCleanup(setattr, core.Session, 'add_image', add_image)

        def drawn(reads, copies):
            counts.update(read=0, copied=0)
            result = picture()
            self.assertEqual(counts, {'read': reads, 'copied': copies})
            return result

        def is_another(copies, reads, before):
            result = drawn(reads, copies)
            self.assertFalse((result == before).all())
            return result

        generated = node.image = bpy.data.images.new('Generated', 16, 16)
        generated.generated_color = .5, .5, .5, 1
        last = drawn(1, 1)
        self.assertTrue((drawn(0, 0) == last).all())
        generated.generated_color = .2, .5, .5, 1
        last = is_another(1, 1, last)
        generated.pixels[4 * 100] = 1  # painted: looked at each time, and copied once
        last = is_another(1, 1, last)
        self.assertTrue((drawn(1, 0) == last).all())
        generated.pixels[4 * 130] = 1
        last = is_another(1, 1, last)
        generated.pack()
        self.assertTrue((drawn(1, 1) == last).all())
        self.assertTrue((drawn(0, 0) == last).all())
        size = generated.packed_file.size
        generated.pixels[4 * 130] = .9
        generated.pack()
        self.assertEqual((generated.is_dirty, generated.packed_file.size), (False, size))  # which do not tell
        last = is_another(1, 1, last)
        # A file that is older than this Blender, and one that was written since.
        path = os.path.join(folder.name, 'picture.png')
        generated.filepath_raw, generated.file_format = path, 'PNG'
        generated.save()
        node.image = bpy.data.images.load(path)
        first = drawn(1, 1)
        self.assertTrue((drawn(1, 0) == first).all())
        generated.pixels[4 * 77] = 1
        generated.filepath_raw = path
        generated.save()
        node.image.reload()
        is_another(1, 1, first)
        started, materials._started = materials._started, time.time() + 1000
        try:
            drawn(1, 1)
            drawn(0, 0)
        finally:
            materials._started = started

    def test_memory(self):
        """Pictures, views and bakes have it, and draw the same with little."""
        scene('MESH')
        lamp('POINT', (-2, 1, 4), 200, shadow_soft_size=.3)
        for light in bpy.data.lights:
            light.light_mesh.radius = light.light_mesh.spacing = .05
        SCENE.render.resolution_x, SCENE.render.resolution_y = 200, 150

        def film():
            frames = []
            for x in (-1, 0, 1):
                SCENE.camera.location.x = x
                frames.append(picture())
            return frames, engine.statistics['bytes']

        loose, bytes_of_loose = film()
        SCENE.light_mesh.memory = 1
        tight, bytes_of_tight = film()
        self.assertEqual(next(iter(engine._sessions.values())).memory_budget, 1 << 20)
        self.assertLess(bytes_of_tight, bytes_of_loose)
        for a, b in zip(loose, tight):
            self.assertTrue((a == b).all())
        budgets = []
        made = core.Session.__init__
        core.Session.__init__ = lambda session, budget=0: budgets.append(budget) or made(session, budget)
        try:
            SCENE.objects['Plane'].select_set(True)
            bpy.context.view_layer.objects.active = SCENE.objects['Plane']
            self.assertEqual(bpy.ops.object.light_mesh_bake(), {'FINISHED'})
            depsgraph = bpy.context.evaluated_depsgraph_get()
            view = viewport.Viewport(SCENE.light_mesh.memory_budget)
            view.update(depsgraph, print)
            if view._commit is not None:
                view._commit.join()
            SCENE.light_mesh.memory = 2
            view.update(bpy.context.evaluated_depsgraph_get(), print)
            view.close()
        finally:
            core.Session.__init__ = made
        self.assertEqual(budgets, [1 << 20, 1 << 20, 2 << 20])

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

    def test_two_view_layers(self):
        """Of one picture: each has its own objects, and keeps what was found of them."""
        scene()
        sphere = SCENE.objects['Sphere']
        balls = bpy.data.collections.new('Balls')
        SCENE.collection.children.link(balls)
        SCENE.collection.objects.unlink(sphere)
        balls.objects.link(sphere)
        alone = picture()
        sphere.hide_render = True
        empty = picture()
        sphere.hide_render = False
        second = SCENE.view_layers.new('Second')
        second.layer_collection.children['Balls'].exclude = True
        self.addCleanup(SCENE.view_layers.remove, second)
        SCENE.use_nodes = True
        self.addCleanup(setattr, SCENE, 'use_nodes', False)
        layers = next(node for node in SCENE.node_tree.nodes if node.type == 'R_LAYERS')
        first = layers.layer
        for name, expected in ((first, alone), ('Second', empty), (first, alone)):
            layers.layer = name
            self.assertTrue((picture() == expected).all(), name)
        self.assertEqual({layer for _, layer in engine._sessions}, {first, 'Second'})
        self.assertFalse((alone == empty).all())

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
