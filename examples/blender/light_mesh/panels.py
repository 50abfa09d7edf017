# SPDX-License-Identifier: MIT
"""Panels of the render and the light tab, and those of Blender that fit."""

import bpy

from . import engine
from .lights import is_portal, settings_key, shadow_of

# Of Blender's panels for any engine: what this one has in its own, or cannot do.
LEFT_OUT = {'DATA_PT_light', 'NODE_DATA_PT_light', 'RENDER_PT_freestyle', 'VIEWLAYER_PT_filter', 'VIEWLAYER_PT_layer_passes'}
OF_EEVEE = ('EEVEE_MATERIAL_PT_context_material', 'EEVEE_MATERIAL_PT_surface', 'EEVEE_WORLD_PT_surface')


class _Panel:
    bl_space_type = 'PROPERTIES'
    bl_region_type = 'WINDOW'
    COMPAT_ENGINES = {engine.ENGINE}

    @classmethod
    def poll(cls, context):
        return context.engine in cls.COMPAT_ENGINES


class _LightPanel(_Panel):
    bl_context = 'data'

    @classmethod
    def poll(cls, context):
        return context.light is not None and super().poll(context)


def _column(layout):
    layout.use_property_split = True
    layout.use_property_decorate = False
    return layout.column()


def shining(view_layer):
    """The lights of a picture, but those that nodes or particles make: of a collection that is instanced once."""
    lamps, shown = {}, []

    def visit(layer):
        if not layer.exclude and not layer.collection.hide_render:
            shown.extend(layer.collection.objects)
            for child in layer.children:
                visit(child)

    visit(view_layer.layer_collection)
    for thing in shown:
        instanced = thing.instance_collection if thing.instance_type == 'COLLECTION' else None
        for each in (thing, *(instanced.all_objects if instanced else ())):
            if each.type == 'LIGHT' and not each.hide_render and not thing.hide_render and not is_portal(each.data):
                lamps[each] = None
    return list(lamps)


def group_count(view_layer):
    """Caches and meshes that the lights need: one for each distinct settings."""
    return len({settings_key(thing.data) for thing in shining(view_layer)} - {None})


class LIGHT_MESH_PT_sampling(_Panel, bpy.types.Panel):
    bl_label = 'Sampling'
    bl_context = 'render'

    def draw(self, context):
        column = _column(self.layout)
        column.prop(context.scene.light_mesh, 'samples')
        column.prop(context.scene.light_mesh, 'viewport_samples')
        column.prop(context.scene.light_mesh, 'bounces')


class LIGHT_MESH_PT_ambient(_Panel, bpy.types.Panel):
    bl_label = 'Ambient Light'
    bl_context = 'render'

    def draw(self, context):
        settings = context.scene.light_mesh
        column = _column(self.layout)
        column.prop(settings, 'ambient')
        if settings.ambient == 'OCCLUSION':
            column.prop(settings, 'ambient_rays')
            column.prop(settings, 'ambient_distance')


class LIGHT_MESH_PT_shadows(_Panel, bpy.types.Panel):
    bl_label = 'Shadows'
    bl_context = 'render'

    def draw(self, context):
        column = _column(self.layout)
        column.prop(context.scene.light_mesh, 'memory')
        count = group_count(context.view_layer)
        column.label(text=f'Caches and light meshes: {count}', icon='LIGHT_DATA')
        found = engine.statistics
        if found:
            column.label(text=f'Last picture: {found["seconds"]:.2f} s, of these {found["seconds_exporting"]:.2f} s for reading')
            instanced = f' ({found["stored_triangles"]:,} in memory)' if found['stored_triangles'] < found['triangles'] else ''
            column.label(text=f'{found["triangles"]:,} triangles{instanced}, {found["points"]:,} points shaded')
            column.label(text=f'{found["groups"]} ways to find shadows, {found["groups_kept"]} kept from the picture before')
            column.label(text=f'{found["records"]:,} records, {found["light_points"]:,} light points, '
                              f'{found["bytes"] / 2**20:,.1f} MB')


