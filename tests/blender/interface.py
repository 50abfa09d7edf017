# SPDX-License-Identifier: MIT
"""Draws the panels, renders with F12's operator, and cancels a picture by its own job. Needs a screen, such as Xvfb's.

    blender --factory-startup --addons light_mesh --python interface.py [-- PICTURE.png]
"""

import os
import sys
import tempfile
import traceback

import bpy
import numpy as np

WANTED = sys.argv[sys.argv.index('--') + 1] if '--' in sys.argv else None


def area_of(kind):
    return next(area for area in bpy.context.window_manager.windows[0].screen.areas if area.type == kind)


def shown(tab):
    """A picture of the window with this tab of properties."""
    window = bpy.context.window_manager.windows[0]
    area = area_of('PROPERTIES')
    area.spaces[0].context = tab
    area.tag_redraw()
    yield .3
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, 'screen.png')
        with bpy.context.temp_override(window=window, area=area):
            bpy.ops.screen.screenshot_area(filepath=path)
        image = bpy.data.images.load(path)
        width, height = image.size
        pixels = np.empty(width * height * 4, np.float32)
        image.pixels.foreach_get(pixels)
        bpy.data.images.remove(image)
        if WANTED and tab == 'DATA' and not os.path.exists(WANTED):
            os.replace(path, WANTED)
    return pixels.reshape(height, width, 4)[..., :3]


def steps():
    from light_mesh import core, engine
    scene = bpy.context.scene
    scene.render.engine = engine.ENGINE
    lamp = scene.objects['Light']
    lamp.data.light_mesh.shadow = 'MESH_ATK'
    bpy.context.view_layer.objects.active = lamp
    yield .5
    # The greatest area has room for all panels, and wide ones.
    area_of('PROPERTIES').type = 'OUTLINER'
    area_of('VIEW_3D').type = 'PROPERTIES'
    yield .3
    pictures = {}
    for tab in ('RENDER', 'DATA', 'WORLD', 'OUTPUT'):
        pictures[tab] = yield from shown(tab)
        assert pictures[tab].std() > .02, f'the tab {tab} is blank'
    assert not np.array_equal(pictures['RENDER'], pictures['DATA'])
    # Another kind of shadow has other settings.
    lamp.data.light_mesh.shadow = 'REAL'
    other = yield from shown('DATA')
    assert not np.array_equal(other, pictures['DATA'])

    scene.render.resolution_x, scene.render.resolution_y = 160, 90
    bpy.ops.render.render('INVOKE_DEFAULT')
    for _ in range(100):
        yield .1
        if engine.statistics and not bpy.app.is_job_running('RENDER'):
            break
    assert engine.statistics['triangles'] == 12, engine.statistics

    # A picture of hours, until its session is told to stop.
    scene.render.resolution_x = scene.render.resolution_y = 4000
    scene.light_mesh.samples = 1024
    bpy.ops.render.render('INVOKE_DEFAULT')
    yield 1.5
    assert bpy.app.is_job_running('RENDER')
    for session in list(engine._sessions.values()):
        session.cancel()
    for _ in range(100):
        yield .1
        if not bpy.app.is_job_running('RENDER'):
            break
    assert not bpy.app.is_job_running('RENDER')
    assert core.ABI == 1


def run():
    bpy.context.preferences.view.show_splash = False
    work = steps()

    def step():
        try:
            return next(work)
        except StopIteration:
            print('interface: passed', flush=True)
            code = 0
        except BaseException:
            traceback.print_exc()
            code = 1
        sys.stdout.flush()
        os._exit(code)

    bpy.app.timers.register(step, first_interval=1)


run()
