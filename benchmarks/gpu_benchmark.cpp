// SPDX-License-Identifier: MIT
#include "gpu_benchmark.hpp"

#include <cstdio>
#include <exception>
#include <string_view>

namespace bench {

int run_on_device(const char* name, int argc, char** argv,
                  const std::function<bool(const demo::ComputeDevice&)>& run) {
    demo::ComputeOptions options;
    if (argc == 3 && std::string_view(argv[1]) == "--device") {
        options.device = argv[2];
    } else if (argc != 1) {
        std::fprintf(stderr, "usage: %s [--device NAME]\n", name);
        return 2;
    }
    try {
        const demo::ComputeDevice device(options);
        std::printf("%s, %s\n\n", device.name().c_str(), device.driver().c_str());
        return run(device) ? 0 : 1;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s: %s\n", name, error.what());
        return 1;
    }
}

std::vector<lightmesh::SurfacePoint> surface_points(const ShadingPoints& points) {
    std::vector<lightmesh::SurfacePoint> all;
    all.reserve(points.size());
    for (std::size_t t = 0; t < points.tile_count(); ++t) {
        const Points tile = points.tile(t);
        for (std::size_t i = 0; i < tile.size(); ++i)
            all.push_back({.position = tile.positions[i], .normal = tile.normals[i]});
    }
    return all;
}

}  // namespace bench
