#version 450
// SPDX-License-Identifier: MIT
// values[i] = factors[i % 4] * values[i] + added, for gpu_compute_test.cpp.
layout(local_size_x = 64) in;
layout(std430, set = 0, binding = 1) buffer Values { uint values[]; };
layout(std140, set = 1, binding = 0) uniform Factors { uvec4 factors; };
layout(push_constant) uniform Added { uint added; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i < uint(values.length()))
        values[i] = factors[i % 4u] * values[i] + added;
}
