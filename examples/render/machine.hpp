// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace demo {

/// All that times depend on but the scene: processor, cores, compiler, flags, kernel, Embree. Names and
/// values.
std::vector<std::pair<std::string, std::string>> describe_machine();

/// Of this machine, in bytes.
double physical_memory();

}  // namespace demo
