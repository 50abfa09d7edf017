// SPDX-License-Identifier: MIT

// The bodies of tinygltf's functions. Buffers and pictures are read by GltfFile.

#include <nlohmann/json.hpp>
#define TINYGLTF_IMPLEMENTATION
#include <tiny_gltf.h>
