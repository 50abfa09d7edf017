// SPDX-License-Identifier: MIT
#pragma once

#include "row.hpp"

#include <string>

namespace bench {

/// What is known of a row before it is timed, from a sample of the picture's points.
struct Checked {
    std::string problem;  ///< empty if its values are right
    double error =
        0.0;  ///< mean absolute difference to the exact light mesh, over lights that face the point
    double error_rms = 0.0;       ///< root mean square of the same
    double rays_per_point = 0.0;  ///< with everything cached
};

/// Finite, in [0, 1]; other forms of hard shadows equal to `rtcOccluded1` but for grazing rays; light meshes
/// the same to the last bit point by point and for many points, and within `largest_error` of the exact ones.
/// The result is kept for the next repetition.
const Checked& check(const Row& row);

/// Whether a mesh that a cold row has filled gives the same bits as the one that was checked.
bool same_values(const Row& row, const Contestant& filled);

/// Mean absolute error of Linked and Express beyond which something is broken: the paper's "a few percent".
inline constexpr double largest_error = 0.05;
/// Share of hard shadow rays on which two of Embree's kernels may differ.
inline constexpr double largest_mismatch = 1e-3;

}  // namespace bench
