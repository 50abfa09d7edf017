// SPDX-License-Identifier: MIT

// A list of segments and what is found of them.

layout(push_constant) uniform Batch {
    uint first;
    uint count;
}
batch;

// Two words of four each: the ends.
layout(std430, set = 1, binding = 0) readonly buffer Segments {
    vec4 segments[];
};
layout(std430, set = 1, binding = 1) writeonly buffer Answers {
    uvec4 answers[];
};

layout(local_size_x = 64) in;
