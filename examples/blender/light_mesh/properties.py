# SPDX-License-Identifier: MIT
"""What a user sets, of a scene and of each light."""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

SHADOWS = (
    ('REAL', 'Real Lamp', 'Penumbrae of the lamp\'s own radius, angle or size, by a visibility cache'),
    ('MESH', 'LMM', 'Fast light mesh method: shadows blurred by a radius'),
    ('MESH_ATK', 'LMM + ATK', 'Fast light mesh method that looks into shadow maps instead of tracing rays to the light'),
    ('HARD', 'Hard Rays', 'Sharp shadows, a ray for each point'),
    ('NONE', 'None', 'No shadow'),
)


class LightMeshBakeSettings(bpy.types.PropertyGroup):
    what: EnumProperty(name='What', default='LIGHT', items=(
        ('LIGHT', 'Light', 'What a white surface sends back, with shadows'),
        ('VISIBILITY', 'Visibility', 'Which share of the lights is seen: of the selected ones, else of all'),
        ('EACH', 'Visibility of Each', 'Which share of each light is seen, in an attribute or image of its own: of the '
                                       'selected lights, else of all')))
    target: EnumProperty(name='Into', default='ATTRIBUTE', items=(
        ('ATTRIBUTE', 'Colour Attribute', 'A colour for each vertex of the mesh without its modifiers'),
        ('IMAGE', 'Image', 'A colour for each texel, through the active UV map; the selected objects share it')))
    name: StringProperty(name='Name', description='Of the attribute, or of a new image', default='Soft Shadows')
    image: PointerProperty(type=bpy.types.Image, name='Image', description='None: a new one')
    width: IntProperty(name='Width', description='Of a new image, in texels', default=1024, min=1, soft_max=8192,
                       max=16384, subtype='PIXEL')
    height: IntProperty(name='Height', description='Of a new image, in texels', default=1024, min=1, soft_max=8192,
                        max=16384, subtype='PIXEL')
    is_float: BoolProperty(name='32-bit Float', description='Else 8 bits: up to 1, and a light as sRGB', default=False)
    use_alpha: BoolProperty(name='Alpha', description='Where nothing is baked a new image is transparent', default=True)
    margin: IntProperty(name='Margin', description='How many texels beyond the borders of UV islands go on with them',
                        default=16, min=0, soft_max=64, max=32767, subtype='PIXEL')
    use_clear: BoolProperty(name='Clear Image', description='Else texels beyond the margin stay as they are', default=True)


class LightMeshSceneSettings(bpy.types.PropertyGroup):
    samples: IntProperty(name='Samples', description='Rays through each pixel', default=16, min=1, max=1024)
    viewport_samples: IntProperty(name='Viewport Samples', description='The same, in 3-D views', default=4, min=1, max=1024)
    bounces: IntProperty(name='Bounces', description='Mirrored and refracted rays after each other', default=4, min=0,
                         max=100)
    ambient: EnumProperty(
        name='Ambient Light', description='How the colour of the world lights surfaces',
        items=(('OCCLUSION', 'Occlusion', 'Less where things are near: rays from each point find how much'),
               ('PLAIN', 'Plain', 'Everywhere the same, without rays')), default='OCCLUSION')
    ambient_rays: IntProperty(name='Rays', description='From each point, for ambient occlusion', default=4, min=1, max=1024)
    ambient_distance: FloatProperty(name='Distance', description='Beyond which nothing hides the world', default=1000,
                                    min=1e-3, subtype='DISTANCE', unit='LENGTH')
    memory: IntProperty(name='Memory', description='Megabytes for each cache and mesh; 0: no limit', default=0, min=0)
    bake: PointerProperty(type=LightMeshBakeSettings)

    @property
    def memory_budget(self):
        """In bytes."""
        return self.memory << 20


class LightMeshLightSettings(bpy.types.PropertyGroup):
    shadow: EnumProperty(name='Shadow', description='How the shadow of this light is found', items=SHADOWS,
                         default='REAL')
    express: BoolProperty(name='Express', description='Fastest; light leaks through walls thinner than the radius',
                          default=False)
    quality: FloatProperty(name='Quality', description='Light points to each radius; 3 to 5 are good', default=4, min=1,
                           max=16)
    radius: FloatProperty(name='Radius', description='By which the mesh blurs shadows', default=.5, min=1e-4,
                          soft_max=10, subtype='DISTANCE', unit='LENGTH')
    size: IntProperty(name='Size', description='Texels to a side of the shadow maps', default=1024, min=16, max=8192)
    spacing: FloatProperty(name='Spacing', description='Between the coarsest places that know how visible the lamp is',
                           default=.15, min=1e-4, soft_max=10, subtype='DISTANCE', unit='LENGTH')
    detail: IntProperty(name='Detail', description='How often the spacing is halved along penumbrae', default=3, min=0,
                        max=6)


CLASSES = (LightMeshBakeSettings, LightMeshSceneSettings, LightMeshLightSettings)


def register():
    for each in CLASSES:
        bpy.utils.register_class(each)
    bpy.types.Scene.light_mesh = PointerProperty(type=LightMeshSceneSettings)
    bpy.types.Light.light_mesh = PointerProperty(type=LightMeshLightSettings)


def unregister():
    del bpy.types.Scene.light_mesh, bpy.types.Light.light_mesh
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)
