# SPDX-License-Identifier: MIT
"""Soft shadows in colour attributes and images, for games."""

import time

import bpy
import numpy as np

from . import core
from .export import active_uv_layer, export, mesh_arrays
from .materials import LINEAR

# How long the core works until the interface is asked again, seconds.
PATIENCE = .1


def _unit(vectors, where_none=(0, 0, 1)):
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.where(lengths > 0, vectors / np.maximum(lengths, 1e-30), where_none)


def _floats(array):
    return np.ascontiguousarray(array, np.float32)


class _Attribute:
    """A colour for each vertex of a mesh without its modifiers."""

    def __init__(self, thing):
        self._mesh = thing.data
        places, normals = (np.empty((len(self._mesh.vertices), 3), np.float32) for _ in range(2))
        self._mesh.vertices.foreach_get('co', places.ravel())
        self._mesh.vertices.foreach_get('normal', normals.ravel())
        matrix = np.array(thing.matrix_world, np.float64)
        self._places = _floats(places @ matrix[:3, :3].T + matrix[:3, 3])
        self._normals = _floats(_unit(normals @ np.linalg.pinv(matrix[:3, :3])))
        self.count = len(places)

    def points(self, first, count):
        return self._places[first:first + count], self._normals[first:first + count], None

    def write(self, name, colours):
        old = self._mesh.color_attributes.get(name)
        if old is not None:
            self._mesh.color_attributes.remove(old)
        attribute = self._mesh.color_attributes.new(name, 'FLOAT_COLOR', 'POINT')
        rgba = np.ones((len(colours), 4), np.float32)
        rgba[:, :3] = colours
        attribute.data.foreach_set('color', rgba.ravel())
        self._mesh.color_attributes.active_color = attribute
        self._mesh.update()


class _Triangles:
    """Of an object with its modifiers: where its corners are in the world and in the UV map."""

    def __init__(self, thing, depsgraph):
        self.name = thing.name
        evaluated = thing.evaluated_get(depsgraph)
        mesh = evaluated.to_mesh(preserve_all_data_layers=True, depsgraph=depsgraph)
        try:
            layer = active_uv_layer(mesh)
            if layer is None:
                raise core.CoreError(f'object "{thing.name}" has no UV map to bake an image through')
            self.uv_name = layer.name
            positions, vertices, _, normals, _, vertex_normals, uvs = mesh_arrays(mesh, 1, layer)
            if normals is None:
                normals = vertex_normals[vertices]
        finally:
            evaluated.to_mesh_clear()
        matrix = np.array(thing.matrix_world, np.float64)
        self.uvs = uvs
        self.corners = (positions @ matrix[:3, :3].T + matrix[:3, 3])[vertices]
        self.normals = _unit(normals.reshape(-1, 3, 3) @ np.linalg.pinv(matrix[:3, :3]), 0)
        a, b, c = (self.corners[:, k] for k in range(3))
        # Of a mirror image the front stays in front.
        self.flat_normals = _unit(np.cross(b - a, c - a) * (-1 if np.linalg.det(matrix[:3, :3]) < 0 else 1))


def _at(corners, weights):
    """Between three corners, by the weights of the second and third one."""
    second, third = weights[:, :1], weights[:, 1:]
    return (1 - second - third) * corners[:, 0] + second * corners[:, 1] + third * corners[:, 2]


