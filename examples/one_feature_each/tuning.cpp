// SPDX-License-Identifier: MIT
//
// A light mesh or a visibility cache, and with which settings? Measured with one's own tracer, lights and
// shading points, since what a ray costs decides.
#include "scene.hpp"

#include <lightmesh/tune.hpp>

#include <variant>

namespace tune = lightmesh::tune;

int main() {
    // Points that the renderer shades, in its order; a sample of a frame of 1,000,000.
    std::vector<glm::vec3> points;
    for (int row = 0; row < 32; ++row)
        for (glm::vec3 point : scene::floor_points(64)) {
            point.y = 0.1f * static_cast<float>(row - 16);
            points.push_back(point);
        }
    const std::vector<glm::vec3> normals(points.size(), scene::floor_normal);
    const tune::Samples samples{points, normals, 1'000'000};
    // With their sizes: caches show them.
    std::vector<lightmesh::Light> lamps = scene::lights;
    for (lightmesh::Light& lamp : lamps)
        std::get<lightmesh::PointLight>(lamp).radius = 0.5f;
    const tune::Subject subject{scene::Tracer{}, lamps, samples};

    // How soft shadows of a mesh are is a matter of looks, so of one radius; all else is for measuring.
    const std::vector<tune::Candidate> candidates =
        tune::make_candidates({.radii = {0.8f},
                               .qualities = {2.0f, 3.0f, 4.0f},
                               .short_tests = {lightmesh::ShortTest::none, lightmesh::ShortTest::linked},
                               .spacings = {0.2f, 0.4f},
                               .lamp_rays = {64}});
    tune::Options options;
    options.reference_points = 64;
    options.least_seconds = 0.01;
    const tune::Outcome outcome = tune::run(subject, candidates, options);
    for (const tune::Measurement& measured : outcome.measurements)
        std::cout << tune::describe(measured.candidate) << ": error " << 100.0 * measured.mean_absolute_error
                  << " %, to lamps " << 100.0 * measured.lamp_error << " %, " << measured.warm_ns_per_point
                  << " ns a point, " << measured.frame.bytes / 1e6 << " MB a frame\n";

    const tune::Recommendation advice =
        tune::recommend(outcome.measurements, {.mean_absolute_error = 0.004, .frame = tune::Frame::later});
    std::cout << advice.reason << '\n';
    if (!advice.choice)
        return 1;
    std::cout << "paste: " << tune::to_source(advice.choice->candidate) << '\n';
    return 0;
}
