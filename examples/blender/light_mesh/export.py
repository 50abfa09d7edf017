# SPDX-License-Identifier: MIT
"""Tells a session what Blender's scene is at a frame."""

import numpy as np

from . import lights
from .core import CoreError
from .materials import Materials

SURFACES = {'MESH', 'CURVE', 'SURFACE', 'FONT', 'META'}
# That have nothing to draw.
WITHOUT_SURFACE = {'CAMERA', 'EMPTY', 'ARMATURE', 'LATTICE', 'SPEAKER', 'LIGHT_PROBE', 'LIGHT'}


class Cancelled(Exception):
    """The user does not want the picture any more."""


def _corner_normals(mesh, corners):
    normals = np.empty(3 * len(mesh.loops), np.float32)
    if hasattr(mesh, 'calc_normals_split'):
        mesh.calc_normals_split()
        mesh.loops.foreach_get('normal', normals)
    else:
        mesh.corner_normals.foreach_get('vector', normals)
    return normals.reshape(-1, 3)[corners].reshape(-1, 9)


def _corner_uvs(mesh, corners):
    layer = next((layer for layer in mesh.uv_layers if layer.active_render), None)
    if layer is None:
        return None
    uvs = np.empty(2 * len(mesh.loops), np.float32)
    layer.data.foreach_get('uv', uvs)
    return uvs.reshape(-1, 2)[corners].reshape(-1, 6)


def mesh_arrays(mesh, slot_count):
    """Positions, corners, material slots, and the normals and texture coordinates of the corners of triangles."""
    mesh.calc_loop_triangles()
    count = len(mesh.loop_triangles)
    positions = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get('co', positions)
    vertices, corners = np.empty(3 * count, np.int32), np.empty(3 * count, np.int32)
    mesh.loop_triangles.foreach_get('vertices', vertices)
    mesh.loop_triangles.foreach_get('loops', corners)
    slots = np.empty(count, np.int32)
    mesh.loop_triangles.foreach_get('material_index', slots)
    return (positions.reshape(-1, 3), vertices.reshape(-1, 3), np.clip(slots, 0, slot_count - 1),
            _corner_normals(mesh, corners), _corner_uvs(mesh, corners))


class _Exporter:
    def __init__(self, session, say):
        self._session = session
        self._say = say
        self._materials = Materials(session, say)
        self._meshes = {}

    def add(self, instance):
        thing = instance.object
        if thing.type == 'LIGHT':
            self._session.add_light(lights.light(thing.data, instance.matrix_world, self._say))
        elif thing.type in SURFACES:
            if instance.show_self:
                self._add_surface(instance, thing)
            for system in thing.particle_systems if not instance.is_instance else ():
                if system.settings.type == 'HAIR' and system.settings.render_type == 'PATH':
                    self._say(f'object "{thing.name}": its hair is left out')
        elif thing.type not in WITHOUT_SURFACE:
            self._say(f'object "{thing.name}" is left out: {thing.type.lower()}')

    def _add_surface(self, instance, thing):
        if thing.is_holdout:
            self._say(f'object "{thing.name}": that it is a holdout is left out')
        if not (thing.visible_camera and thing.visible_shadow):
            self._say(f'object "{thing.name}": it is drawn with its shadow, whatever its ray visibility')
        slots = [slot.material for slot in thing.material_slots]
        key = (thing.data.as_pointer() if thing.type == 'MESH' else
               (instance.instance_object or thing).original.as_pointer()), len(slots)
        if key not in self._meshes:
            self._meshes[key] = self._mesh(thing, len(slots))
        mesh, own_materials = self._meshes[key]
        if mesh is not None:
            materials = slots if len(slots) >= len(own_materials) else own_materials
            self._session.add_object(mesh, instance.matrix_world,
                                     [self._materials.number(material) for material in materials or [None]])

    def _mesh(self, thing, slot_count):
        """Its number, and its own materials."""
        try:
            mesh = thing.to_mesh()
        except RuntimeError:
            mesh = None
        if mesh is None:
            return None, []
        own = list(mesh.materials)
        try:
            if len(mesh.polygons) == 0:
                return None, own
            arrays = mesh_arrays(mesh, max(slot_count, len(own), 1))
            return self._session.add_mesh(thing.name, *arrays), own
        finally:
            thing.to_mesh_clear()


def export(session, depsgraph, say, is_cancelled=lambda: False):
    """Raises CoreError for what cannot be drawn, and Cancelled."""
    session.begin()
    exporter = _Exporter(session, say)
    for instance in depsgraph.object_instances:
        if is_cancelled():
            raise Cancelled
        exporter.add(instance)
    session.commit()


__all__ = ['Cancelled', 'CoreError', 'export', 'mesh_arrays']
