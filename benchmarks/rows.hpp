// SPDX-License-Identifier: MIT
#pragma once

#include "row.hpp"

#include <vector>

namespace bench {

/// All rows of a full run. The cross product of everything would take hours: the numbers of lights are swept
/// at q = 4 and the qualities at 64 lights; forms of rays and both ways to query are told apart on the park.
/// Rows that trace rays for each point are timed on parts of the picture.
std::vector<Row> all_rows();

}  // namespace bench
