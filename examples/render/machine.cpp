// SPDX-License-Identifier: MIT
#include "render/machine.hpp"

#include "adapters/embree_intersector.hpp"

#include <lightmesh/light_mesh.hpp>

#include <unistd.h>

#include <fstream>
#include <thread>

namespace demo {

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

}  // namespace

std::vector<std::pair<std::string, std::string>> describe_machine() {
    return {{"processor", processor()},
            {"cores", std::to_string(std::thread::hardware_concurrency())},
            {"compiler", compiler()},
            {"flags", LIGHTMESH_FLAGS},
            {"kernel", lightmesh::kernel_name()},
            {"Embree", RTC_VERSION_STRING}};
}

double physical_memory() {
    return static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
}

}  // namespace demo
