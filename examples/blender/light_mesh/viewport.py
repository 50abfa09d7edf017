# SPDX-License-Identifier: MIT
"""Rendered 3-D views: coarse first, then finer; each edit starts anew."""

import threading
import weakref

import gpu
import numpy as np
from gpu_extras.presets import draw_texture_2d

from . import camera, core
from .export import Untouched, tell
from .materials import world_colour

# How many pixels wide and high a square of one colour is, step by step.
COARSENESS = (8, 4, 2, 1)
# How long drawing waits for the core, seconds: below what an eye notices.
PATIENCE = .02

open_viewports = weakref.WeakSet()


class _Commit(threading.Thread):
    """Makes what was told the session's scene, which nobody else may use meanwhile: seconds, where much is new."""

    def __init__(self, session):
        super().__init__()
        self._session = session
        self.problem = ''

    def run(self):
        try:
            self._session.commit()
        except core.CoreError as error:
            self.problem = str(error)


class Viewport:
    """What a 3-D view shows. Blender's engine of that view has it, and closes it when it goes."""

    def __init__(self, memory_budget):
        self._session = core.Session(memory_budget)
        self._untouched = Untouched()
        self._is_told = True  # whether the session knows the last edit
        self._commit = None
        self._seen = None
        self._texture = None
        self._pixels = None
        self._step = 0
        self.problem = ''
        self.is_finished = False
        open_viewports.add(self)

    def __del__(self):
        self.close()

    def close(self):
        if self._session is not None:
            if self._commit is not None:
                self._commit.join()
            self._session.close()
            self._session = None

    def update(self, depsgraph, say):
        """After an edit, which waits for its turn if one before it is not done with."""
        if self._session is None:
            return
        self._untouched.note(depsgraph)
        self._is_told = self.is_finished = False
        self._is_ready(depsgraph, say)

    def _is_ready(self, depsgraph, say):
        """Whether the session's scene is that of the last edit. Goes on with it, and waits no longer than for pictures."""
        for _ in range(2):
            if self._commit is not None:
                self._commit.join(PATIENCE)
                if self._commit.is_alive():
                    return False
                self.problem = self._commit.problem
                self._commit = None
            if not self._is_told:
                self._tell(depsgraph, say)
        return self._commit is None

    def _tell(self, depsgraph, say):
        self._is_told = True
        self._seen = None
        self.problem = ''
        budget = depsgraph.scene.light_mesh.memory_budget
        try:
            if self._session.memory_budget != budget:
                self._session.close()
                self._session = core.Session(budget)
            tell(self._session, depsgraph, say, untouched=self._untouched)
            self._background = world_colour(depsgraph.scene_eval.world, say)
        except core.CoreError as error:
            self.problem = str(error)
            return
        self._commit = _Commit(self._session)
        self._commit.start()

    def draw(self, engine, context, depsgraph, say):
        if self._session is None:
            return
        is_ready = self._is_ready(depsgraph, say)
        if self.problem:
            engine.update_stats('Light Mesh', self.problem)
            return
        region, view = context.region, context.region_data
        seen = region.width, region.height, tuple(map(tuple, view.window_matrix)), tuple(map(tuple, view.view_matrix))
        try:
            if is_ready and seen != self._seen:
                self._seen, self._step, self.is_finished = seen, 0, False
                self._start(context, depsgraph)
            if is_ready and not self.is_finished:
                self._go_on(context, depsgraph)
        except core.CoreError as error:
            self.problem = str(error)
            return
        if self._texture is not None:
            gpu.state.blend_set('ALPHA_PREMULT')
            engine.bind_display_space_shader(depsgraph.scene_eval)
            draw_texture_2d(self._texture, (0, 0), region.width, region.height)
            engine.unbind_display_space_shader()
            gpu.state.blend_set('NONE')
        engine.update_stats('Light Mesh', 'Reading the scene' if not is_ready else
                            '' if self.is_finished else f'step {self._step + 1} of {self._steps}')
        if not self.is_finished:
            engine.tag_redraw()

    def _start(self, context, depsgraph):
        """The picture of this step. The last one has more samples."""
        settings = depsgraph.scene_eval.light_mesh
        region, region_view = context.region, context.region_data
        self._steps = len(COARSENESS) + (settings.viewport_samples > 1)
        coarse = COARSENESS[min(self._step, len(COARSENESS) - 1)]
        width, height = region.width, region.height
        view = camera.view(region_view.window_matrix, region_view.view_matrix.inverted(), width, height,
                           (0, 0, width, height))
        view.width, view.height = max(width // coarse, 1), max(height // coarse, 1)
        view.samples = settings.viewport_samples if self._step == len(COARSENESS) else 1
        view.bounces = settings.bounces
        view.background = view.ambient = core.Float3(*self._background)
        if settings.ambient == 'OCCLUSION' and any(self._background):
            view.ambient_rays = settings.ambient_rays
        view.ambient_distance = settings.ambient_distance
        self._size = view.width, view.height
        self._pixels = np.zeros(4 * view.width * view.height, np.float32)
        self._session.render(view)

    def _go_on(self, context, depsgraph):
        state, _ = self._session.poll(PATIENCE)
        if state != core.FINISHED:
            return
        self._session.read(self._pixels)
        self._texture = gpu.types.GPUTexture(self._size, format='RGBA16F',
                                             data=gpu.types.Buffer('FLOAT', len(self._pixels), self._pixels))
        self._step += 1
        if self._step < self._steps:
            self._start(context, depsgraph)
        else:
            self.is_finished = True


def close_all():
    for viewport in list(open_viewports):
        viewport.close()
