// SPDX-License-Identifier: MIT
#pragma once

#include "gpu/compute.hpp"

#include <string>
#include <vector>

namespace test {

/// A device under the validation layers, and what these say. Needs a Vulkan driver (Mesa's lavapipe will do)
/// and the layers.
struct WatchedDevice {
    WatchedDevice() = default;
    WatchedDevice(const WatchedDevice&) = delete;

    std::vector<std::string> messages;
    demo::ComputeDevice device{{.validate = true, .on_message = [this](const std::string& text) {
                                    messages.push_back(text);
                                }}};
};

}  // namespace test
