# SPDX-License-Identifier: MIT
"""The render engine: final pictures, films, and previews of materials."""

import time

import bpy
import numpy as np

from . import camera, core, viewport
from .export import Cancelled, export
from .materials import world_colour

ENGINE = 'LIGHT_MESH'

# By scene and view layer: films keep what was found. Blender makes an engine for each frame.
_sessions = {}
_said = set()
# Of the last picture, for the panel: never changed, but replaced, since pictures have threads of their own.
statistics = {}


def _session_of(depsgraph):
    key = depsgraph.scene.name_full, depsgraph.view_layer.name
    budget = depsgraph.scene.light_mesh.memory_budget
    if key in _sessions and _sessions[key].memory_budget != budget:
        _sessions.pop(key).close()
    if key not in _sessions:
        _sessions[key] = core.Session(budget)
    return _sessions[key]


@bpy.app.handlers.persistent
def forget(*_):
    """All sessions, and what was said."""
    global statistics
    for session in _sessions.values():
        session.close()
    _sessions.clear()
    _said.clear()
    statistics = {}


def _put(render_pass, pixels):
    try:
        render_pass.rect.foreach_set(pixels)
    except TypeError:  # later versions want one dimension
        render_pass.rect.foreach_set(pixels.ravel())


class LightMeshEngine(bpy.types.RenderEngine):
    bl_idname = ENGINE
    bl_label = 'Light Mesh'
    bl_use_preview = True
    bl_use_eevee_viewport = True
    bl_use_shading_nodes_custom = False

    def _say(self, text):
        """Once, until another file is loaded."""
        if text not in _said and not self.is_preview:
            _said.add(text)
            self.report({'WARNING'}, f'Light Mesh: {text}')

    def update_render_passes(self, scene, renderlayer):
        self.register_pass(scene, renderlayer, 'Combined', 4, 'RGBA', 'COLOR')

    def render(self, depsgraph):
        session = None
        try:
            session = core.Session() if self.is_preview else _session_of(depsgraph)
            self._draw(session, depsgraph)
        except Cancelled:
            pass
        except core.CoreError as error:
            self.report({'ERROR'}, f'Light Mesh: {error}')
            self.error_set(f'Light Mesh: {error}')
        finally:
            if self.is_preview and session is not None:
                session.close()

    def view_update(self, context, depsgraph):
        if getattr(self, 'viewport', None) is None:
            self.viewport = viewport.Viewport(depsgraph.scene.light_mesh.memory_budget)
        self.viewport.update(depsgraph, self._say)

    def view_draw(self, context, depsgraph):
        if getattr(self, 'viewport', None) is not None:
            self.viewport.draw(self, context, depsgraph, self._say)

    def _view(self, depsgraph):
        """The picture without its colours."""
        scene, render = depsgraph.scene_eval, depsgraph.scene_eval.render
        eye = scene.camera
        if eye is None:
            raise core.CoreError('the scene has no camera')
        if eye.type != 'CAMERA':
            raise core.CoreError(f'the camera "{eye.name}" is a {eye.type.lower()}')
        if eye.data.type == 'PANO':
            raise core.CoreError('panoramic cameras are not supported')
        for text, is_so in (('depth of field', eye.data.dof.use_dof), ('motion blur', render.use_motion_blur),
                            ('stereoscopy', render.use_multiview), ('freestyle', render.use_freestyle)):
            if is_so:
                self._say(f'{text} is left out')
        width, height = self.resolution_x, self.resolution_y
        part = camera.border(render, width, height)
        if part[2] < 1 or part[3] < 1:
            raise core.CoreError(f'the border leaves a picture of {part[2]} x {part[3]} pixels')
        projection = eye.calc_matrix_camera(depsgraph, x=width, y=height, scale_x=render.pixel_aspect_x,
                                            scale_y=render.pixel_aspect_y)
        return camera.view(projection, self.camera_model_matrix(eye), width, height, part)

    def _draw(self, session, depsgraph):
        start = time.perf_counter()
        scene = depsgraph.scene_eval
        settings, render = scene.light_mesh, scene.render
        view = self._view(depsgraph)
        self.update_stats('', 'Reading the scene')
        export(session, depsgraph, self._say, self.test_break)
        exported = time.perf_counter()
        colour = core.Float3(*world_colour(scene.world, self._say))
        view.background, view.ambient = colour, colour
        if settings.ambient == 'OCCLUSION' and any(colour):
            view.ambient_rays = 1 if self.is_preview else settings.ambient_rays
        view.ambient_distance = settings.ambient_distance
        view.samples = 1 if self.is_preview else settings.samples
        view.bounces = settings.bounces
        view.is_transparent = render.film_transparent
        view.threads = render.threads if render.threads_mode == 'FIXED' else 0
        pixels = np.zeros((view.width * view.height, 4), np.float32)
        result = self.begin_result(0, 0, view.width, view.height, layer=depsgraph.view_layer.name)
        state = core.CANCELLED
        try:
            session.render(view)
            state = self._wait(session, result, pixels)
        finally:
            session.read(pixels)
            _put(result.layers[0].passes['Combined'], pixels)
            self.end_result(result, cancel=state == core.CANCELLED)
        if not self.is_preview:
            self._keep_statistics(session, exported - start, time.perf_counter() - start)

    def _wait(self, session, result, pixels):
        """Shows what there is, until the picture ends."""
        shown = time.perf_counter()
        while True:
            state, progress = session.poll(.05)
            self.update_progress(progress)
            if state != core.RUNNING:
                return state
            if self.test_break():
                session.cancel()
            elif not bpy.app.background and not self.is_preview and time.perf_counter() - shown > .5:
                session.read(pixels)
                _put(result.layers[0].passes['Combined'], pixels)
                self.update_result(result)
                shown = time.perf_counter()
            self.update_stats('', f'{progress:.0%}')

    def _keep_statistics(self, session, export_seconds, seconds):
        global statistics
        found = session.statistics()
        statistics = {name: getattr(found, name) for name, _ in core.Statistics._fields_} | {
            'seconds_exporting': export_seconds, 'seconds': seconds}


def register():
    bpy.utils.register_class(LightMeshEngine)
    bpy.app.handlers.load_pre.append(forget)


def unregister():
    bpy.app.handlers.load_pre.remove(forget)
    bpy.utils.unregister_class(LightMeshEngine)
    viewport.close_all()
    forget()
