// SPDX-License-Identifier: MIT
#include "adapters/embree_depth_renderer.hpp"
#include "render/embree_scene.hpp"
#include "scene/scene.hpp"

#include <lightmesh/adapters/depth_view.hpp>
#include <lightmesh/shadows/shadow_map_views.hpp>

#include <doctest/doctest.h>
#include <tbb/parallel_for.h>

#include <atomic>
#include <cstddef>
#include <vector>

namespace embree_depth_renderer_test {

// A mesh renders shadow maps under a lock. Without isolation, a thread that waits for a picture could take
// over a query that waits for the same lock.
TEST_CASE("a thread that renders by Embree takes over no other task meanwhile") {
    const demo::Scene scene = demo::make_spheres();
    const demo::EmbreeScene embree(scene);
    const lightmesh::Light light = lightmesh::PointLight{{0.0f, 0.0f, 5.0f}};
    lightmesh::ShadowMapSettings settings;
    settings.resolution = 128;
    settings.z_near = 0.01f;
    const lightmesh::detail::ShadowMapViews views(light, settings, "light");
    static thread_local int depth = 0;
    std::atomic<int> taken_over{0};
    tbb::parallel_for(0, 200, [&](int i) {
        if (depth > 0)
            ++taken_over;
        ++depth;
        std::vector<float> distance(std::size_t{128} * 128);
        demo::EmbreeDepthRenderer renderer(embree.handle());
        renderer.render_depth(views[static_cast<std::size_t>(i % 6)], distance);
        --depth;
    });
    CHECK(taken_over == 0);
}

}  // namespace embree_depth_renderer_test
