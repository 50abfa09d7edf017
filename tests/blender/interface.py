# SPDX-License-Identifier: MIT
"""Draws 3-D views and panels, renders pictures and films by their keys, and ends them by Escape. Needs a screen, such as
Xvfb's.

    blender --factory-startup --addons light_mesh --python interface.py [-- PICTURE.png]
"""

import ctypes
import os
import shutil
import sys
import tempfile
import threading
import time
import traceback

import bpy
import mathutils
import numpy as np

WANTED = sys.argv[sys.argv.index('--') + 1] if '--' in sys.argv else None


def area_of(kind):
    return next(area for area in bpy.context.window_manager.windows[0].screen.areas if area.type == kind)


def shown(tab):
    """A picture of the window with this tab of properties."""
    area = area_of('PROPERTIES')
    area.spaces[0].context = tab
    area.tag_redraw()
    yield .3
    return (yield from photographed(area, WANTED if tab == 'DATA' else None))


def photographed(area, copy=None):
    window = bpy.context.window_manager.windows[0]
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, 'screen.png')
        with bpy.context.temp_override(window=window, area=area):
            bpy.ops.screen.screenshot_area(filepath=path)
        image = bpy.data.images.load(path)
        width, height = image.size
        pixels = np.empty(width * height * 4, np.float32)
        image.pixels.foreach_get(pixels)
        bpy.data.images.remove(image)
        if copy and not os.path.exists(copy):
            shutil.move(path, copy)
    yield 0
    return pixels.reshape(height, width, 4)[..., :3]


def drawn(area):
    """A picture of a 3-D view when it is finished."""
    from light_mesh import viewport
    area.tag_redraw()
    yield .3
    for _ in range(200):
        if viewport.open_viewports and all(each.is_finished for each in viewport.open_viewports):
            break
        yield .1
    assert [each.problem for each in viewport.open_viewports] == [''], 'a view has a problem, or none is open'
    assert all(each.is_finished for each in viewport.open_viewports)
    area.tag_redraw()
    yield .2
    return (yield from photographed(area))


def slow_commits(area, cube):
    """While the core makes a scene, which takes long, the interface goes on, and edits wait for their turn."""
    from light_mesh import core, viewport
    before = yield from photographed(area)
    commit = core.Session.commit
    may_go_on, begun = threading.Event(), []

    def waits(session):
        begun.append(session)
        if not may_go_on.wait(60):
            raise core.CoreError('the interface waited for the core')
        commit(session)

    core.Session.commit = waits
    for x in (-.5, -1, -2):
        cube.location.x = x
        area.tag_redraw()
        yield .3
    assert len(begun) == 1, begun
    assert not any(each.is_finished for each in viewport.open_viewports)
    may_go_on.set()
    after = yield from drawn(area)
    assert len(begun) >= 2, begun
    core.Session.commit = commit
    cube.location.x = 3
    yield from drawn(area)
    cube.location.x = -2
    again = yield from drawn(area)
    assert np.array_equal(after, again) and not np.array_equal(after, before)


