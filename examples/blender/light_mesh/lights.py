# SPDX-License-Identifier: MIT
"""Blender's lights, in its units: watts, and the sun's watts a square metre."""

import math

import numpy as np

from . import core

SHADOWS = {'REAL': core.REAL_LAMP, 'MESH': core.MESH, 'MESH_ATK': core.MESH_ATK, 'HARD': core.HARD_RAYS,
           'NONE': core.NO_SHADOW}
KINDS = {'POINT': core.POINT, 'SUN': core.SUN, 'SPOT': core.SPOT, 'AREA': core.AREA}
# Of the square that has the area of a disc of diameter 1.
DISC_SIDE = math.sqrt(math.pi) / 2


def shadow_of(lamp):
    """The kind of shadow, also by the light's own switch."""
    return lamp.light_mesh.shadow if lamp.use_shadow else 'NONE'


def has_size(lamp):
    if lamp.type == 'AREA':
        return True
    return (lamp.angle if lamp.type == 'SUN' else lamp.shadow_soft_size) > 0


def is_portal(lamp):
    """Whether Cycles takes it for a window that it looks through for the world's light."""
    return lamp.type == 'AREA' and getattr(getattr(lamp, 'cycles', None), 'is_portal', False)


def settings_key(lamp):
    """What lights have in common that share a mesh or a cache; None for those that need neither."""
    chosen, shadow = lamp.light_mesh, shadow_of(lamp)
    if shadow == 'REAL' and has_size(lamp):
        return shadow, chosen.spacing, chosen.detail
    if shadow == 'MESH':
        return shadow, chosen.express, chosen.radius, chosen.quality
    if shadow == 'MESH_ATK':
        return shadow, chosen.express, chosen.radius, chosen.quality, chosen.size
    return None


def _node_colour(lamp, say):
    """What an emission node multiplies the light by."""
    if not lamp.use_nodes or lamp.node_tree is None:
        return np.ones(3)
    output = lamp.node_tree.get_output_node('CYCLES') or lamp.node_tree.get_output_node('ALL')
    links = output.inputs['Surface'].links if output else ()
    node = links[0].from_node if links else None
    if node is not None and node.type == 'EMISSION' and not any(socket.is_linked for socket in node.inputs):
        return np.array(node.inputs['Color'].default_value[:3]) * node.inputs['Strength'].default_value
    say(f'light "{lamp.name}": its nodes are left out')
    return np.ones(3)


def light(lamp, matrix, say):
    """As the core takes it. The energy of a white lamp, divided by pi as a white surface does."""
    axes = np.array(matrix, np.float64)[:3]
    axis = -axes[:, 2]
    chosen = lamp.light_mesh
    strength = np.array(lamp.color[:]) * lamp.energy * _node_colour(lamp, say) / math.pi
    if lamp.type in ('POINT', 'SPOT'):
        strength /= 4 * math.pi
    elif lamp.type == 'AREA':
        strength /= 4
    made = core.Light(name=lamp.name.encode(), kind=KINDS[lamp.type], shadow=SHADOWS[shadow_of(lamp)],
                      position=core.Float3(*axes[:, 3]), axis=core.Float3(*axis), strength=core.Float3(*strength),
                      spacing=chosen.spacing, detail=chosen.detail, radius=chosen.radius, quality=chosen.quality,
                      express=chosen.express, map_size=chosen.size)
    if lamp.type == 'SUN':
        made.size = min(lamp.angle / 2, 1.5)
    elif lamp.type == 'AREA':
        _add_area(made, lamp, axes, say)
    else:
        made.size = lamp.shadow_soft_size
    if lamp.type == 'SPOT':
        made.cone, made.blend = lamp.spot_size / 2, lamp.spot_blend
    return made


def _add_area(made, lamp, axes, say):
    width = lamp.size
    height = lamp.size_y if lamp.shape in ('RECTANGLE', 'ELLIPSE') else width
    if lamp.shape in ('DISK', 'ELLIPSE'):
        say(f'light "{lamp.name}": its disc is taken for a rectangle of the same area')
        width, height = width * DISC_SIDE, height * DISC_SIDE
    half_u, half_v = axes[:, 0] * max(width, 1e-6) / 2, axes[:, 1] * max(height, 1e-6) / 2
    if np.dot(np.cross(half_u, half_v), axes[:, 2]) > 0:  # it shines down
        half_v = -half_v
    made.half_u, made.half_v = core.Float3(*half_u), core.Float3(*half_v)
    if getattr(lamp, 'spread', math.pi) < math.pi - 1e-3:
        say(f'light "{lamp.name}": its spread is left out')
