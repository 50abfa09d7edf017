#version 450
// Without rays.
#extension GL_GOOGLE_include_directive : require
#include "cache_query.glsl"
