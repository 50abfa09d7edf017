// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/concepts.hpp>
#include <lightmesh/adapters/diagnostics.hpp>
#include <lightmesh/adapters/self_test/known_test.hpp>
#include <lightmesh/adapters/self_test/scene_test.hpp>
#include <lightmesh/bounds.hpp>

#include <glm/vec3.hpp>

#include <array>
#include <concepts>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

/// An adapter's self-test: whether it keeps the contract of `Intersector` at run time. For a user's tests or
/// for the first start with a new tracer, not for each frame.

namespace lightmesh {

/// Tests a tracer over a scene of which nothing is known: its answers against each other. Returns a sentence
/// for each fault, with how many answers are wrong and a segment as an example; nothing if none was found.
///
///     for (const std::string& fault : lightmesh::check_tracer(Tracer{&my_scene}, bounds_of_my_scene))
///         std::cerr << fault << '\n';
///
/// Finds: axis-parallel segments that miss; surfaces that block from one side; a length that is taken for
/// another; segments of length 0 that are blocked; shadows that get lost when a segment is made longer, up to
/// 2^20 times; batches that differ from single segments; state that threads share; answers that change; a
/// `closest_hit` that does not fit `occluded`, that is not in world units, or without unit normals.
/// Where rounding may decide, at edges, up to 1 in 1000 answers may differ.
///
/// Costs about 50,000 segments, always the same ones, on four more threads in part: less than a second with
/// most tracers. Programs that call it must link the system's threads.
///
/// Cannot find what it has nothing to compare with: surfaces that are missing or that stand elsewhere,
/// inclusive ends, an epsilon that is small beside `scene`, faults that only few segments or seldom a thread
/// meet. A fault may hide others: test again when it is mended. `scene` are the bounds of the surfaces: if
/// they fill little of it, little is tested. What the adapter throws leaves the function. Throws
/// std::invalid_argument for Bounds that are not finite or the wrong way round.
template <class Tracer>
    requires(!std::invocable<const Tracer&, std::span<const std::array<glm::vec3, 3>>>)
std::vector<std::string> check_tracer(const Tracer& tracer, const Bounds& scene) {
    static_assert(check_intersector<Tracer>());
    return detail::SceneTest<Tracer>(tracer, scene).run();
}

/// The same with a factory: makes tracers of triangles of which all answers are known, so that it finds more.
/// make_tracer(std::span<const std::array<glm::vec3, 3>>) returns an Intersector over these triangles; they
/// stay where they are as long as the tracer that it returns.
///
/// Finds besides: inclusive ends, an epsilon near the ends or one that depends on the scene's size, sheets
/// and flat boxes that are lost, since their bounds have no thickness, slivers that are lost, wrong geometric
/// normals, and any wrong answer that is not near to an edge. Triangles may be without area, as in users'
/// scenes.
///
/// Costs some 30 tracers of at most 32 triangles and about 60,000 segments. Cannot find faults that only
/// large scenes have.
template <class Factory>
    requires std::invocable<Factory&, std::span<const std::array<glm::vec3, 3>>> std::vector<std::string>
    check_tracer(Factory&& make_tracer) {
        using Tracer =
            std::remove_cvref_t<std::invoke_result_t<Factory&, std::span<const std::array<glm::vec3, 3>>>>;
        static_assert(check_intersector<Tracer>());
        return detail::KnownTest<std::remove_reference_t<Factory>>(make_tracer).run();
    }

}  // namespace lightmesh
