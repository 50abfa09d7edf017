// SPDX-License-Identifier: MIT
// must say: lightmesh: the Occluders lack the member `std::size_t triangle_count() const`
#include "wrong.hpp"

struct Wrong {
    std::array<glm::vec3, 3> triangle(std::size_t) const { return {}; }
};

const lightmesh::ShadowVolumes volumes{Wrong{}, lights[0]};
