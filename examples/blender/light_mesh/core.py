# SPDX-License-Identifier: MIT
"""The functions of light_mesh_core.h, with exceptions for errors."""

import ctypes as c
import os

import numpy as np

ABI = 3
REAL_LAMP, MESH, MESH_ATK, HARD_RAYS, NO_SHADOW = range(5)
POINT, SUN, SPOT, AREA = range(4)
IMAGE_LINEAR, IMAGE_CLAMP = 1, 2
RUNNING, FINISHED, CANCELLED = range(3)

Float3 = c.c_float * 3


class CoreError(RuntimeError):
    """What the core says is wrong."""


class Material(c.Structure):
    _fields_ = [('base', Float3), ('roughness', c.c_float), ('metallic', c.c_float), ('specular', c.c_float),
                ('transmission', c.c_float), ('refraction_index', c.c_float), ('alpha', c.c_float),
                ('emission', Float3), ('base_image', c.c_int32), ('image_alpha', c.c_int32), ('is_matt', c.c_int32)]


class Mesh(c.Structure):
    _fields_ = [('name', c.c_char_p), ('positions', c.c_void_p), ('corners', c.c_void_p), ('slots', c.c_void_p),
                ('normals', c.c_void_p), ('smoothing', c.c_void_p), ('vertex_normals', c.c_void_p), ('uvs', c.c_void_p),
                ('vertex_count', c.c_uint32), ('triangle_count', c.c_uint32)]


class Light(c.Structure):
    _fields_ = [('name', c.c_char_p), ('id', c.c_uint64), ('kind', c.c_int32), ('shadow', c.c_int32), ('position', Float3),
                ('axis', Float3), ('half_u', Float3), ('half_v', Float3), ('strength', Float3), ('cone', c.c_float),
                ('blend', c.c_float), ('size', c.c_float), ('spacing', c.c_float), ('detail', c.c_int32),
                ('radius', c.c_float), ('quality', c.c_float), ('express', c.c_int32), ('map_size', c.c_int32)]


class View(c.Structure):
    _fields_ = [('eye', Float3), ('ahead', Float3), ('up', Float3), ('edges', c.c_float * 4), ('z_near', c.c_float),
                ('z_far', c.c_float), ('is_orthographic', c.c_int32), ('width', c.c_int32), ('height', c.c_int32),
                ('samples', c.c_int32), ('bounces', c.c_int32), ('threads', c.c_int32),
                ('is_transparent', c.c_int32), ('ambient_rays', c.c_int32), ('ambient_distance', c.c_float),
                ('background', Float3), ('ambient', Float3)]


class Points(c.Structure):
    _fields_ = [('positions', c.c_void_p), ('normals', c.c_void_p), ('shading_normals', c.c_void_p),
                ('count', c.c_uint32)]


class Statistics(c.Structure):
    _fields_ = [('seconds_building', c.c_double), ('seconds_rendering', c.c_double),
                ('seconds_visibility', c.c_double), ('points', c.c_int64), ('shadow_rays', c.c_int64),
                ('bytes', c.c_int64), ('light_points', c.c_int64), ('records', c.c_int64), ('kept_rays', c.c_int64),
                ('triangles', c.c_int64), ('stored_triangles', c.c_int64), ('groups', c.c_int32), ('groups_kept', c.c_int32),
                ('is_new_scene', c.c_int32), ('moved_boxes', c.c_int32)]


def _load():
    library = c.CDLL(os.path.join(os.path.dirname(__file__), 'liblight_mesh_core.so'))
    if library.lm_abi() != ABI:
        raise ImportError(f'liblight_mesh_core.so has interface {library.lm_abi()}, and this add-on needs {ABI}: '
                          'install the add-on again, as a whole')
    session, number, block = c.c_void_p, c.c_int32, c.c_void_p
    signatures = {
        'lm_error': (c.c_char_p, []),
        'lm_hash': (c.c_uint64, [c.c_uint64, block, c.c_size_t]),
        'lm_new': (session, [c.c_uint64]),
        'lm_free': (None, [session]),
        'lm_begin': (c.c_int, [session]),
        'lm_find_image': (c.c_int, [session, c.c_uint64]),
        'lm_add_image': (c.c_int, [session, c.c_uint64, number, number, block, number]),
        'lm_add_material': (c.c_int, [session, block]),
        'lm_find_mesh': (c.c_int, [session, c.c_uint64]),
        'lm_add_mesh': (c.c_int, [session, c.c_uint64, block]),
        'lm_add_object': (c.c_int, [session, number, block, block, number]),
        'lm_add_light': (c.c_int, [session, block]),
        'lm_commit': (c.c_int, [session]),
        'lm_render': (c.c_int, [session, block]),
        'lm_poll': (c.c_int, [session, c.c_double, c.POINTER(c.c_float)]),
        'lm_read': (c.c_int, [session, block, c.c_size_t]),
        'lm_cancel': (None, [session]),
        'lm_bake': (c.c_int, [session, block, block, block]),
        'lm_cover_texels': (c.c_int, [number, number, c.c_uint32, block, block, block, block]),
        'lm_fill_margin': (c.c_int, [number, number, number, block, block, number]),
        'lm_statistics': (c.c_int, [session, block]),
    }
    for name, (result, arguments) in signatures.items():
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments
    return library


