# SPDX-License-Identifier: MIT
"""Tells a session what Blender's scene is at a frame."""

import ctypes

import bpy
import numpy as np

from . import lights
from .core import CoreError, hash_of
from .materials import Materials

SURFACES = {'MESH', 'CURVE', 'SURFACE', 'FONT', 'META'}
# That have nothing to draw.
WITHOUT_SURFACE = {'CAMERA', 'EMPTY', 'ARMATURE', 'LATTICE', 'SPEAKER', 'LIGHT_PROBE', 'LIGHT'}
# Whose visibility objects have.
RAYS = 'camera', 'diffuse', 'glossy', 'transmission', 'volume_scatter', 'shadow'
# The others never see lights here.
RAYS_OF_LIGHTS = RAYS[1:-1]


class Cancelled(Exception):
    """The user does not want the picture any more."""


def _rows(collection, columns, dtype, first, last):
    """A view of a collection's own memory, whose items begin with so many numbers; None if it does not lie so.

    Blender copies these item by item, which takes longer than all the rest. `first` and `last` are what the view must
    show."""
    count = len(collection)
    if count < 2:
        return None
    address = collection[0].as_pointer()
    stride = collection[1].as_pointer() - address
    if stride < columns * 4 or collection[count - 1].as_pointer() != address + (count - 1) * stride:
        return None
    block = (ctypes.c_char * (count * stride)).from_address(address)
    view = np.ndarray((count, columns), dtype, block, 0, (stride, 4))
    return view if tuple(view[0]) == tuple(first) and tuple(view[-1]) == tuple(last) else None


def _read(collection, name, columns, dtype):
    values = np.empty((len(collection), columns), dtype)
    collection.foreach_get(name, values.ravel())
    return values


def _corners(mesh):
    """Of the triangles: their loops, and the loops' vertices."""
    triangles, loops = mesh.loop_triangles, mesh.loops
    of_triangles = _rows(triangles, 3, np.int32, triangles[0].loops, triangles[-1].loops)
    if of_triangles is None:
        of_triangles = _read(triangles, 'loops', 3, np.int32)
    vertices = _rows(loops, 1, np.int32, (loops[0].vertex_index,), (loops[-1].vertex_index,))
    if vertices is None:
        vertices = _read(loops, 'vertex_index', 1, np.int32)
    return of_triangles, vertices[:, 0][of_triangles]


def _normals(mesh, corners, vertices):
    """Those of the corners of triangles with what the core calls their smoothing, and those of the vertices: either are
    None."""
    if hasattr(mesh, 'corner_normals') and mesh.normals_domain == 'CORNER':  # later versions
        return _read(mesh.corner_normals, 'vector', 3, np.float32)[corners].reshape(-1, 9), np.array(corners, order='C'), None
    if getattr(mesh, 'use_auto_smooth', False) or mesh.has_custom_normals:
        mesh.calc_normals_split()
        return _read(mesh.loops, 'normal', 3, np.float32)[corners].reshape(-1, 9), np.array(corners, order='C'), None
    is_smooth = np.empty(len(mesh.polygons), bool)
    mesh.polygons.foreach_get('use_smooth', is_smooth)
    smooth = _read(mesh.vertex_normals, 'vector', 3, np.float32) if is_smooth.any() else None
    if is_smooth.all():
        return None, None, smooth
    polygons = _read(mesh.loop_triangles, 'polygon_index', 1, np.int32)[:, 0]
    normals = np.repeat(_read(mesh.polygon_normals, 'vector', 3, np.float32)[polygons][:, None], 3, 1)
    smoothing = polygons
    if smooth is not None:
        normals = np.where(is_smooth[polygons][:, None, None], smooth[vertices], normals)
        smoothing = np.where(is_smooth[polygons], -1, polygons)
    return np.ascontiguousarray(normals).reshape(-1, 9), np.repeat(smoothing[:, None], 3, 1).astype(np.int32), None


