// SPDX-License-Identifier: MIT
#pragma once

#include "contestant.hpp"

#include <cstddef>
#include <vector>

namespace bench {

/// Asks for all points of a picture once, tile by tile in their order. Threads take the next tile each when
/// they are done with the last.
class Pass {
public:
    /// `threads` = 0: all cores.
    Pass(const ShadingPoints& points, std::size_t lights, int threads);

    void run(const Contestant& contestant);

private:
    const ShadingPoints& points_;
    std::size_t lights_;
    std::vector<std::vector<float>> lit_;  ///< a tile's, for each thread
};

}  // namespace bench
