// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/lights.hpp>

#include <algorithm>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

namespace lightmesh::detail {

/// The stand-in for a light that was removed.
inline Light no_light() {
    return PointLight{.range = 0.0f};
}

/// The numbers of removed lights, which new ones may have.
class FreeSlots {
public:
    bool is_empty() const { return free_.empty(); }
    std::size_t lowest() const { return free_.front(); }

    /// Throws std::out_of_range for one that is free already.
    void add(std::size_t light) {
        const auto at = std::ranges::lower_bound(free_, light);
        if (at != free_.end() && *at == light)
            throw std::out_of_range("lightmesh: light " + std::to_string(light) + " was removed before");
        free_.insert(at, light);
    }
    /// It has a light again, or still.
    void take(std::size_t light) { std::erase(free_, light); }

private:
    std::vector<std::size_t> free_;  ///< in order
};

}  // namespace lightmesh::detail
