# SPDX-License-Identifier: MIT
"""Times of the add-on inside Blender, against what is to be reached. To be run by blender.sh."""

import math
import os
import sys
import time

import bpy
import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', 'tests', 'blender'))
import shadows  # noqa: E402
from support import SCENE, add, ball, box, camera, lamp, picture, plane, reset  # noqa: E402

from light_mesh import core, engine, export  # noqa: E402


def row(what, measured, to_reach, more_is_better, beside):
    reached = measured >= to_reach if more_is_better else measured <= to_reach
    print(f'| {what} | {measured:.3g} | {">=" if more_is_better else "<="} {to_reach} | {"yes" if reached else "no"} '
          f'| {beside} |', flush=True)


def processor_seconds(work):
    start = time.process_time()
    result = work()
    return time.process_time() - start, result


def waves():
    """A smooth surface of a million triangles."""
    reset()
    camera()
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=708, y_subdivisions=708, size=10)
    mesh = bpy.context.object.data
    places = np.empty((len(mesh.vertices), 3), np.float32)
    mesh.vertices.foreach_get('co', places.ravel())
    places[:, 2] = np.sin(3 * places[:, 0]) * np.cos(2 * places[:, 1])
    mesh.vertices.foreach_set('co', places.ravel())
    mesh.update()
    bpy.ops.object.shade_smooth()
    lamp('POINT', (0, 0, 5), 500, shadow_soft_size=.2)


def exports():
    waves()
    session, untouched = core.Session(), export.Untouched()
    depsgraph = bpy.context.evaluated_depsgraph_get()

    def tell(**how):
        start = time.perf_counter()
        untouched.note(depsgraph)
        export.export(session, depsgraph, print, **how)
        return time.perf_counter() - start

    first = tell(untouched=untouched)
    found = session.statistics()
    beside = f'{found.triangles} triangles; of it the BVH {found.seconds_building:.2f} s'
    row('export of a million triangles, s', first, .6, False, beside)
    # The edits that came before are told with the first export of a view.
    bpy.context.view_layer.update()
    tell(untouched=untouched)
    row('unchanged again, in a 3-D view, s', min(tell(untouched=untouched) for _ in range(3)), .15, False, beside)
    row('unchanged again, in a film, s', min(tell() for _ in range(3)), .15, False, beside)
    session.close()


def resident_megabytes():
    with open('/proc/self/statm') as file:
        return int(file.read().split()[1]) * os.sysconf('SC_PAGE_SIZE') / 2**20


