// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>

namespace lightmesh {

/// An axis-aligned box in world units, its faces included.
struct Bounds {
    glm::vec3 low{0.0f};   ///< least coordinates
    glm::vec3 high{0.0f};  ///< greatest coordinates
};

}  // namespace lightmesh