_library = _load()


def _checked(result):
    if result < 0:
        raise CoreError(_library.lm_error().decode(errors='replace'))
    return result


def _address(array, dtype, columns=None):
    """Of an array that the core may read or write as it lies; None: NULL."""
    if array is None:
        return None
    if array.dtype != dtype or not array.flags.c_contiguous or (columns and array.shape[-1] != columns):
        raise TypeError(f'a contiguous array of {np.dtype(dtype)} with {columns} columns is needed, '
                        f'not {array.dtype} {array.shape}')
    return array.ctypes.data


def hash_of(*arrays):
    """Of the bytes of some arrays; None counts too."""
    value = 1
    for array in arrays:
        if array is None:
            value = _library.lm_hash(value, None, 0)
        else:
            value = _library.lm_hash(value, _address(array, array.dtype), array.nbytes)
    return value


def cover_texels(width, height, uvs):
    """The triangle that each texel shows, the weights of its second and third corner there, and another triangle that
    has the texel's middle too; -1: none."""
    triangles, others = np.empty(width * height, np.int32), np.empty(width * height, np.int32)
    weights = np.empty((width * height, 2), np.float32)
    _checked(_library.lm_cover_texels(width, height, len(uvs), _address(uvs, np.float32, 6),
                                      _address(triangles, np.int32), _address(weights, np.float32),
                                      _address(others, np.int32)))
    return triangles, weights, others


def fill_margin(width, height, values, filled, margin):
    """Goes on with the texels that are filled (1, else 0), so far beyond them. Changes both arrays."""
    _checked(_library.lm_fill_margin(width, height, values.shape[1], _address(values, np.float32),
                                     _address(filled, np.uint8), margin))


class Session:
    """A scene, and what was found of its shadows, of so many bytes for each cache and mesh; 0: no limit. `close` frees
    it."""

    def __init__(self, memory_budget=0):
        self.memory_budget = memory_budget
        self._session = _library.lm_new(memory_budget)
        if not self._session:
            raise CoreError('there is not enough memory for a session')

    def close(self):
        session, self._session = self._session, None
        _library.lm_free(session)

    def begin(self):
        _checked(_library.lm_begin(self._session))

    def find_image(self, key):
        """The number of an image of this frame or the last one; None if there is none with this key."""
        known = _library.lm_find_image(self._session, key)
        return known if known >= 0 else None

    def add_image(self, key, pixels, flags):
        """`pixels` of shape (height, width, 4), rows from the bottom up."""
        height, width = pixels.shape[:2]
        return _checked(_library.lm_add_image(self._session, key, width, height, _address(pixels, np.uint8, 4), flags))

    def add_material(self, material):
        return _checked(_library.lm_add_material(self._session, c.byref(material)))

    def find_mesh(self, key):
        """The number of a mesh of the last frame; None if there is none with this hash."""
        known = _library.lm_find_mesh(self._session, key)
        return known if known >= 0 else None

    def add_mesh(self, key, name, positions, corners, slots, normals, smoothing, vertex_normals, uvs):
        """`key`: the hash of the arrays. One that is known is not told again."""
        known = self.find_mesh(key)
        if known is not None:
            return known
        mesh = Mesh(name.encode(), _address(positions, np.float32, 3), _address(corners, np.int32, 3),
                    _address(slots, np.int32), _address(normals, np.float32, 9), _address(smoothing, np.int32, 3),
                    _address(vertex_normals, np.float32, 3), _address(uvs, np.float32, 6), len(positions), len(corners))
        return _checked(_library.lm_add_mesh(self._session, key, c.byref(mesh)))

    def add_object(self, mesh, matrix, materials):
        # Without arrays of numpy, which take longer to make than to read: a scene may have many instances.
        rows = (c.c_double * 12)(*matrix[0], *matrix[1], *matrix[2])
        numbers = (c.c_int32 * len(materials))(*materials)
        _checked(_library.lm_add_object(self._session, mesh, rows, numbers, len(materials)))

    def add_light(self, light):
        _checked(_library.lm_add_light(self._session, c.byref(light)))

    def commit(self):
        _checked(_library.lm_commit(self._session))

    def render(self, view):
        _checked(_library.lm_render(self._session, c.byref(view)))

    def poll(self, seconds):
        """The state, and the share that is done."""
        progress = c.c_float()
        return _checked(_library.lm_poll(self._session, seconds, c.byref(progress))), progress.value

    def read(self, pixels):
        _checked(_library.lm_read(self._session, _address(pixels, np.float32), pixels.size))

    def cancel(self):
        _library.lm_cancel(self._session)

    def bake(self, positions, normals, shading_normals, light_count, with_colours):
        """The share of each light that is seen from each point, and the light that arrives there, or None."""
        points = Points(_address(positions, np.float32, 3), _address(normals, np.float32, 3),
                        _address(shading_normals, np.float32, 3), len(positions))
        visible = np.zeros((len(positions), light_count), np.float32)
        colours = np.zeros((len(positions), 3), np.float32) if with_colours else None
        _checked(_library.lm_bake(self._session, c.byref(points), _address(visible, np.float32),
                                  _address(colours, np.float32)))
        return visible, colours

    def statistics(self):
        statistics = Statistics()
        _checked(_library.lm_statistics(self._session, c.byref(statistics)))
        return statistics