class LIGHT_MESH_PT_bake(_Panel, bpy.types.Panel):
    bl_label = 'Bake'
    bl_context = 'render'
    bl_options = {'DEFAULT_CLOSED'}

    def draw(self, context):
        settings = context.scene.light_mesh.bake
        column = _column(self.layout)
        column.operator('object.light_mesh_bake', icon='RENDER_STILL')
        column.prop(settings, 'what')
        column.prop(settings, 'target')
        if settings.target == 'IMAGE':
            self._draw_image(column, settings)
        else:
            column.prop(settings, 'name')

    @staticmethod
    def _draw_image(column, settings):
        column.template_ID(settings, 'image', new='image.new', open='image.open', text='Image')
        if settings.image is None or settings.what == 'EACH':
            column.prop(settings, 'name')
        if settings.image is None:
            column.prop(settings, 'width')
            column.prop(settings, 'height')
            column.prop(settings, 'is_float')
            column.prop(settings, 'use_alpha')
        column.prop(settings, 'margin')
        column.prop(settings, 'use_clear')


class LIGHT_MESH_PT_light(_LightPanel, bpy.types.Panel):
    bl_label = 'Light'

    def draw(self, context):
        lamp = context.light
        self.layout.row().prop(lamp, 'type', expand=True)
        column = _column(self.layout)
        column.prop(lamp, 'color')
        column.prop(lamp, 'energy', text='Strength' if lamp.type == 'SUN' else 'Power')
        if lamp.type == 'SUN':
            column.prop(lamp, 'angle')
        elif lamp.type == 'AREA':
            column.prop(lamp, 'shape')
            column.prop(lamp, 'size', text='Size X' if lamp.shape in {'RECTANGLE', 'ELLIPSE'} else 'Size')
            if lamp.shape in {'RECTANGLE', 'ELLIPSE'}:
                column.prop(lamp, 'size_y', text='Y')
        else:
            column.prop(lamp, 'shadow_soft_size', text='Radius')
        if lamp.type == 'SPOT':
            column.prop(lamp, 'spot_size')
            column.prop(lamp, 'spot_blend')


class LIGHT_MESH_PT_light_shadow(_LightPanel, bpy.types.Panel):
    bl_label = 'Shadow'

    def draw_header(self, context):
        self.layout.prop(context.light, 'use_shadow', text='')

    def draw(self, context):
        lamp = context.light
        chosen = lamp.light_mesh
        self.layout.active = lamp.use_shadow
        column = _column(self.layout)
        column.prop(chosen, 'shadow')
        if chosen.shadow == 'REAL':
            column.prop(chosen, 'spacing')
            column.prop(chosen, 'detail')
        elif chosen.shadow in {'MESH', 'MESH_ATK'}:
            column.prop(chosen, 'express')
            column.prop(chosen, 'quality')
            column.prop(chosen, 'radius')
            row = column.row()
            row.active = chosen.shadow == 'MESH_ATK'
            row.prop(chosen, 'size')
        key = settings_key(lamp)
        if key is not None:
            same = sum(settings_key(thing.data) == key for thing in shining(context.view_layer))
            column.label(text=f'{"Cache" if chosen.shadow == "REAL" else "Mesh"} of {same} light{"" if same == 1 else "s"}, '
                              f'one of {group_count(context.view_layer)} in the scene')
        elif shadow_of(lamp) == 'REAL':
            column.label(text='A lamp without a size: hard shadows')


CLASSES = (LIGHT_MESH_PT_sampling, LIGHT_MESH_PT_ambient, LIGHT_MESH_PT_shadows, LIGHT_MESH_PT_bake, LIGHT_MESH_PT_light,
           LIGHT_MESH_PT_light_shadow)


def _of_blender():
    for panel in bpy.types.Panel.__subclasses__():
        if 'BLENDER_RENDER' in getattr(panel, 'COMPAT_ENGINES', ()) and panel.__name__ not in LEFT_OUT:
            yield panel
    for name in OF_EEVEE:
        panel = getattr(bpy.types, name, None)
        if panel is not None:
            yield panel


def register():
    for each in CLASSES:
        bpy.utils.register_class(each)
    for panel in _of_blender():
        panel.COMPAT_ENGINES.add(engine.ENGINE)


def unregister():
    for panel in bpy.types.Panel.__subclasses__():
        if panel not in CLASSES:
            getattr(panel, 'COMPAT_ENGINES', set()).discard(engine.ENGINE)
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)
