# SPDX-License-Identifier: MIT
"""Baking to colour attributes and images."""

import os
import sys
import unittest

import bpy
import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from support import SCENE, ball, box, camera, lamp, material, reset, run  # noqa: E402


def settings():
    return SCENE.light_mesh.bake


def select(*things):
    bpy.ops.object.select_all(action='DESELECT')
    for thing in things:
        thing.select_set(True)


def bake(**chosen):
    for name, value in chosen.items():
        setattr(settings(), name, value)
    return bpy.ops.object.light_mesh_bake()


def attribute(thing, name='Soft Shadows'):
    values = np.empty(4 * len(thing.data.vertices), np.float32)
    thing.data.color_attributes[name].data.foreach_get('color', values)
    return values.reshape(-1, 4)


def texels(image):
    """Rows from the bottom up."""
    width, height = image.size
    pixels = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(height, width, image.channels)


def grid(size=8, cuts=40):
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=cuts, y_subdivisions=cuts, size=size)
    bpy.context.object.data.materials.append(material())
    return bpy.context.object


def places(thing):
    return np.array([tuple(vertex.co) for vertex in thing.data.vertices])


class Bake(unittest.TestCase):
    def setUp(self):
        reset()
        camera()

    def under_a_plate(self):
        floor = grid()
        plate = box((1, 1, .02), (0, 0, 1))
        light = lamp('POINT', (0, 0, 3), 100 * np.pi ** 2 * 4, shadow_soft_size=.1)
        select(floor)
        return floor, plate, light

    def test_attribute(self):
        """Below a plate it is dark, far from it as bright as by the law of squares."""
        floor, _, light = self.under_a_plate()
        at = places(floor)
        distances = np.linalg.norm(at - (0, 0, 3), axis=1)
        under = np.abs(at[:, :2]).max(axis=1) < .5
        away = np.abs(at[:, :2]).max(axis=1) > 1.2
        baked = {}
        for what in ('LIGHT', 'VISIBILITY'):
            self.assertEqual(bake(what=what), {'FINISHED'})
            baked[what] = attribute(floor)[:, 0]
        self.assertEqual(len(floor.data.color_attributes), 1)
        self.assertTrue((baked['VISIBILITY'][under] == 0).all())
        self.assertTrue((baked['VISIBILITY'][away] == 1).all())
        expected = 100 / distances ** 2 * 3 / distances
        self.assertTrue(np.allclose(baked['LIGHT'][away], expected[away], rtol=2e-3))
        light.data.energy = float('inf')
        with self.assertRaisesRegex(RuntimeError, 'not finite'):
            bake()

    def test_each_light_has_its_own(self):
        floor, plate, light = self.under_a_plate()
        light.name = 'Above'
        lamp('SUN', (0, 0, 5), 1, (.8, 0, 0), angle=.05).name = 'Sun'
        self.assertEqual(bake(what='EACH', name='Shade'), {'FINISHED'})
        self.assertEqual({each.name for each in floor.data.color_attributes}, {'Shade Above', 'Shade Sun'})
        under = np.abs(places(floor)[:, :2]).max(axis=1) < .4
        self.assertTrue((attribute(floor, 'Shade Above')[under] == (0, 0, 0, 1)).all())
        self.assertTrue((attribute(floor, 'Shade Sun')[under, 0] > 0).any())
        # In the mean of both, or of the one that is selected.
        bake(what='VISIBILITY', name='Soft Shadows')
        both = attribute(floor)[:, 0]
        mean = (attribute(floor, 'Shade Above') + attribute(floor, 'Shade Sun'))[:, 0] / 2
        self.assertTrue(np.allclose(both, mean, atol=1e-6))
        select(floor, light)
        bake(what='VISIBILITY')
        self.assertTrue(np.array_equal(attribute(floor), attribute(floor, 'Shade Above')))
        bake(what='EACH', name='Map', target='IMAGE', width=16, height=16)
        self.assertEqual([image.name for image in bpy.data.images if image.name.startswith('Map')], ['Map Above'])
        bake()
        self.assertEqual([image.name for image in bpy.data.images if image.name.startswith('Map')], ['Map Above'])

    def test_an_image_is_what_vertices_get(self):
        """At middles of texels that are vertices, of a floor that is turned and scaled."""
        floor, _, _ = self.under_a_plate()
        floor.rotation_euler, floor.scale = (.1, -.2, .5), (1.1, .9, 1)
        # A third of a texel wide, so that 3 n + 1.5 texels are a vertex.
        for loop, uv in zip(floor.data.loops, floor.data.uv_layers.active.data):
            x, y = floor.data.vertices[loop.vertex_index].co[:2]
            uv.uv = (3 * (x + 4) / .2 + 1.5) / 128, (3 * (y + 4) / .2 + 1.5) / 128
        for what in ('LIGHT', 'VISIBILITY'):
            bake(what=what, target='ATTRIBUTE')
            bake(what=what, target='IMAGE', width=128, height=128, is_float=True, margin=0)
            image = settings().image
            found = texels(image)
            columns, rows = (np.rint((places(floor)[:, axis] + 4) / .2).astype(int) * 3 + 1 for axis in (0, 1))
            self.assertEqual(found[..., 3].sum(), found[..., 3].astype(bool).sum())
            inside = np.abs(places(floor)[:, :2]).max(axis=1) < 3.9  # those at its border are baked farther inside
            at_vertices = found[rows, columns, :3][inside]
            vertices = attribute(floor)[inside, :3]
            self.assertTrue(np.allclose(at_vertices, vertices, rtol=2e-3, atol=5e-3),
                            np.abs(at_vertices - vertices).max())
            self.assertGreater(np.ptp(vertices), .9)
            # Touched texels are filled, others not.
            self.assertTrue((found[1:122, 1:122, 3] == 1).all())
            self.assertTrue((found[123:, :, 3] == 0).all() and (found[:, 123:, 3] == 0).all())

    def test_bytes_margin_and_alpha(self):
        floor, _, _ = self.under_a_plate()
        for uv in floor.data.uv_layers.active.data:
            uv.uv = uv.uv / 2 + type(uv.uv)((.25, .25))
        bake(target='IMAGE', width=64, height=64, is_float=True, margin=3, use_alpha=False)
        as_float = texels(settings().image)
        self.assertTrue((as_float[..., 3] == 1).all())
        self.assertTrue((as_float[:13, :, :3] == 0).all() and (as_float[13:51, 13:51, :3] > 0).any(axis=2).mean() > .9)
        bright = as_float[..., :3] > 1
        settings().image = None
        with self.subTest('8 bits'):
            bake(is_float=False, use_alpha=True)
            image = settings().image
            self.assertEqual(image.colorspace_settings.name, 'sRGB')
            as_bytes = texels(image)
            inside = as_bytes[..., 3] == 1
            self.assertTrue(inside[13:51, 13:51].all())
            self.assertEqual(inside.sum(), 38 ** 2)
            linear = np.where(as_bytes <= .04045, as_bytes / 12.92, ((as_bytes + .055) / 1.055) ** 2.4)[..., :3]
            self.assertTrue(np.allclose(linear, np.clip(as_float[..., :3], 0, 1), atol=.006))
            self.assertTrue((as_bytes[..., :3][bright] == 1).all() and bright.any())
        with self.subTest('a margin continues'):
            self.assertTrue(np.allclose(as_float[13, 20:44], as_float[16, 20:44], rtol=.05))
        with self.subTest('the rest stays'):
            values = np.full(64 * 64 * 4, .5, np.float32)
            image.pixels.foreach_set(values)
            bake(use_clear=False)
            kept = texels(image)
            self.assertTrue((kept[:13] == kept[0, 0]).all() and abs(kept[0, 0, 0] - .5) < .01)
            self.assertTrue(np.array_equal(kept[inside], as_bytes[inside]))

    def test_objects_share_an_image(self):
        """Each in its own half, one of them a mirror image with smooth normals and a modifier."""
        floor, plate, _ = self.under_a_plate()
        sphere = ball(.5, (2.5, 0, .6))
        sphere.scale.x = -1
        sphere.modifiers.new('Smooth', 'SUBSURF')
        for thing, shift in ((floor, 0), (sphere, .5)):
            for uv in thing.data.uv_layers.active.data:
                uv.uv = uv.uv[0] / 2 + shift, uv.uv[1]
        select(floor, sphere)
        bake(target='IMAGE', width=256, height=128, is_float=True, margin=0)
        image = texels(settings().image)
        # The floor's left half as it is alone.
        select(floor)
        settings().image = None
        bake()
        alone = texels(settings().image)
        self.assertTrue(np.array_equal(image[:, :127], alone[:, :127]))
        # The sphere's upper half sees the lamp, without steps at its facets; its lower one does not.
        of_sphere = image[:, 128:]
        self.assertTrue((of_sphere[:25, :, 0] == 0).all())
        self.assertTrue((of_sphere[115:][of_sphere[115:, :, 3] > 0] > 0).all())
        self.assertLess(np.abs(np.diff(of_sphere[100, :, 0])).max(), .06 * of_sphere[100, :, 0].max())

    def test_what_is_wrong_is_said(self):
        floor, plate, _ = self.under_a_plate()
        bake(target='IMAGE', width=32, height=32)
        for uv in plate.data.uv_layers.active.data:
            uv.uv = uv.uv / 3
        for uv in list(floor.data.uv_layers.active.data)[:4]:
            uv.uv = uv.uv[0] - 1, uv.uv[1]
        select(floor, plate)
        warnings = []
        from light_mesh import bake as baking, core
        baked = baking._Bake(bpy.context, warnings.append)
        baked.close()
        for text in ('objects "Cube" and "Grid" overlap in', 'object "Grid": 2 of its triangles lie'):
            swapped = text.replace('"Cube" and "Grid"', '"Grid" and "Cube"')
            self.assertTrue(any(text in line or swapped in line for line in warnings), (text, warnings))
        for uv in plate.data.uv_layers.active.data:
            uv.uv = .5, .5
        warnings.clear()
        baking._Bake(bpy.context, warnings.append).close()
        self.assertTrue(any('object "Cube": 12 of its triangles have no area in UV map "UVMap"' in line for line in warnings),
                        warnings)
        plate.data.uv_layers.remove(plate.data.uv_layers[0])
        with self.assertRaisesRegex(RuntimeError, 'object "Cube" has no UV map'):
            bake()
        select(floor)
        image = settings().image
        image.source = 'TILED'
        with self.assertRaisesRegex(RuntimeError, f'image "{image.name}" has no pixels'):
            bake()
        with self.assertRaisesRegex(core.CoreError, '0 x 4 texels'):
            core.cover_texels(0, 4, np.zeros((1, 6), np.float32))

    def test_cancel(self):
        """What has begun ends between two steps, and writes nothing."""
        floor, _, _ = self.under_a_plate()
        for setting, value in (('target', 'IMAGE'), ('width', 256), ('height', 256)):
            setattr(settings(), setting, value)
        from light_mesh import bake as baking
        baked = baking._Bake(bpy.context, print)
        shares = [share for share, _ in zip(baked.steps(), range(2))]
        self.assertTrue(0 < shares[0] < shares[1] < 1, shares)
        baked.close()
        self.assertIsNone(settings().image)


if __name__ == '__main__':
    run()
