// SPDX-License-Identifier: MIT
#pragma once

#include "row.hpp"

#include <vector>

namespace bench {

/// All rows of a full run. The cross product of everything would take hours: the numbers of lights are swept
/// at q = 4 and the qualities at 64 lights; other forms of rays and the query point by point are for the
/// park; rows that trace rays for each point are timed on parts of the picture, and the slowest rows once or
/// twice.
std::vector<Row> all_rows();

}  // namespace bench
