// SPDX-License-Identifier: MIT
#pragma once

#include "row.hpp"

#include <memory>

namespace bench {

/// One pass over the points of a row.
struct Timing {
    double seconds;
    std::shared_ptr<const Contestant> contestant;  ///< as the pass left it
};

/// Asks for all points once, tile by tile in the order of the picture. The time of a cold row includes making
/// the mesh. Threads take the next tile each when they are done with the last.
Timing time_pass(const Row& row);

}  // namespace bench
