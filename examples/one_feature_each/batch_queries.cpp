// SPDX-License-Identifier: MIT
//
// Many points in one query, many rays in one call: how a renderer of tiles, with a tracer of packets, uses a
// light mesh.
#include "scene.hpp"

#include <cstdint>
#include <utility>

struct Counts {
    int packets = 0, in_packets = 0, alone = 0;
};

// A tracer that takes many segments at once: the library finds the second member by itself.
struct PacketTracer {
    scene::Tracer tracer;
    Counts* counts;  // with several threads, these would have to be atomic

    bool occluded(const lightmesh::Segment& segment) const {
        ++counts->alone;
        return tracer.occluded(segment);
    }
    void occluded(std::span<const lightmesh::Segment> segments, std::span<std::uint8_t> hit) const {
        ++counts->packets;
        counts->in_packets += static_cast<int>(segments.size());
        for (std::size_t i = 0; i < segments.size(); ++i)  // here: rtcOccluded16, or a stream
            hit[i] = tracer.occluded(segments[i]) ? 1 : 0;
    }
};

int main() {
    const std::vector<glm::vec3> points = scene::floor_points();
    const std::vector<glm::vec3> normals(points.size(), scene::floor_normal);
    Counts counts;
    const lightmesh::LightMesh mesh{PacketTracer{{}, &counts}, scene::lights,
                                    lightmesh::Settings{.radius = 0.8f}};

    // A row of the result for each point: S of light i at point p is all[p * mesh.light_count() + i].
    std::vector<float> all(points.size() * mesh.light_count());
    mesh.visibility(points, normals, all);
    std::cout << points.size() << " points at once: " << counts.in_packets << " rays in " << counts.packets
              << " packets, " << std::exchange(counts, {}).alone << " alone\n";

    bool same = true;
    std::vector<float> one(mesh.light_count());
    for (std::size_t p = 0; p < points.size(); ++p) {
        mesh.visibility(points[p], normals[p], one);
        for (std::size_t i = 0; i < one.size(); ++i)
            same = same && one[i] == all[p * one.size() + i];
    }
    std::cout << "one by one, on the mesh as it is now: " << counts.in_packets << " rays in "
              << counts.packets << " packets, " << counts.alone << " alone\n";
    std::cout << "the same values: " << (same ? "yes" : "no") << '\n';
    return same ? 0 : 1;
}