class _Texels:
    """A colour for each texel of an image that some objects share."""

    def __init__(self, things, depsgraph, settings, say):
        self._settings = settings
        self._say = say
        if settings.image is not None:
            _require_pixels(settings.image)
        width, height = settings.image.size if settings.image is not None else (settings.width, settings.height)
        parts = [_Triangles(thing, depsgraph) for thing in things]
        uvs = np.concatenate([part.uvs for part in parts])
        triangles, weights, others = core.cover_texels(width, height, uvs)
        self._size = int(width), int(height)
        self._say_what_is_wrong(parts, uvs, triangles, others)
        self._covered = triangles >= 0
        self._triangles, self._weights = triangles[self._covered], weights[self._covered]
        self.count = len(self._triangles)
        self._corners, self._smooth = (np.concatenate([getattr(part, name) for part in parts])
                                       for name in ('corners', 'normals'))
        self._normals = np.concatenate([part.flat_normals for part in parts])

    def points(self, first, count):
        """Places, normals, and those of smooth shading on the same side."""
        found, weights = self._triangles[first:first + count], self._weights[first:first + count].astype(np.float64)
        normals = self._normals[found]
        smooth = _at(self._smooth[found], weights)
        side = np.where((smooth * normals).sum(axis=1, keepdims=True) < 0, -1, 1)
        smooth = np.where(np.any(smooth, axis=1, keepdims=True), side * _unit(smooth), normals)
        return _floats(_at(self._corners[found], weights)), _floats(normals), _floats(smooth)

    def _say_what_is_wrong(self, parts, uvs, triangles, others):
        ends = np.cumsum([len(part.uvs) for part in parts])
        owner = np.searchsorted(ends, np.arange(ends[-1]), side='right')
        twice = others >= 0
        pairs, counts = np.unique(np.sort(np.stack([owner[triangles[twice]], owner[others[twice]]], 1), axis=1), axis=0,
                                  return_counts=True)
        for (first, second), count in zip(pairs, counts):
            if first == second:
                part = parts[first]
                self._say(f'object "{part.name}": its UV map "{part.uv_name}" overlaps itself in {count:,} texels, which '
                          'show its first triangle there')
            else:
                self._say(f'objects "{parts[first].name}" and "{parts[second].name}" overlap in {count:,} texels of the '
                          'image, which show the first')
        corners = uvs.reshape(-1, 3, 2)
        outside = ~((corners >= -1e-5) & (corners <= 1 + 1e-5)).all(axis=(1, 2))
        flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) == 0
        for number, part in enumerate(parts):
            of_part = owner == number
            for text, count in (('lie not, or in part, inside the image', (outside & of_part).sum()),
                                ('have no area', (flat & of_part).sum())):
                if count:
                    self._say(f'object "{part.name}": {count:,} of its triangles {text} in UV map "{part.uv_name}"')

    def write(self, name, colours):
        """Into the image that was chosen, or one of this name."""
        width, height = self._size
        image = self._image(name)
        values = np.zeros((height * width, 3), np.float32)
        values[self._covered] = colours
        filled = self._covered.astype(np.uint8)
        core.fill_margin(width, height, values, filled, self._settings.margin)
        shown = filled.astype(bool)
        channels = image.channels
        pixels = np.empty((height * width, channels), np.float32)
        if self._settings.use_clear:
            pixels[:] = 0
            if channels == 4 and not _has_alpha(image):
                pixels[:, 3] = 1
        else:
            image.pixels.foreach_get(pixels.ravel())
        if channels < 3:
            pixels[shown, 0] = self._stored(image, values[shown].mean(axis=1))
        else:
            pixels[shown, :3] = self._stored(image, values[shown])
        if channels in (2, 4):
            pixels[shown, channels - 1] = 1
        image.pixels.foreach_set(pixels.ravel())
        image.update()

    def _image(self, name):
        settings = self._settings
        like = settings.image
        if like is not None and settings.what != 'EACH':
            return like
        is_float = like.is_float if like is not None else settings.is_float
        if settings.what == 'EACH':  # those of an earlier time
            old = bpy.data.images.get(name)
            if old is not None and old.size[:] == self._size and old.is_float == is_float:
                return old
        made = bpy.data.images.new(name, *self._size, alpha=_has_alpha(like) if like is not None else settings.use_alpha,
                                   float_buffer=is_float, is_data=settings.what != 'LIGHT')
        if settings.what != 'EACH':
            settings.image = made
        return made

    def _stored(self, image, values):
        """As the pixels of this image are kept."""
        if image.is_float:
            return values
        clipped = int((values.max(axis=-1) > 1).sum()) if values.size else 0
        if clipped:
            self._say(f'image "{image.name}": {clipped:,} texels are brighter than 1, which 8 bits cannot hold; bake to a '
                      'float image')
        space = image.colorspace_settings
        if getattr(space, 'is_data', False) or space.name in LINEAR:
            return np.clip(values, 0, 1)
        if space.name != 'sRGB':
            self._say(f'image "{image.name}": its colour space {space.name} is taken for sRGB')
        values = np.clip(values, 0, 1)
        return np.where(values <= .0031308, 12.92 * values, 1.055 * values ** (1 / 2.4) - .055)


def _has_alpha(image):
    return image.depth in (32, 128) and image.alpha_mode != 'NONE'


def _require_pixels(image):
    if image.library is not None:
        raise core.CoreError(f'image "{image.name}" belongs to another file')
    if image.source not in ('FILE', 'GENERATED') or 0 in image.size[:]:
        raise core.CoreError(f'image "{image.name}" has no pixels to bake into: it is tiled, moves, or is not there')


