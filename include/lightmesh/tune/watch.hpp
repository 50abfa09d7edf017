// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>

namespace lightmesh::tune::detail {

/// Time since it was made.
class Watch {
public:
    double seconds() const {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    }

private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace lightmesh::tune::detail