def instances():
    """1,000 linked duplicates of a ball: what they take beyond two of them."""
    reset()
    camera()
    bpy.ops.mesh.primitive_uv_sphere_add(radius=.4, segments=100, ring_count=51)
    first = bpy.context.object
    found = {}
    for count in (2, 1000):
        while len(SCENE.objects) < count + 1:
            i = len(SCENE.objects)
            add(f'Ball {i}', first.data, (i % 32, i // 32, 0), (i, 0, 0))
        depsgraph = bpy.context.evaluated_depsgraph_get()
        before, session, start = resident_megabytes(), core.Session(), time.perf_counter()
        export.export(session, depsgraph, print)
        found[count] = time.perf_counter() - start, resident_megabytes() - before
        triangles = session.statistics().triangles
        session.close()
    row('export of 1,000 instances of 10,000 triangles, s', found[1000][0], .6, False,
        f'{triangles} triangles are drawn; {found[1000][1]:.0f} MB; two of them {found[2][0]:.2f} s, {found[2][1]:.0f} MB')


def lamps(shadow):
    """64 lamps over posts and balls, and a camera that moves."""
    reset()
    engine.forget()
    plane(20)
    for i in range(12):
        box((.3, .3, 1 + .1 * i), (-4 + .7 * i, 2 * math.sin(i), .5 + .05 * i))
        ball(.35, (-4 + .7 * i, 2 + math.cos(i), .35))
    for i in range(64):
        lamp('POINT', (-6 + 1.7 * (i % 8), -6 + 1.7 * (i // 8), 2.5 + .3 * (i * 7 % 5)), 12, shadow=shadow,
             shadow_soft_size=.1)
    eye = camera((0, -9, 5), (1.05, 0, 0))
    eye.keyframe_insert('location', frame=1)
    eye.location = 1.5, -8.5, 5
    eye.keyframe_insert('location', frame=24)
    SCENE.render.resolution_x, SCENE.render.resolution_y = 320, 240
    SCENE.light_mesh.samples = 4


def frame(number):
    SCENE.frame_set(number)
    return processor_seconds(picture)[0]


def errors_of_film():
    """In how many pixels the last frame differs from a new session's; and how far a picture of it is from Cycles, beside
    one by hard rays."""
    last = picture()
    engine.forget()
    differing = (picture() != last).any(axis=-1).sum()
    size = SCENE.render.resolution_x, SCENE.render.resolution_y
    samples = SCENE.light_mesh.samples
    SCENE.render.resolution_x, SCENE.render.resolution_y = 160, 120
    SCENE.light_mesh.samples, SCENE.cycles.samples = 64, 1024
    reference = picture('CYCLES')[..., :3]
    errors = []
    for shadow in ('REAL', 'HARD'):
        for light in bpy.data.lights:
            light.light_mesh.shadow = shadow
        errors.append(np.abs(picture()[..., :3] - reference).mean() / reference.mean())
    SCENE.render.resolution_x, SCENE.render.resolution_y = size
    SCENE.light_mesh.samples = samples
    return (f'{differing} pixels of the last frame differ from a new one\'s; its mean difference from Cycles '
            f'{errors[0]:.2%} of the mean, of hard shadows {errors[1]:.2%}')


def films():
    frames = 24
    lamps('REAL')
    first, *later = [frame(number) for number in range(1, frames + 1)]
    after = sum(later) / len(later)
    beside = (f'320x240, 4 samples, one thread: the first {first:.2f} s, each later one {after:.2f} s; '
              f'{errors_of_film()}')
    row(f'film of {frames} frames, 64 lights: the first frame over later ones', first / after, 4, True, beside)
    lamps('NONE')
    open_frame = min(frame(1) for _ in range(2))
    # Each sample's rays to its lamps are one of 16: what the other samples take without shadows is left out.
    SCENE.light_mesh.samples *= 16
    many_open = frame(2)
    for light in bpy.data.lights:
        light.light_mesh.shadow = 'HARD'
    sixteen = open_frame + frame(3) - many_open
    row(f'film of {frames} frames, 64 lights: 16 hard rays to each lamp over later frames', sixteen / after, 20, True,
        f'{beside}; with 16 rays {sixteen:.1f} s')


def same_error(build, to_reach):
    """Processor time of Cycles, when its error is as large, over that of the add-on."""
    reset()
    engine.forget()
    build()
    SCENE.render.resolution_x, SCENE.render.resolution_y = 160, 120
    SCENE.light_mesh.samples, SCENE.cycles.samples, SCENE.cycles.seed = 64, 4096, 3
    reference = picture('CYCLES')[..., :3]

    def error(pixels):
        return np.abs(pixels[..., :3] - reference).mean()

    own_time, pixels = processor_seconds(picture)
    own = error(pixels)
    SCENE.cycles.seed = 0
    samples = 4
    while True:
        SCENE.cycles.samples = samples
        cycles_time, pixels = processor_seconds(lambda: picture('CYCLES'))
        if error(pixels) <= own or samples == 2048:
            break
        samples *= 2
    row(f'{build.__name__}: Cycles at the same error, over its time', cycles_time / own_time, to_reach, True,
        f'160x120: {own_time:.2f} s, error {own:.5f}; Cycles {cycles_time:.2f} s with {samples} samples')


print('| what | measured | to reach | reached | beside |')
print('|---|--:|--:|---|---|')
exports()
instances()
films()
same_error(shadows.rooms, 50)
same_error(shadows.startup, 50)