class _Bake:
    """The work, in steps. `close` ends it at any time: nothing is written before the end."""

    def __init__(self, context, say):
        self._settings = settings = context.scene.light_mesh.bake
        self._session = core.Session(context.scene.light_mesh.memory_budget)
        try:
            things = self._things(context, say)
            depsgraph = context.evaluated_depsgraph_get()
            self._lights = export(self._session, depsgraph, say)
            chosen = [light in context.selected_objects for light in self._lights]
            self._chosen = chosen if any(chosen) else [True] * len(chosen)
            if settings.target == 'IMAGE':
                self._targets = [_Texels(things, depsgraph, settings, say)]
            else:
                self._targets = [_Attribute(thing) for thing in things]
        except BaseException:
            self.close()
            raise

    def _things(self, context, say):
        """The selected objects that have surfaces: attributes are for each mesh once."""
        things = [thing for thing in context.selected_objects if thing.type == 'MESH' and len(thing.data.polygons) > 0]
        if not things:
            raise core.CoreError('the selected meshes have no faces')
        if self._settings.target == 'IMAGE':
            return things
        by_mesh = {}
        for thing in things:
            if thing.data in by_mesh:
                say(f'objects "{by_mesh[thing.data].name}" and "{thing.name}" share a mesh, which shows the first')
            by_mesh.setdefault(thing.data, thing)
        return list(by_mesh.values())

    def close(self):
        self._session.close()

    def steps(self):
        """Gives the share that is done, and the session's core works between."""
        all_points = max(sum(target.count for target in self._targets), 1)
        done = 0
        results = []
        for target in self._targets:
            colours = {name: np.zeros((target.count, 3), np.float32) for name in self._names()}
            first, count = 0, 512
            while first < target.count:
                start = time.perf_counter()
                count = min(count, target.count - first)
                self._bake(target, first, count, colours)
                first += count
                yield (done + first) / all_points
                count = count * 2 if time.perf_counter() - start < PATIENCE / 2 else max(count // 2, 512)
            done += target.count
            results.append((target, colours))
        for target, colours in results:
            for name, values in colours.items():
                target.write(name, values)

    def _names(self):
        """Of what is written: one, or one for each chosen light."""
        settings = self._settings
        if settings.what != 'EACH':
            return [settings.name]
        chosen = {light.name: None for light, is_chosen in zip(self._lights, self._chosen) if is_chosen}
        return [f'{settings.name} {name}' for name in chosen]

    def _bake(self, target, first, count, colours):
        what, name = self._settings.what, self._settings.name
        visible, arriving = self._session.bake(*target.points(first, count), len(self._lights), what == 'LIGHT')
        if what == 'LIGHT':
            colours[name][first:first + count] = arriving
        elif what == 'VISIBILITY':
            colours[name][first:first + count] = visible[:, self._chosen].mean(axis=1)[:, None] if self._lights else 1
        else:
            names = [light.name if is_chosen else None for light, is_chosen in zip(self._lights, self._chosen)]
            for one in {name: None for name in names if name is not None}:
                of_light = [other == one for other in names]  # several, if it is instanced
                colours[f'{name} {one}'][first:first + count] = visible[:, of_light].mean(axis=1)[:, None]


class OBJECT_OT_light_mesh_bake(bpy.types.Operator):
    """Write what the lights do on the selected meshes into a colour attribute or an image"""
    bl_idname = 'object.light_mesh_bake'
    bl_label = 'Bake Soft Shadows'
    bl_options = {'REGISTER', 'UNDO'}

    @classmethod
    def poll(cls, context):
        return context.mode == 'OBJECT' and any(thing.type == 'MESH' for thing in context.selected_objects)

    def _say(self, text):
        self.report({'WARNING'}, f'Light Mesh: {text}')

    def _error(self, error):
        self.report({'ERROR'}, f'Light Mesh: {error}')
        return {'CANCELLED'}

    def execute(self, context):
        """From scripts: until it is done."""
        windows = context.window_manager
        try:
            bake = _Bake(context, self._say)
        except core.CoreError as error:
            return self._error(error)
        windows.progress_begin(0, 1)
        try:
            for share in bake.steps():
                windows.progress_update(share)
        except core.CoreError as error:
            return self._error(error)
        finally:
            windows.progress_end()
            bake.close()
        return {'FINISHED'}

    def invoke(self, context, event):
        """From the interface, which goes on drawing; Escape ends it."""
        try:
            self._bake = _Bake(context, self._say)
        except core.CoreError as error:
            return self._error(error)
        self._steps = self._bake.steps()
        self._timer = context.window_manager.event_timer_add(.01, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {'RUNNING_MODAL'}

    def modal(self, context, event):
        if event.type == 'ESC':
            self._end(context)
            self.report({'INFO'}, 'Light Mesh: baking was cancelled')
            return {'CANCELLED'}
        if event.type != 'TIMER':
            return {'RUNNING_MODAL'}
        try:
            share = next(self._steps)
        except StopIteration:
            self._end(context)
            return {'FINISHED'}
        except (core.CoreError, ReferenceError) as error:
            self._end(context)
            return self._error(error)
        context.workspace.status_text_set(f'Baking soft shadows: {share:.0%}    Escape ends it')
        return {'RUNNING_MODAL'}

    def cancel(self, context):
        self._end(context)

    def _end(self, context):
        context.window_manager.event_timer_remove(self._timer)
        context.workspace.status_text_set(None)
        self._bake.close()


def register():
    bpy.utils.register_class(OBJECT_OT_light_mesh_bake)


def unregister():
    bpy.utils.unregister_class(OBJECT_OT_light_mesh_bake)
