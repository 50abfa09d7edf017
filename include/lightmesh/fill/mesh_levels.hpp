// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/concepts.hpp>
#include <lightmesh/fill/mesh_filler.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/mesh/level.hpp>
#include <lightmesh/mesh/mesh_data.hpp>
#include <lightmesh/settings.hpp>
#include <lightmesh/statistics.hpp>
#include <lightmesh/support/made_once.hpp>

#include <array>
#include <cstddef>
#include <memory>
#include <mutex>
#include <span>
#include <utility>

namespace lightmesh::detail {

/// The levels of a mesh, each a mesh of its own but for lights and adapters, which they share: shadow maps
/// and volumes begin where those of level 0 do. Level 0 is always there, the others are made when a point
/// first asks for them. To its users it is constant, and any number of threads may ask. Must not move.
template <Intersector Tracer, class LongTests>
class MeshLevels {
public:
    using LongTestsType = LongTests;
    using Level = MeshFiller<Tracer, LongTests>;

    /// Throws what `MeshData`, `LevelRule` and the long tests throw.
    template <class... LongTestArguments>
    MeshLevels(Tracer tracer, std::span<const Light> lights, const Settings& settings,
               LongTestArguments&&... long_tests)
        : tracer_(std::move(tracer)), finest_(tracer_, long_tests_, lights, settings), rule_(settings),
          long_tests_(std::forward<LongTestArguments>(long_tests)...) {}
    MeshLevels(const MeshLevels&) = delete;
    MeshLevels& operator=(const MeshLevels&) = delete;

    const Tracer& tracer() const { return tracer_; }
    const LevelRule& rule() const { return rule_; }

    /// Level 0.
    const Level& finest() const { return finest_; }

    /// A level up to `LevelRule::coarsest`, made if it is not there. Throws std::bad_alloc; nothing has
    /// changed then.
    const Level& level(int k) const {
        if (const Level* made = find(k)) [[likely]]
            return *made;
        const std::scoped_lock lock(making_);
        if (const Level* made = find(k))
            return *made;
        const MeshData& known = finest_.data();
        coarser_[static_cast<std::size_t>(k - 1)].publish(std::make_unique<const Level>(
            tracer_, long_tests_, known, settings_of_level(known.settings(), k)));
        return *find(k);
    }

    /// A level, or null if it is not there.
    const Level* find(int k) const {
        return k == 0 ? &finest_ : coarser_[static_cast<std::size_t>(k - 1)].get();
    }

    /// Calls visit(k, level) for the levels that are there.
    template <class Visitor>
    void for_each(Visitor&& visit) const {
        for (int k = 0; k <= rule_.coarsest(); ++k)
            if (const Level* level = find(k))
                visit(k, *level);
    }

    /// Walks over all that is stored.
    MeshStatistics statistics() const {
        MeshStatistics sum;
        for_each([&](int k, const Level& level) {
            const MeshStatistics held = level.statistics();
            sum.light_points += held.light_points;
            sum.bricks += held.bricks;
            sum.long_tests += held.long_tests;
            sum.long_rays += held.long_rays;
            sum.link_rays += held.link_rays;
            sum.bytes += held.bytes;
            sum.light_points_of_level[static_cast<std::size_t>(k)] = held.light_points;
            sum.bytes_of_level[static_cast<std::size_t>(k)] = held.bytes;
        });
        sum.bytes += finest_.data().light_bytes() + long_tests_.bytes() + sizeof *this - sizeof finest_;
        return sum;
    }

private:
    Tracer tracer_;
    Level finest_;
    LevelRule rule_;
    LongTests long_tests_;
    mutable std::mutex making_;
    mutable std::array<MadeOnce<const Level>, most_mesh_levels - 1> coarser_;
};

}  // namespace lightmesh::detail