def active_uv_layer(mesh):
    """The UV map that is edited; None if there is none."""
    return mesh.uv_layers.active


def rendered_uv_layer(mesh):
    """The UV map that pictures are mapped by; None if there is none."""
    return next((layer for layer in mesh.uv_layers if layer.active_render), None)


def _corner_uvs(layer, corners):
    return _read(layer.data, 'uv', 2, np.float32)[corners].reshape(-1, 6)


def mesh_arrays(mesh, slot_count, uv_layer):
    """Positions, corners, material slots, the normals of the corners of triangles with their smoothing, or those of the
    vertices (the others are None), and the corners' texture coordinates, None without a UV map."""
    mesh.calc_loop_triangles()
    corners, vertices = _corners(mesh)
    slots = np.zeros(len(corners), np.int32)
    if slot_count > 1:
        mesh.loop_triangles.foreach_get('material_index', slots)
        slots = np.clip(slots, 0, slot_count - 1)
    return (_read(mesh.vertices, 'co', 3, np.float32), vertices, slots, *_normals(mesh, corners, vertices),
            _corner_uvs(uv_layer, corners) if uv_layer is not None else None)


class Untouched:
    """Which meshes are as the export before read them: for a 3-D view, whose depsgraph names all edits in between."""

    def __init__(self):
        self._hashes = {}
        self._seen = {}
        self._edited = set()

    def note(self, depsgraph):
        """The edits since the last time."""
        self._edited |= {update.id.original.as_pointer() for update in depsgraph.updates
                         if update.is_updated_geometry or not isinstance(update.id, bpy.types.Object)}

    def begin(self):
        """Before an export: forgets what was edited, and what the last export did not ask for."""
        self._hashes = {key: value for key, value in self._seen.items() if self._edited.isdisjoint(key[:2])}
        self._seen = {}
        self._edited = set()

    @staticmethod
    def key(instance, *more):
        """None where the mesh is not an object's own: what modifiers instance has no edits of its own."""
        thing = instance.object
        if instance.is_instance or thing.type != 'MESH':
            return None
        mesh = thing.data
        return (thing.original.as_pointer(), thing.original.data.as_pointer(), mesh.as_pointer(), len(mesh.vertices),
                len(mesh.polygons)) + more

    def find(self, key):
        return self._hashes.get(key)

    def keep(self, key, mesh_hash):
        if key is not None:
            self._seen[key] = mesh_hash


def _light_id(instance):
    """The same in all frames."""
    parts = [(instance.instance_object or instance.object).original.as_pointer()]
    if instance.is_instance:
        parts += [instance.parent.original.as_pointer(), *instance.persistent_id]
    return hash_of(np.array(parts, np.int64))


