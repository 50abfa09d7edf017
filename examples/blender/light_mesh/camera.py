# SPDX-License-Identifier: MIT
"""All of Blender's cameras but panoramas, by their matrices."""

import numpy as np

from . import core


def view(projection, to_world, width, height, part):
    """The part (left, bottom, width, height), in pixels, of a picture of this size."""
    p = np.array(projection, np.float64)
    m = np.array(to_world, np.float64)
    is_orthographic = p[3, 2] == 0
    # What lies at a distance of 1 goes to the edges; in an orthographic view at any.
    if is_orthographic:
        left, right = (-1 - p[0, 3]) / p[0, 0], (1 - p[0, 3]) / p[0, 0]
        bottom, top = (-1 - p[1, 3]) / p[1, 1], (1 - p[1, 3]) / p[1, 1]
        near, far = (p[2, 3] + 1) / p[2, 2], (p[2, 3] - 1) / p[2, 2]
    else:
        left, right = (p[0, 2] - 1) / p[0, 0], (p[0, 2] + 1) / p[0, 0]
        bottom, top = (p[1, 2] - 1) / p[1, 1], (p[1, 2] + 1) / p[1, 1]
        near, far = p[2, 3] / (p[2, 2] - 1), p[2, 3] / (p[2, 2] + 1)
    x, y, w, h = part
    edges = (left + (right - left) * x / width, left + (right - left) * (x + w) / width,
             bottom + (top - bottom) * y / height, bottom + (top - bottom) * (y + h) / height)
    ahead, up = -m[:3, 2] / np.linalg.norm(m[:3, 2]), m[:3, 1] / np.linalg.norm(m[:3, 1])
    eye = m[:3, 3]
    if is_orthographic:
        eye = eye + near * ahead  # the near plane may lie behind the camera
        near, far = 0, far - near
    return core.View(eye=core.Float3(*eye), ahead=core.Float3(*ahead), up=core.Float3(*up),
                     edges=(core.c.c_float * 4)(*edges), z_near=near, z_far=far, is_orthographic=int(is_orthographic),
                     width=w, height=h)


def border(render, width, height):
    """The part of the picture that is asked for: (left, bottom, width, height) in pixels."""
    if not render.use_border:
        return 0, 0, width, height
    left, right = (int(np.float32(share) * np.float32(width)) for share in (render.border_min_x, render.border_max_x))
    bottom, top = (int(np.float32(share) * np.float32(height)) for share in (render.border_min_y, render.border_max_y))
    return left, bottom, right - left, top - bottom
