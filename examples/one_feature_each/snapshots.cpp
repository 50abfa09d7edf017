// SPDX-License-Identifier: MIT
//
// What a light mesh has found, kept in a file: a second start of the program needs no ray to a light, and a
// program without a ray tracer can read the file where it lies.
#include "scene.hpp"

#include <lightmesh/snapshot.hpp>

#include <filesystem>
#include <fstream>
#include <stdexcept>

int main() {
    // Without short tests (Express), whatever was asked before is answered without any ray.
    const lightmesh::Settings settings{.radius = 0.8f, .short_test = lightmesh::ShortTest::none};
    const std::vector<glm::vec3> points = scene::floor_points();
    const std::vector<glm::vec3> normals(points.size(), scene::floor_normal);
    std::vector<float> first(points.size() * scene::lights.size());
    std::vector<float> second(first.size());
    {
        const lightmesh::LightMesh mesh{scene::Tracer{}, scene::lights, settings};
        mesh.visibility(points, normals, first);
        const std::vector<std::byte> bytes = mesh.snapshot();
        std::ofstream file("snapshots.mesh", std::ios::binary);
        file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
        if (!file.flush())
            return 1;
        std::cout << "a start: " << mesh.statistics().long_rays << " long rays\n";
    }

    std::vector<std::byte> bytes(std::filesystem::file_size("snapshots.mesh"));
    std::ifstream("snapshots.mesh", std::ios::binary)
        .read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    lightmesh::LightMesh mesh{scene::Tracer{}, scene::lights, settings};
    mesh.merge(bytes);
    mesh.visibility(points, normals, second);
    std::cout << "a second start: " << mesh.statistics().long_rays << " long rays, "
              << (first == second ? "the same values" : "other values") << '\n';

    // In place: in memory, or in a file that is mapped into it. What needs a ray would be NaN.
    const lightmesh::SnapshotView view(bytes);
    std::vector<float> row(view.light_count());
    std::vector<float> lamp;
    std::size_t unknown = 0;
    for (const glm::vec3& point : points) {
        unknown += view.visibility(point, scene::floor_normal, row);
        lamp.push_back(row[0]);
    }
    scene::print_row("without tracer", lamp);
    unknown += view.visibility({50, 50, 0}, scene::floor_normal, row);  // nobody has been there
    std::cout << "not in the snapshot: " << unknown << " values of a place where nobody has asked\n";

    bytes[bytes.size() / 2] ^= std::byte{1};
    try {
        mesh.merge(bytes);
    } catch (const std::invalid_argument& damaged) {
        std::cout << "one bit changed: " << damaged.what() << '\n';
        return first == second ? 0 : 1;
    }
    return 1;
}
