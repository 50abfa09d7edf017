// SPDX-License-Identifier: MIT
//
// A light mesh in a shader: uploaded while it knows nothing, asked, filled with what the shader asked for,
// and asked again. The Vulkan behind it is that of ../gpu/compute.hpp; any other will do.
#include "../gpu/compute.hpp"
#include "scene.hpp"

#include <lightmesh/gpu/mesh_upload.hpp>

#include <algorithm>
#include <cstdint>
#include <exception>

constexpr std::uint32_t shader[] = {
#include "spirv/shaders.comp.inc"
};

int main() try {
    const lightmesh::LightMesh mesh{scene::Tracer{}, scene::lights, lightmesh::Settings{.radius = 0.8f}};
    std::vector<std::byte> bytes = mesh.snapshot();
    lightmesh::MeshUpload upload{lightmesh::SnapshotView(bytes)};
    const std::vector<std::byte> no_requests = lightmesh::empty_requests(256);

    const demo::ComputeDevice device;
    std::cout << device.name() << '\n';
    std::vector<demo::ComputeBinding> bindings;
    for (const lightmesh::UploadBuffer& buffer : upload.buffers())
        bindings.push_back({0, buffer.binding, demo::ComputeBuffer(device, buffer.bytes)});
    const demo::ComputeBuffer requests(device, no_requests);
    bindings.push_back({0, lightmesh::MeshUpload::requests_binding, requests});

    const std::vector<glm::vec3> floor = scene::floor_points();
    std::vector<glm::vec4> points;
    for (const glm::vec3& point : floor)
        points.emplace_back(point, 0.0f);
    bindings.push_back({1, 0, demo::ComputeBuffer(device, std::as_bytes(std::span(points)))});
    const demo::ComputeBuffer found(device, points.size() * scene::lights.size() * sizeof(float));
    bindings.push_back({1, 1, found});
    const demo::ComputeKernel kernel(device, shader, bindings);

    std::vector<float> visibilities;
    for (int round = 0; round < 16; ++round) {
        requests.write(0, no_requests);
        device.run([&](const demo::ComputeCommands& commands) { commands.dispatch(kernel, 2); });
        visibilities = found.read_all<float>();
        const auto missing = std::ranges::count(visibilities, -1.0f);
        const auto wanted = lightmesh::read_requests(requests.read_all<std::byte>());
        std::cout << "missing: " << missing << " of " << visibilities.size()
                  << ", asked for: " << wanted.points.size() << " points\n";
        if (wanted.points.empty())
            break;
        mesh.fill(wanted.points);
        bytes = mesh.snapshot();
        for (const lightmesh::UploadRange& range : upload.update(lightmesh::SnapshotView(bytes))) {
            demo::ComputeBinding& bound = bindings[range.binding];
            if (const auto size = upload.buffers()[range.binding].bytes.size();
                bound.buffer().size() != size) {
                bound.resource = demo::ComputeBuffer(device, size);
                kernel.bind(bound);
            }
            bound.buffer().write(range.offset, range.bytes);
        }
    }

    std::vector<float> expected(visibilities.size());
    mesh.visibility(floor, std::vector<glm::vec3>(floor.size(), scene::floor_normal), expected);
    std::vector<float> lamp;
    for (std::size_t i = 0; i < floor.size(); ++i)
        lamp.push_back(visibilities[scene::lights.size() * i]);
    scene::print_row("shader", lamp);
    std::cout << "the CPU's values: " << (visibilities == expected ? "yes" : "no") << '\n';
    return visibilities == expected ? 0 : 1;
} catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
}
