#version 450
// The vertex shader of vulkan_depth_renderer.hpp, which holds it compiled:
//     glslc -O --target-env=vulkan1.1 -mfmt=num -o - depth.vert
layout(push_constant) uniform View {
    mat4 clip_from_eye;
    vec3 eye;
};
layout(location = 0) in vec3 position;

void main() { gl_Position = clip_from_eye * vec4(position - eye, 1.0); }