class _Exporter:
    def __init__(self, session, say, untouched):
        self._session = session
        self._say = say
        self._untouched = untouched
        self._materials = Materials(session, say)
        self._meshes = {}
        self.lights = []

    def add(self, instance):
        thing = instance.object
        if thing.type == 'LIGHT':
            self._say_what_rays_see(thing, RAYS_OF_LIGHTS)
            if lights.is_portal(thing.data):
                self._say(f'light "{thing.name}" is left out: it is a portal')
                return
            light = lights.light(thing.data, instance.matrix_world, self._say)
            light.id = _light_id(instance)
            self._session.add_light(light)
            self.lights.append((instance.instance_object or thing).original)
        elif thing.type in SURFACES:
            if instance.show_self:
                self._add_surface(instance, thing)
            for system in thing.particle_systems if not instance.is_instance else ():
                if system.settings.type == 'HAIR' and system.settings.render_type == 'PATH':
                    self._say(f'object "{thing.name}": its hair is left out')
        elif thing.type not in WITHOUT_SURFACE:
            self._say(f'object "{thing.name}" is left out: {thing.type.lower()}')

    def _say_what_rays_see(self, thing, kinds=RAYS):
        hidden = [name.replace('_', ' ') for name in kinds if not getattr(thing, f'visible_{name}', True)]
        if hidden:
            self._say(f'object "{thing.name}": that it is hidden from rays of {", ".join(hidden)} is left out')

    def _add_surface(self, instance, thing):
        for text, is_so in (('a holdout', thing.is_holdout), ('a shadow catcher', thing.is_shadow_catcher)):
            if is_so:
                self._say(f'object "{thing.name}": that it is {text} is left out')
        self._say_what_rays_see(thing)
        slots = [slot.material for slot in thing.material_slots]
        own = list(getattr(thing.data, 'materials', ()))
        chosen = slots if len(slots) >= len(own) else own
        numbers = [self._materials.number(material) for material in chosen or [None]]
        with_uvs = self._materials.have_pictures(numbers)
        key = (thing.data.as_pointer() if thing.type == 'MESH' else
               (instance.instance_object or thing).original.as_pointer()), len(numbers), with_uvs
        if key not in self._meshes:
            self._meshes[key] = self._mesh(instance, thing, len(numbers), with_uvs)
        if self._meshes[key] is not None:
            self._session.add_object(self._meshes[key], instance.matrix_world, numbers)

    def _mesh(self, instance, thing, slot_count, with_uvs):
        """Its number; None if there are no surfaces."""
        place = self._untouched and self._untouched.key(instance, slot_count, with_uvs)
        mesh_hash = self._untouched and self._untouched.find(place)
        number = self._session.find_mesh(mesh_hash) if mesh_hash is not None else None
        if number is None:
            arrays = self._arrays(thing, slot_count, with_uvs)
            if arrays is None:
                return None
            mesh_hash = hash_of(*arrays)
            number = self._session.add_mesh(mesh_hash, thing.name, *arrays)
        if self._untouched:
            self._untouched.keep(place, mesh_hash)
        return number

    @staticmethod
    def _arrays(thing, slot_count, with_uvs):
        """As `mesh_arrays`; None if there are no surfaces."""
        def read(mesh):
            if mesh is None or len(mesh.polygons) == 0:
                return None
            return mesh_arrays(mesh, slot_count, rendered_uv_layer(mesh) if with_uvs else None)

        if thing.type == 'MESH' and not getattr(thing.data, 'use_auto_smooth', False):
            return read(thing.data)  # evaluated already: no copy
        try:
            mesh = thing.to_mesh()
        except RuntimeError:
            mesh = None
        try:
            return read(mesh)
        finally:
            thing.to_mesh_clear()


def _say_what_layers_ask(view_layer, say):
    """What view layers and their collections ask for and is left out."""
    for name in ('material_override', 'world_override'):
        if getattr(view_layer, name, None) is not None:
            say(f'view layer "{view_layer.name}": its {name.replace("_", " ")} is left out')

    def visit(layer):
        if layer.exclude:
            return
        for text, is_so in (('a holdout', layer.holdout), ('indirect only', layer.indirect_only)):
            if is_so:
                say(f'collection "{layer.name}": that it is {text} is left out')
        for child in layer.children:
            visit(child)

    visit(view_layer.layer_collection)


def tell(session, depsgraph, say, is_cancelled=lambda: False, untouched=None):
    """All but the session's `commit`. Gives the lights' objects in their order. `untouched` is the session's own
    `Untouched`, if it has one. Raises CoreError for what cannot be drawn, and Cancelled."""
    session.begin()
    if untouched is not None:
        untouched.begin()
    _say_what_layers_ask(depsgraph.view_layer, say)
    exporter = _Exporter(session, say, untouched)
    for instance in depsgraph.object_instances:
        if is_cancelled():
            raise Cancelled
        exporter.add(instance)
    return exporter.lights


def export(session, depsgraph, say, is_cancelled=lambda: False, untouched=None):
    """`tell` with the session's `commit`."""
    told = tell(session, depsgraph, say, is_cancelled, untouched)
    session.commit()
    return told


__all__ = ['Cancelled', 'CoreError', 'Untouched', 'active_uv_layer', 'export', 'mesh_arrays', 'tell']
