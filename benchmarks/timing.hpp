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

/// The time of a cold row includes making the mesh.
Timing time_pass(const Row& row);

}  // namespace bench
