# SPDX-License-Identifier: MIT
"""Soft shadows of real lamps against Cycles with 1,024 samples: direct light, the same sizes of lamps."""

import os
import sys
import time
import unittest

import numpy as np

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from support import SCENE, ball, box, camera, lamp, picture, plane, reset, run  # noqa: E402


def stage():
    """A fence and a ball before a lamp."""
    plane(16)
    for i in range(9):
        box((.08, .08, 1.2), (-2 + .5 * i, 1, .6))
    box((4.2, .06, .08), (0, 1, 1))
    ball(.6, (.8, -.8, .6))
    lamp('POINT', (1.5, 4, 4), 600, shadow_soft_size=.25)
    lamp('SUN', (0, 0, 9), .8, (.7, -.4, 0), angle=.05)
    camera((0, -7, 4.5), (1.05, 0, 0))


def rooms():
    """Two rooms with a door between them, a lamp in each, and tables."""
    plane(20)
    for x in (-4, 0, 4):
        for y in ((0,) if x else (-1.75, 1.75)):
            box((.1, 6.1 if x else 2.5, 2.6), (x, y, 1.3))
    box((8.1, .1, 2.6), (0, 3, 1.3))
    for x in (-2, 2):
        box((1.4, .8, .05), (x, .6, .75))
        for side in (-.65, .65):
            box((.06, .7, .75), (x + side, .6, .375))
        lamp('POINT', (x, 0, 2.3), 120, shadow_soft_size=.12)
    camera((0, -7, 6), (.85, 0, 0), lens=32)


def startup():
    """The cube, the lamp and the view of Blender's own scene."""
    box((2, 2, 2), (0, 0, 0))
    plane(12, (0, 0, -1))
    lamp('POINT', (4.08, 1.01, 5.9), 1000, shadow_soft_size=.1)
    camera((7.36, -6.93, 4.96), (1.109, 0, .815))


def areas():
    """An area lamp and a spot above boxes."""
    plane(12)
    for i in range(3):
        box((.6, .6, .4 + .5 * i), (-1.5 + 1.5 * i, .3 * i, .2 + .25 * i))
    lamp('AREA', (-1, -1, 4), 300, (.2, -.2, 0), shape='RECTANGLE', size=1.5, size_y=.5)
    lamp('SPOT', (3, -2, 4), 500, (.5, .6, 0), spot_size=1, spot_blend=.3, shadow_soft_size=.15)
    camera((0, -7, 5), (.95, 0, 0))


class Shadows(unittest.TestCase):
    def compare(self, build):
        """Of white, and of the picture's mean, which is what the noise of Cycles and edges are seen against."""
        reset()
        build()
        SCENE.render.resolution_x, SCENE.render.resolution_y = 80, 60
        SCENE.cycles.samples = 1024
        SCENE.light_mesh.samples = 64
        start = time.process_time()
        reference = picture('CYCLES')[..., :3]
        middle = time.process_time()
        ours = picture()[..., :3]
        end = time.process_time()
        difference = np.abs(ours - reference).mean()
        ratio = ours.mean() / reference.mean()
        print(f'shadows: {build.__name__:8} mean absolute difference {difference:.2%} of white, '
              f'{difference / reference.mean():.2%} of the mean (to reach 0.50 %), ratio {ratio:.4f}, Cycles {middle - start:.2f} s, '
              f'Light Mesh {end - middle:.2f} s of processor time')
        self.assertLess(difference, .004)
        self.assertLess(difference / reference.mean(), .005)
        self.assertAlmostEqual(ratio, 1, delta=.005)

    def test_stage(self):
        self.compare(stage)

    def test_rooms(self):
        self.compare(rooms)

    def test_startup(self):
        self.compare(startup)

    def test_areas(self):
        self.compare(areas)


if __name__ == '__main__':
    run()
