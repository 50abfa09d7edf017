#version 450
// SPDX-License-Identifier: MIT

// A batch's colours as the picture has them: by the exposure, and beside that by the tone curve.

#extension GL_GOOGLE_include_directive : require
#include "scene.glsl"
#include "paths.glsl"

layout(local_size_x = 64) in;

// Of `count` pixels the linear values, then the toned ones.
layout(std430, set = 0, binding = 11) writeonly buffer Finished {
    vec4 finished[];
};

// `toned` of image.cpp.
vec3 filmic(vec3 linear) {
    vec3 x = 0.6 * clamp(linear, 0.0, 1e4);
    return min(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 1.0);
}

void main() {
    uint pixel = gl_GlobalInvocationID.x;
    if (pixel >= batch.count)
        return;
    vec3 linear = frame.output_curve.x * colours[pixel].rgb;
    finished[pixel] = vec4(linear, 1.0);
    finished[batch.count + pixel] = vec4(frame.output_curve.y != 0.0 ? filmic(linear) : linear, 1.0);
}
