// SPDX-License-Identifier: MIT
#pragma once

#include "render/run.hpp"

#include <string>

namespace demo {

/// As `run`, but the picture is made by compute shaders on the Vulkan device that the options name. Throws
/// std::invalid_argument that names the option for what shaders do not know, and std::runtime_error where
/// this program was built without them or the device fails.
Run run_on_gpu(const std::string& algorithm, const EmbreeScene& scene, const VisibilityOptions& visibility,
               const RenderOptions& options);

}  // namespace demo
