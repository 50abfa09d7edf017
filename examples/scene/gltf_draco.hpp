// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <vector>

namespace demo {

/// A mesh as KHR_draco_mesh_compression has it.
struct DracoMesh {
    struct Attribute {
        int components;
        std::vector<float> values;
    };
    std::vector<std::uint32_t> indices;
    std::map<int, Attribute> attributes;  ///< by their unique number
};

/// Throws std::runtime_error that says what is wrong.
DracoMesh decode_draco(std::span<const std::uint8_t> compressed);

}  // namespace demo