def viewport_steps():
    """Edits while a view is being rendered, as fast as they come; none may end Blender, and each must be seen."""
    import addon_utils
    from light_mesh import core, export
    area = area_of('VIEW_3D')
    render, begun = core.Session.render, []
    core.Session.render = lambda session, view: begun.append((view.width, view.samples)) or render(session, view)
    reads = []
    read_arrays = export.mesh_arrays
    export.mesh_arrays = lambda *mesh: reads.append(mesh[0].name) or read_arrays(*mesh)
    space = area.spaces[0]
    space.overlay.show_overlays = space.show_gizmo = False
    space.shading.type = 'RENDERED'
    pictures = [(yield from drawn(area))]
    cube = bpy.data.objects['Cube']
    width = next(region for region in area.regions if region.type == 'WINDOW').width
    finer = [(width // coarse, 1) for coarse in (8, 4, 2, 1)] + [(width, bpy.context.scene.light_mesh.viewport_samples)]

    def check_coarse_first():
        """Somewhere: also what a test itself loads begins a view anew."""
        assert any(begun[first:first + len(finer)] == finer for first in range(len(begun))), begun
        begun.clear()

    check_coarse_first()

    def seen_to_change(what):
        picture = yield from drawn(area)
        assert not np.array_equal(picture, pictures[-1]), f'the view does not show: {what}'
        check_coarse_first()
        pictures.append(picture)

    cube.location.x = 1
    yield from seen_to_change('a cube that moved')
    space.region_3d.view_rotation.rotate(mathutils.Euler((0, 0, .3)))
    yield from seen_to_change('a view that turned')
    bpy.data.objects['Light'].data.energy = 300
    yield from seen_to_change('a lamp with less power')
    assert reads == ['Cube'], f'meshes that nobody edited are read again: {reads}'
    cube.data.vertices[0].co.z -= 1
    cube.data.update()
    yield from seen_to_change('a corner of the mesh that moved')
    assert reads == 2 * ['Cube'], reads
    array = cube.modifiers.new('Array', 'ARRAY')
    yield from seen_to_change('a modifier')
    array.count = 3
    yield from seen_to_change('a modifier that was set')
    cube.modifiers.remove(array)
    yield from seen_to_change('a modifier that is gone')
    cube.shape_key_add(name='Basis')
    cube.shape_key_add(name='Tall').data[1].co.z += 2
    cube.data.shape_keys.key_blocks['Tall'].value = 1
    yield from seen_to_change('a shape key')
    cube.data.polygons[0].use_smooth = True
    cube.data.update()
    yield from seen_to_change('a smooth polygon')
    export.mesh_arrays = read_arrays
    for i in range(20):
        cube.location.x = .05 * i
        yield .02
    yield from drawn(area)
    yield from slow_commits(area, cube)
    window = bpy.context.window_manager.windows[0]
    region = next(region for region in area.regions if region.type == 'WINDOW')
    with bpy.context.temp_override(window=window, area=area, region=region):
        bpy.ops.ed.undo_push(message='before')
        bpy.data.objects.remove(bpy.data.objects['Cube'])
        bpy.ops.ed.undo_push(message='after')
    yield from seen_to_change('a cube that is gone')
    with bpy.context.temp_override(window=window, area=area, region=region):
        bpy.ops.ed.undo()
    yield from seen_to_change('a cube that is back')
    core.Session.render = render
    addon_utils.disable('light_mesh')
    yield .3
    addon_utils.enable('light_mesh')
    bpy.context.scene.render.engine = 'LIGHT_MESH'
    area.spaces[0].shading.type = 'SOLID'
    yield .2
    area.spaces[0].shading.type = 'RENDERED'
    yield .5
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, 'scene.blend')
        bpy.ops.wm.save_as_mainfile(filepath=path)
        bpy.ops.wm.open_mainfile(filepath=path)
    yield .5
    area_of('VIEW_3D').spaces[0].shading.type = 'SOLID'
    yield .2


def baking_steps():
    """The panel of baking with each of its targets; and a bake that lets the interface go on."""
    from light_mesh import panels
    panel = panels.LIGHT_MESH_PT_bake
    draw, drawn_with = panel.draw, []
    settings = bpy.context.scene.light_mesh.bake

    def noticed(self, context):
        draw(self, context)
        drawn_with.append((settings.target, settings.image is None))

    panel.draw = noticed
    bpy.utils.unregister_class(panel)
    panel.bl_options = set()  # not closed, in a part of the window that has not drawn it yet
    bpy.utils.register_class(panel)
    for target in ('ATTRIBUTE', 'IMAGE'):
        settings.target = target
        yield from shown('RENDER')
    settings.width = settings.height = 128
    cube = bpy.context.scene.objects['Cube']
    cube.select_set(True)
    window = bpy.context.window_manager.windows[0]
    with bpy.context.temp_override(window=window, area=area_of('PROPERTIES')):
        assert bpy.ops.object.light_mesh_bake('INVOKE_DEFAULT') == {'RUNNING_MODAL'}
    for _ in range(100):
        yield .05
        if settings.image is not None:
            break
    pixels = np.empty(4 * 128 ** 2, np.float32)
    settings.image.pixels.foreach_get(pixels)
    assert .03 < pixels.reshape(-1, 4)[:, :3].mean() < .9, pixels.reshape(-1, 4).mean(axis=0)
    yield from shown('RENDER')
    assert set(drawn_with) == {('ATTRIBUTE', True), ('IMAGE', True), ('IMAGE', False)}, drawn_with
    panel.draw = draw


def steps():
    from light_mesh import engine
    scene = bpy.context.scene
    scene.render.engine = engine.ENGINE
    yield .5
    yield from viewport_steps()
    scene = bpy.context.scene
    lamp = scene.objects['Light']
    lamp.data.light_mesh.shadow = 'MESH_ATK'
    bpy.context.view_layer.objects.active = lamp
    # The greatest area has room for all panels, and wide ones.
    area_of('PROPERTIES').type = 'OUTLINER'
    area_of('VIEW_3D').type = 'PROPERTIES'
    yield .3
    yield from baking_steps()
    pictures = {}
    for tab in ('RENDER', 'DATA', 'WORLD', 'OUTPUT'):
        pictures[tab] = yield from shown(tab)
        assert pictures[tab].std() > .02, f'the tab {tab} is blank'
    assert not np.array_equal(pictures['RENDER'], pictures['DATA'])
    # Another kind of shadow has other settings.
    lamp.data.light_mesh.shadow = 'REAL'
    other = yield from shown('DATA')
    assert not np.array_equal(other, pictures['DATA'])

    yield from rendering_steps(scene)


def press(*names):
    """These keys of the keyboard together, by X's own extension for tests: Blender takes no other Escape for one."""
    x11, test = ctypes.CDLL('libX11.so.6'), ctypes.CDLL('libXtst.so.6')
    x11.XOpenDisplay.restype = ctypes.c_void_p
    x11.XStringToKeysym.restype = ctypes.c_ulong
    display = ctypes.c_void_p(x11.XOpenDisplay(None))
    codes = [x11.XKeysymToKeycode(display, ctypes.c_ulong(x11.XStringToKeysym(name.encode()))) for name in names]
    for code in codes:
        test.XTestFakeKeyEvent(display, code, 1, ctypes.c_ulong(0))
    for code in reversed(codes):
        test.XTestFakeKeyEvent(display, code, 0, ctypes.c_ulong(0))
    x11.XCloseDisplay(display)


def rendered(seconds=20):
    """When the picture or the film has ended that was asked for; how long it took, seconds."""
    start = time.perf_counter()
    while not bpy.app.is_job_running('RENDER'):
        assert time.perf_counter() < start + 5, 'it has not begun'
        yield .02
    while bpy.app.is_job_running('RENDER'):
        assert time.perf_counter() < start + seconds, 'it goes on'
        yield .05
    return time.perf_counter() - start


def rendering_steps(scene):
    """F12 and Ctrl-F12 by the keyboard, and Escape in a picture and in a film of hours."""
    from light_mesh import engine
    render = scene.render
    render.resolution_x, render.resolution_y = 160, 90
    cube = scene.objects['Cube']
    for frame, x in ((1, -1), (3, 1)):
        cube.location.x = x
        cube.keyframe_insert('location', frame=frame)
    with tempfile.TemporaryDirectory() as folder:
        render.filepath = os.path.join(folder, 'frame-')
        scene.frame_start, scene.frame_end = 1, 3
        frames = []
        scene.frame_set(1)
        handlers = bpy.app.handlers.render_write
        handlers.append(lambda *_: frames.append(engine.statistics['is_new_scene']))
        press('F12')
        yield from rendered()
        assert engine.statistics['triangles'] == 12, engine.statistics
        assert not frames, 'a picture is written by a film only'
        engine.forget()
        press('Control_L', 'F12')
        yield from rendered()
        assert frames == [1, 0, 0], frames
        assert sorted(os.listdir(folder)) == [f'frame-000{i}.png' for i in (1, 2, 3)], os.listdir(folder)
        pictures = []
        for name in sorted(os.listdir(folder)):
            image = bpy.data.images.load(os.path.join(folder, name))
            assert tuple(image.size) == (160, 90)
            pictures.append(np.array(image.pixels[:]))
            bpy.data.images.remove(image)
            os.remove(os.path.join(folder, name))
        assert all(picture.std() > .01 for picture in pictures)
        assert not np.array_equal(pictures[0], pictures[1])

        # Pictures of hours. A 3-D view beside them is open at the end.
        render.resolution_x = render.resolution_y = 1200
        scene.light_mesh.samples = 1024
        area_of('PROPERTIES').type = 'VIEW_3D'
        area_of('VIEW_3D').spaces[0].shading.type = 'RENDERED'
        for keys in (('F12',), ('Control_L', 'F12')):
            press(*keys)
            yield 1.5
            assert bpy.app.is_job_running('RENDER')
            press('Escape')
            took = yield from rendered(10)
            print(f'interface: Escape ended what was begun by {" and ".join(keys)} after {took:.2f} s', flush=True)
            assert os.listdir(folder) == [], 'a frame that was cancelled is written'
        handlers.clear()

        # One to the end: Blender's exit status is 1 where Escape ended the last one.
        render.resolution_x, render.resolution_y = 160, 90
        scene.light_mesh.samples = 1
        press('F12')
        yield from rendered()
        assert engine.statistics['triangles'] == 12, engine.statistics


def run():
    bpy.context.preferences.view.show_splash = False
    work = steps()

    def step():
        try:
            return next(work)
        except StopIteration:
            print('interface: passed', flush=True)
            bpy.ops.wm.quit_blender()  # which must not fail either
        except BaseException:
            traceback.print_exc()
            sys.stdout.flush()
            os._exit(1)

    bpy.app.timers.register(step, first_interval=1, persistent=True)


run()
