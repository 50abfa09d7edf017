# SPDX-License-Identifier: MIT
"""Blender's materials and worlds, as far as the renderer carries them."""

import os
import time

import bpy
import numpy as np

from . import core

# Names of colour spaces whose values are light, or no colours.
LINEAR = 'Non-Color', 'Raw', 'Linear', 'Linear Rec.709'
# When the add-on was loaded: Blender may have older contents of files that were written since.
_started = time.time()


def _socket(node, *names):
    """The first input of these names, which differ between versions."""
    for name in names:
        found = node.inputs.get(name)
        if found is not None:
            return found
    return None


def _source(socket):
    """The node that feeds an input, through reroutes; None."""
    while socket is not None and socket.is_linked:
        node = socket.links[0].from_node
        if node.type != 'REROUTE':
            return node
        socket = node.inputs[0]
    return None


def _output(tree):
    return tree.get_output_node('CYCLES') or tree.get_output_node('ALL')


def _image_state(image):
    """What tells the pixels of an image that nobody has changed, without reading them; None where nothing does: it was
    painted and not saved, it moves, or its file was written while Blender ran, which may show what was there before."""
    if image.is_dirty or image.source not in ('FILE', 'GENERATED'):
        return None
    state = image.source, image.alpha_mode, image.colorspace_settings.name, image.use_half_precision
    if image.packed_file is not None:  # its size stays the same when a pixel is painted
        return *state, core.hash_of(np.frombuffer(image.packed_file.data, np.uint8))
    if image.source == 'GENERATED':
        return *state, image.generated_type, tuple(image.generated_color), image.use_generated_float
    path = bpy.path.abspath(image.filepath_raw, library=image.library)
    try:
        file = os.stat(path)
    except OSError:
        return None
    if max(file.st_mtime, file.st_ctime) > _started:
        return None
    return *state, path, file.st_mtime_ns, file.st_size


def _pixels(image):
    """Rows from the bottom up."""
    width, height = image.size
    pixels = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(pixels)
    return pixels.reshape(height, width, image.channels)


def _as_bytes(pixels, with_alpha):
    """RGBA."""
    rgba = np.full((*pixels.shape[:2], 4), 255, np.uint8)
    source = pixels if pixels.shape[2] >= 3 else np.repeat(pixels[..., :1], 3, 2)
    count = min(4 if with_alpha else 3, source.shape[2])
    rgba[..., :count] = np.clip(source[..., :count] * 255 + .5, 0, 255)
    return rgba


def left_out_of(node):
    """Names of the inputs of a Principled node, of any version, that ask for what is not drawn."""
    def asks(name, nothing):
        socket = node.inputs.get(name)
        if socket is None:
            return False
        if socket.is_linked or nothing is None:
            return socket.is_linked
        value = socket.default_value
        return (any(channel != nothing for channel in tuple(value)[:3]) if hasattr(value, '__len__') else value > 0)

    return [name for name, nothing in (
        ('Subsurface', 0), ('Subsurface Weight', 0), ('Sheen', 0), ('Sheen Weight', 0), ('Clearcoat', 0),
        ('Coat Weight', 0), ('Anisotropic', 0), ('Specular Tint', 1), ('Transmission Roughness', 0),
        ('Diffuse Roughness', 0), ('Thin Film Thickness', 0), ('Normal', None), ('Clearcoat Normal', None),
        ('Coat Normal', None), ('Tangent', None)) if asks(name, nothing)]


