// SPDX-License-Identifier: MIT
#pragma once

#include "contestant.hpp"

#include <cstddef>
#include <string>

namespace bench {

enum class Algorithm { hard, area, pcf, exact, linked, express };

/// What one row measures.
struct Row {
    std::string scene = {};
    Algorithm algorithm = Algorithm::hard;
    std::size_t lights = 64;
    std::size_t most_points = 0;  ///< 0: all of the picture
    int repetitions = 3;

    std::string form = {};  ///< of hard and area

    // Of light meshes only.
    float quality = 4.0f;
    bool cold = false;  ///< starts with an empty mesh, which is made within the time
    Query query = Query::tile;
    int threads = 1;

    bool is_mesh() const { return algorithm >= Algorithm::exact; }

    /// scene/algorithm/form/lights:N, for a mesh scene/algorithm/warm|cold/point|tile/lights:N/q:Q/threads:T.
    std::string name() const;
};

/// A contestant as the row times it: an empty mesh for a cold row, else one with all in place that it caches.
/// Those of warm rows are shared by rows.
std::shared_ptr<const Contestant> contestant(const Row& row);

/// The same row with everything cached, on one thread: gives the values of a cold row, too.
Row warm(Row row);

}  // namespace bench
