// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/concepts.hpp>
#include <lightmesh/bounds.hpp>
#include <lightmesh/fill/mesh_filler.hpp>
#include <lightmesh/lights.hpp>
#include <lightmesh/mesh/brick.hpp>
#include <lightmesh/mesh/grid.hpp>
#include <lightmesh/mesh/level.hpp>
#include <lightmesh/mesh/light_table.hpp>
#include <lightmesh/mesh/merge.hpp>
#include <lightmesh/mesh/mesh_change.hpp>
#include <lightmesh/mesh/mesh_data.hpp>
#include <lightmesh/mesh/scene_change.hpp>
#include <lightmesh/mesh/snapshot_format.hpp>
#include <lightmesh/settings.hpp>
#include <lightmesh/statistics.hpp>
#include <lightmesh/support/check.hpp>
#include <lightmesh/support/check_light.hpp>
#include <lightmesh/support/frame_ages.hpp>
#include <lightmesh/support/made_once.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

namespace lightmesh::detail {

/// The adapters that a mesh asks when it lacks something.
template <Intersector Tracer, class LongTests>
struct MeshAdapters {
    Tracer tracer;
    LongTests long_tests;
};

/// The levels of a mesh, each a mesh of its own but for lights and adapters, which they share: shadow maps
/// and volumes begin where those of level 0 do. Level 0 is always there, the others are made when a point
/// first asks for them. To its users it is constant, and any number of threads may ask. Must not move.
///
/// What changes lights or forgets something is for one thread, while nobody else uses the levels.
template <Intersector Tracer, class LongTests>
class MeshLevels {
public:
    using LongTestsType = LongTests;
    using Adapters = MeshAdapters<Tracer, LongTests>;
    using Level = MeshFiller<Tracer, LongTests>;

    /// Throws what `MeshData`, `LevelRule` and the long tests throw.
    template <class... LongTestArguments>
    MeshLevels(Tracer tracer, std::span<const Light> lights, const Settings& settings,
               LongTestArguments&&... long_tests)
        : MeshLevels{checked(lights, settings),
                     std::make_shared<Adapters>(Adapters{
                         std::move(tracer), LongTests(std::forward<LongTestArguments>(long_tests)...)})} {}
    /// Takes what another mesh with the same adapters knows of the lights that both have, in the bricks that
    /// queries have asked for in the last frames: at most so many frames before this one. `keeps_lights`: as
    /// `LevelMerge`. Throws std::bad_alloc.
    MeshLevels(const MeshLevels& other, std::span<const Light> lights, int most_frames_unused = 0xffff,
               bool keeps_lights = true)
        : MeshLevels({lights, other.finest_.data().settings()}, other.adapters_) {
        evicted_bricks_ = other.evicted_bricks_;
        other.for_each([&](int k, const Level& from) {
            const auto is_kept = [&](const Brick& brick) {
                return from.data().frames_unused(brick) <= most_frames_unused;
            };
            level(k).copy(from, is_kept, keeps_lights);
            from.data().for_each_brick(
                [&](const Brick& brick) { evicted_bricks_ += is_kept(brick) ? 0u : 1u; });
        });
        forgotten_ = other.forgotten_;
    }
    MeshLevels(const MeshLevels&) = delete;
    MeshLevels& operator=(const MeshLevels&) = delete;