class Materials:
    """Gives each material of a frame its number, and its pictures theirs."""

    def __init__(self, session, say):
        self._session = session
        self._say = say
        self._numbers = {}
        self._images = {}
        self._with_pictures = set()

    def number(self, material):
        key = material.name_full if material else None
        if key not in self._numbers:
            made = self._made(material)
            self._numbers[key] = self._session.add_material(made)
            if made.base_image >= 0:
                self._with_pictures.add(self._numbers[key])
        return self._numbers[key]

    def have_pictures(self, numbers):
        """Whether one of these materials needs texture coordinates."""
        return not self._with_pictures.isdisjoint(numbers)

    def _made(self, material):
        made = core.Material(base=core.Float3(.8, .8, .8), roughness=.5, refraction_index=1.45, alpha=1, base_image=-1,
                             is_matt=1)
        if material is None:
            return made
        if not material.use_nodes or material.node_tree is None:
            made.base = core.Float3(*material.diffuse_color[:3])
            return made
        output = _output(material.node_tree)
        node = _source(output.inputs['Surface']) if output else None
        if node is None:
            made.base = core.Float3(0, 0, 0)
        else:
            self._surface(made, node, material)
            if made.roughness > .1 and not made.is_matt and (made.metallic > .5 or made.transmission > 0):
                self._say(f'material "{material.name}": it is rough, so what it reflects of other things is left out')
        if output:
            for name in ('Volume', 'Displacement'):
                if output.inputs[name].is_linked:
                    self._say(f'material "{material.name}": {name.lower()} is left out')
        return made

    def _surface(self, made, node, material):
        if node.type == 'BSDF_PRINCIPLED':
            self._principled(made, node, material)
        elif node.type == 'BSDF_DIFFUSE':
            self._base(made, node.inputs['Color'], material)
        elif node.type == 'EMISSION':
            made.base = core.Float3(0, 0, 0)
            self._emission(made, node.inputs['Color'], node.inputs['Strength'], material)
        elif node.type == 'BSDF_GLOSSY':
            made.is_matt, made.metallic = 0, 1
            made.roughness = self._value(node.inputs['Roughness'], material)
            self._base(made, node.inputs['Color'], material)
        elif node.type == 'BSDF_GLASS':
            made.is_matt, made.transmission, made.specular = 0, 1, .5
            made.roughness = self._value(node.inputs['Roughness'], material)
            made.refraction_index = self._value(node.inputs['IOR'], material)
            self._base(made, node.inputs['Color'], material)
        elif node.type == 'MIX_SHADER':
            self._mix(made, node, material)
        else:
            self._say(f'material "{material.name}": node "{node.name}" is taken for matt, of the viewport\'s colour')
            made.base = core.Float3(*material.diffuse_color[:3])

    def _mix(self, made, node, material):
        """A surface with holes; of other mixtures the greater part."""
        share = self._value(node.inputs[0], material)
        parts = [_source(node.inputs[1]), _source(node.inputs[2])]
        clear = [part is not None and part.type == 'BSDF_TRANSPARENT' for part in parts]
        if clear[0] != clear[1] and parts[clear.index(False)] is not None:
            self._surface(made, parts[clear.index(False)], material)
            made.alpha *= share if clear[0] else 1 - share
            picture = _source(node.inputs[0])
            if picture is not None and made.base_image >= 0 and picture.type == 'TEX_IMAGE' and clear[0]:
                made.alpha, made.image_alpha = 1, 1
            return
        self._say(f'material "{material.name}": of the mixture "{node.name}" only the greater part is drawn')
        part = parts[1 if share > .5 else 0] or parts[0] or parts[1]
        if part is not None:
            self._surface(made, part, material)

    def _principled(self, made, node, material):
        made.is_matt = 0
        alpha = _socket(node, 'Alpha')
        alpha_from = _source(alpha)
        colour_from = _source(node.inputs['Base Color'])
        made.image_alpha = int(alpha_from is not None and alpha_from.type == 'TEX_IMAGE' and alpha_from == colour_from and
                               alpha.links[0].from_socket.name == 'Alpha')
        made.alpha = 1 if made.image_alpha else self._value(alpha, material)
        self._base(made, node.inputs['Base Color'], material)
        made.roughness = self._value(node.inputs['Roughness'], material)
        made.metallic = self._value(node.inputs['Metallic'], material)
        made.specular = self._value(_socket(node, 'Specular', 'Specular IOR Level'), material)
        made.transmission = self._value(_socket(node, 'Transmission', 'Transmission Weight'), material)
        made.refraction_index = self._value(node.inputs['IOR'], material)
        self._emission(made, _socket(node, 'Emission', 'Emission Color'), node.inputs['Emission Strength'], material)
        if made.alpha < 1 and made.transmission > 0:
            self._say(f'material "{material.name}": what shines through by alpha is bent as by transmission')
        left_out = left_out_of(node)
        if left_out:
            self._say(f'material "{material.name}": {", ".join(left_out)} left out')

    def _emission(self, made, colour, strength, material):
        rgb = np.array(self._colour(colour, material)) * self._value(strength, material)
        made.emission = core.Float3(*rgb)
        if rgb.max() > 0:
            self._say(f'material "{material.name}": it shines, but lights nothing else')

    def _base(self, made, socket, material):
        node = _source(socket)
        if node is None or node.type != 'TEX_IMAGE' or node.image is None:
            made.base = core.Float3(*self._colour(socket, material))
            return
        image = self._image(node, bool(made.image_alpha), material)
        if image is None:
            made.base = core.Float3(1, 0, 1)  # as Cycles draws a picture that is not there
            return
        made.base, made.base_image = core.Float3(1, 1, 1), image

    def _colour(self, socket, material):
        node = _source(socket)
        if node is None:
            return tuple(socket.default_value)[:3]
        if node.type == 'RGB':
            return tuple(node.outputs[0].default_value)[:3]
        self._say(f'material "{material.name}": what is linked to {socket.name} is left out')
        return tuple(socket.default_value)[:3]

    def _value(self, socket, material):
        node = _source(socket)
        if node is None:
            return socket.default_value
        if node.type == 'VALUE':
            return node.outputs[0].default_value
        self._say(f'material "{material.name}": what is linked to {socket.name} is left out')
        return socket.default_value

    def _image(self, node, with_alpha, material):
        image = node.image
        with_alpha = with_alpha and image.alpha_mode != 'NONE'
        clamps = node.extension != 'REPEAT'
        key = image.name_full, with_alpha, clamps
        if key not in self._images:
            self._images[key] = self._copied(node, with_alpha, clamps)
            notes = [text for text, is_so in (
                ('its mapping', node.inputs['Vector'].is_linked and _source(node.inputs['Vector']).type not in
                 ('UVMAP', 'TEX_COORD')),
                ('its mapping', node.inputs['Vector'].is_linked and node.inputs['Vector'].links[0].from_socket.name != 'UV'),
                ('its interpolation', node.interpolation not in ('Linear', 'Smart')),
                ('its projection', node.projection != 'FLAT'),
                ('that it ends at its edges', node.extension not in ('REPEAT', 'EXTEND')),
                ('values above 1', image.is_float),
                ('its colour space', image.colorspace_settings.name not in ('sRGB', *LINEAR)),
                ('its premultiplied alpha', image.alpha_mode == 'PREMUL'),
                ('that it moves', image.source in ('MOVIE', 'SEQUENCE')),
            ) if is_so]
            if notes:
                self._say(f'image "{image.name}": {", ".join(dict.fromkeys(notes))} left out')
        return self._images[key]

    def _copied(self, node, with_alpha, clamps):
        image = node.image
        width, height = image.size
        if width == 0 or height == 0 or image.source == 'TILED':
            self._say(f'image "{image.name}" is not there, or is tiled')
            return None
        flags = core.IMAGE_LINEAR * (image.is_float or image.colorspace_settings.name in LINEAR) + core.IMAGE_CLAMP * clamps
        state = _image_state(image)
        pixels = _pixels(image) if state is None else None
        told = repr((state, width, height, image.channels, with_alpha, flags)).encode()
        key = core.hash_of(pixels, np.frombuffer(told, np.uint8))
        number = self._session.find_image(key)
        if number is None:
            pixels = _pixels(image) if pixels is None else pixels
            if (not with_alpha and image.alpha_mode == 'STRAIGHT' and image.channels == 4 and not image.is_float and
                    pixels[..., 3].min() < 1):
                self._say(f'image "{image.name}": that its alpha darkens its colours is left out')
            number = self._session.add_image(key, _as_bytes(pixels, with_alpha), flags)
        return number


def world_colour(world, say):
    """Of the background, which is also the ambient light."""
    if world is None:
        return np.zeros(3)
    if not world.use_nodes or world.node_tree is None:
        return np.array(world.color[:])
    output = _output(world.node_tree)
    if output and output.inputs['Volume'].is_linked:
        say(f'world "{world.name}": its volume is left out')
    node = _source(output.inputs['Surface']) if output else None
    if node is None:
        return np.zeros(3)
    if node.type != 'BACKGROUND' or any(_source(socket) is not None for socket in node.inputs):
        say(f'world "{world.name}": only one colour is drawn, not what is linked to node "{node.name}"')
    if node.type != 'BACKGROUND':
        return np.array(world.color[:])
    return np.array(node.inputs['Color'].default_value[:3]) * node.inputs['Strength'].default_value
