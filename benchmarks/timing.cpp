// SPDX-License-Identifier: MIT
#include "timing.hpp"

#include "pass.hpp"
#include "render/stopwatch.hpp"
#include "workloads.hpp"

namespace bench {

Timing time_pass(const Row& row) {
    Pass pass(points_of(row.scene, row.most_points), row.lights, row.threads);
    std::shared_ptr<const Contestant> asked = row.cold ? nullptr : contestant(row);

    const demo::Stopwatch watch;
    if (row.cold)
        asked = contestant(row);
    pass.run(*asked);
    return {watch.seconds(), std::move(asked)};
}

}  // namespace bench
