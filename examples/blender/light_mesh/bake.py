# SPDX-License-Identifier: MIT
"""Soft shadows as colours of vertices, for games."""

import bpy
import numpy as np
from bpy.props import EnumProperty, StringProperty

from . import core
from .export import export


def _vertices(thing):
    """Places and normals in world space, of the mesh without its modifiers."""
    mesh = thing.data
    values = []
    for name in ('co', 'normal'):
        array = np.empty(3 * len(mesh.vertices), np.float32)
        mesh.vertices.foreach_get(name, array)
        values.append(array.reshape(-1, 3).astype(np.float64))
    matrix = np.array(thing.matrix_world, np.float64)
    places = values[0] @ matrix[:3, :3].T + matrix[:3, 3]
    normals = values[1] @ np.linalg.pinv(matrix[:3, :3])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.where(lengths > 0, normals / np.maximum(lengths, 1e-30), (0, 0, 1))
    return np.ascontiguousarray(places, np.float32), np.ascontiguousarray(normals, np.float32)


class OBJECT_OT_light_mesh_bake(bpy.types.Operator):
    """Write what the lights do at the vertices of the selected meshes into a colour attribute"""
    bl_idname = 'object.light_mesh_bake'
    bl_label = 'Bake Soft Shadows'
    bl_options = {'REGISTER', 'UNDO'}

    what: EnumProperty(name='What', default='LIGHT', items=(
        ('LIGHT', 'Light', 'What a white surface sends back, with shadows'),
        ('VISIBILITY', 'Visibility', 'Which share of the lights is seen: of the selected ones, else of all')))
    attribute: StringProperty(name='Attribute', default='Soft Shadows')

    @classmethod
    def poll(cls, context):
        return context.mode == 'OBJECT' and any(thing.type == 'MESH' for thing in context.selected_objects)

    def execute(self, context):
        session = core.Session()
        try:
            lights = export(session, context.evaluated_depsgraph_get(), lambda text: self.report({'WARNING'}, text))
            chosen = [light in context.selected_objects for light in lights]
            if not any(chosen):
                chosen = [True] * len(lights)
            for mesh, thing in {thing.data: thing for thing in context.selected_objects if thing.type == 'MESH'}.items():
                visible, colours = session.bake(*_vertices(thing), len(lights))
                if self.what == 'VISIBILITY':
                    shares = visible[:, chosen].mean(axis=1) if lights else np.ones(len(visible))
                    colours = np.repeat(shares[:, None], 3, 1)
                self._write(mesh, colours)
        except core.CoreError as error:
            self.report({'ERROR'}, f'Light Mesh: {error}')
            return {'CANCELLED'}
        finally:
            session.close()
        return {'FINISHED'}

    def _write(self, mesh, colours):
        old = mesh.color_attributes.get(self.attribute)
        if old is not None:
            mesh.color_attributes.remove(old)
        attribute = mesh.color_attributes.new(self.attribute, 'FLOAT_COLOR', 'POINT')
        rgba = np.ones((len(colours), 4), np.float32)
        rgba[:, :3] = colours
        attribute.data.foreach_set('color', rgba.ravel())
        mesh.color_attributes.active_color = attribute
        mesh.update()


def register():
    bpy.utils.register_class(OBJECT_OT_light_mesh_bake)


def unregister():
    bpy.utils.unregister_class(OBJECT_OT_light_mesh_bake)
