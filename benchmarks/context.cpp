// SPDX-License-Identifier: MIT
#include "context.hpp"

#include "adapters/embree_intersector.hpp"
#include "workloads.hpp"

#include <lightmesh/lightmesh.hpp>

#include <benchmark/benchmark.h>

#include <fstream>
#include <string>
#include <type_traits>

namespace bench {

namespace {

std::string processor() {
    std::ifstream file("/proc/cpuinfo");
    for (std::string line; std::getline(file, line);)
        if (line.starts_with("model name"))
            return line.substr(line.find(':') + 2);
    return "unknown";
}

std::string compiler() {
#if defined(__clang__)
    return "clang " __clang_version__;
#elif defined(__GNUC__)
    return "gcc " __VERSION__;
#else
    return "unknown";
#endif
}

std::string kernel() {
    constexpr bool portable =
        std::is_same_v<lightmesh::detail::FastestKernel, lightmesh::detail::PortableKernel>;
    return portable ? "portable" : "AVX-512";
}

}  // namespace

void describe_context() {
    benchmark::AddCustomContext("processor", processor());
    benchmark::AddCustomContext("compiler", compiler());
    benchmark::AddCustomContext("flags", LIGHTMESH_BENCHMARK_FLAGS);
    benchmark::AddCustomContext("kernel", kernel());
    benchmark::AddCustomContext("embree", RTC_VERSION_STRING);
    benchmark::AddCustomContext("picture",
                                std::to_string(picture_width) + "x" + std::to_string(picture_height));
}

}  // namespace bench