    const Tracer& tracer() const { return adapters_->tracer; }
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
        auto level = std::make_unique<const Level>(adapters_->tracer, adapters_->long_tests, known,
                                                   settings_of_level(known.settings(), k));
        level->data().set_frame(known.frame());
        coarser_[static_cast<std::size_t>(k - 1)].publish(std::move(level));
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
            sum.add_level(static_cast<std::size_t>(k), level.statistics());
        });
        sum.forgotten_visibilities = forgotten_.visibilities;
        sum.forgotten_links = forgotten_.links;
        sum.forgotten_floods = forgotten_.floods;
        sum.evicted_bricks = evicted_bricks_;
        adapters_->long_tests.count(sum);
        sum.bytes += finest_.data().light_bytes() + adapters_->long_tests.bytes() + sizeof *this +
                     sizeof *adapters_ - sizeof finest_;
        return sum;
    }

    /// Puts a light in the place of another; the same one costs nothing. Throws what `LightTable` and the
    /// long tests throw; nothing has changed then.
    void set_light(std::size_t i, const Light& light) {
        const MeshData& known = finest_.data();
        if (record_of(light) == record_of(known.user_lights()[i]))
            return;
        const LightTable lights = known.lights().with(i, light);
        auto user_lights =
            std::make_shared<std::vector<Light>>(known.user_lights().begin(), known.user_lights().end());
        (*user_lights)[i] = light;
        const bool looks_alike = lights.shape(i) == known.lights().shape(i);
        for_each([](int, const Level& level) { level.data().prepare_update(); });
        if (!looks_alike)
            adapters_->long_tests.set_light(i, light);
        const std::size_t slot = lights.order().slot_of(i);
        for_each([&](int, const Level& level) {
            MeshData& data = level.data();
            data.reuse_superseded();
            data.set_lights(lights, user_lights);
            if (looks_alike)
                return;
            data.for_each_brick([&](const Brick& brick) {
                forgotten_.visibilities +=
                    data.forget(brick, slot / lights_per_tile, std::uint64_t{1} << slot % lights_per_tile);
            });
        });
    }

    /// The same levels with a light more, behind all others; these are not to be used any more then. Throws
    /// as `set_light`.
    std::unique_ptr<MeshLevels> with_light(const Light& light) {
        const auto known = finest_.data().user_lights();
        std::vector<Light> lights(known.begin(), known.end());
        lights.push_back(light);
        check_light(light, "light " + to_text(known.size()));
        adapters_->long_tests.add_light(light);
        try {
            return std::make_unique<MeshLevels>(*this, lights);
        } catch (...) {
            adapters_->long_tests.remove_last();
            throw;
        }
    }

    /// The ways that the lights look at the scene.
    std::vector<LightSight> sights() const {
        std::vector<LightSight> sights;
        for (std::size_t i = 0; i < finest_.data().lights().size(); ++i)
            sights.push_back(adapters_->long_tests.sight_of(i));
        return sights;
    }

    /// Forgets all that may have to do with changes of the scene in some boxes. Throws what the long tests
    /// throw; nothing of the mesh has changed then.
    void forget(std::span<const Bounds> boxes) {
        LongTests& long_tests = adapters_->long_tests;
        auto change = long_tests.prepare_change(finest_.data().user_lights());
        const std::vector<LightSight> of_lights = sights();
        std::vector<MeshChange> of_levels;
        of_levels.reserve(most_mesh_levels);
        for_each([&](int, const Level& level) {
            level.data().prepare_update();
            of_levels.emplace_back(level.data(), boxes, of_lights, change.is_new);
        });
        // From here on nothing throws.
        long_tests.commit(std::move(change), boxes);
        auto of_level = of_levels.begin();
        for_each([&](int, const Level& level) {
            level.data().reuse_superseded();
            forgotten_ += of_level++->forget_in(level.data());
        });
    }

    /// Bytes of what is known.
    std::size_t bytes() const {
        std::size_t sum = 0;
        for_each([&](int, const Level& level) { sum += level.data().bytes(); });
        return sum;
    }

    /// The numbers of frames for which bricks have gone unused.
    FrameAges ages() const {
        FrameAges ages;
        for_each([&](int, const Level& level) {
            level.data().for_each_brick(
                [&](const Brick& brick) { ages.add(level.data().frames_unused(brick)); });
        });
        return ages;
    }

    /// Begins to count the next frame.
    void next_frame() {
        for_each([](int, const Level& level) {
            level.data().set_frame(static_cast<std::uint16_t>(level.data().frame() + 1));
        });
    }

private:
    /// Of lights and settings that the long tests can be made of, too.
    struct LightsAndSettings {
        std::span<const Light> lights;
        const Settings& settings;
    };
    static LightsAndSettings checked(std::span<const Light> lights, const Settings& settings) {
        static_cast<void>(Grid(settings));
        check_lights(lights);
        static_cast<void>(LevelRule(settings));
        return {lights, settings};
    }

    MeshLevels(const LightsAndSettings& of, std::shared_ptr<Adapters> adapters)
        : adapters_(std::move(adapters)),
          finest_(adapters_->tracer, adapters_->long_tests, of.lights, of.settings), rule_(of.settings) {}

    std::shared_ptr<Adapters> adapters_;
    Level finest_;
    LevelRule rule_;
    ForgottenCounts forgotten_;
    std::uint64_t evicted_bricks_ = 0;
    mutable std::mutex making_;
    mutable std::array<MadeOnce<const Level>, most_mesh_levels - 1> coarser_;
};

}  // namespace lightmesh::detail
