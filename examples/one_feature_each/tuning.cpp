// SPDX-License-Identifier: MIT
//
// Which settings? Measured with one's own tracer, lights and shading points, since what a ray costs decides.
#include "scene.hpp"

#include <lightmesh/tune.hpp>

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
    const tune::Subject subject{scene::Tracer{}, scene::lights, samples};

    // How soft shadows are is a matter of looks, so of one radius; quality and short test are for measuring.
    const std::vector<tune::Candidate> candidates =
        tune::make_candidates({.radii = {0.8f},
                               .qualities = {2.0f, 3.0f, 4.0f},
                               .short_tests = {lightmesh::ShortTest::none, lightmesh::ShortTest::linked}});
    tune::Options options;
    options.reference_points = 64;
    options.least_seconds = 0.01;
    const tune::Outcome outcome = tune::run(subject, candidates, options);
    for (const tune::Measurement& measured : outcome.measurements)
        std::cout << tune::describe(measured.candidate) << ": error " << 100.0 * measured.mean_absolute_error
                  << " %, " << measured.warm_ns_per_point << " ns a point, " << measured.frame.bytes / 1e6
                  << " MB a frame\n";

    const tune::Recommendation advice =
        tune::recommend(outcome.measurements, {.mean_absolute_error = 0.004, .frame = tune::Frame::later});
    std::cout << advice.reason << '\n';
    if (!advice.choice)
        return 1;
    std::cout << "paste: " << tune::to_source(advice.choice->candidate) << '\n';
    return 0;
}
