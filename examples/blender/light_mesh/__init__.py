# SPDX-License-Identifier: MIT
"""The light mesh method and the visibility cache as a render engine of Blender."""

bl_info = {
    'name': 'Light Mesh',
    'author': 'The authors of lightmesh',
    'version': (0, 1, 0),
    'blender': (3, 4, 0),
    'location': 'Render Properties > Render Engine > Light Mesh',
    'description': 'Soft shadows of real lamps, and of many lights, found once and interpolated',
    'category': 'Render',
}

from . import bake, engine, panels, properties  # noqa: E402

PARTS = (properties, engine, bake, panels)


def register():
    for part in PARTS:
        part.register()


def unregister():
    for part in reversed(PARTS):
        part.unregister()
