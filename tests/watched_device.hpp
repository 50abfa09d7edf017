// SPDX-License-Identifier: MIT
#pragma once

#include "gpu/compute.hpp"

#include <string>
#include <vector>

namespace test {

/// A device under the validation layers, and what these say. Needs a Vulkan driver (Mesa's lavapipe will do)
/// and the layers.
struct WatchedDevice {
    explicit WatchedDevice(const demo::ComputeOptions& options = {}) : device(watched(options)) {}
    WatchedDevice(const WatchedDevice&) = delete;

    std::vector<std::string> messages;
    demo::ComputeDevice device;

private:
    demo::ComputeOptions watched(demo::ComputeOptions options) {
        options.validate = true;
        options.on_message = [this](const std::string& text) {
            messages.push_back(text);
        };
        return options;
    }
};

}  // namespace test
