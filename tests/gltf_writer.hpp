// SPDX-License-Identifier: MIT
#pragma once

#include "temporary_folder.hpp"

#include <cstddef>
#include <filesystem>
#include <initializer_list>
#include <string>

namespace test {

/// Writes a glTF file of one triangle, (0, 0, 0), (1, 0, 0), (0, 1, 0) as accessor 0, and of accessors of
/// floats that follow it.
class GltfFile {
public:
    GltfFile() { add("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0}); }

    /// The number of the accessor.
    int add(const std::string& type, std::initializer_list<float> values) {
        const std::size_t width = type == "SCALAR" ? 1 : type == "VEC3" ? 3 : 4;
        const std::string first = std::to_string(bytes_.size());
        for (const float value : values)
            bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
        views_ += std::string(count_ == 0 ? "" : ",") + R"({"buffer":0,"byteOffset":)" + first +
                  R"(,"byteLength":)" + std::to_string(4 * values.size()) + "}";
        accessors_ += std::string(count_ == 0 ? "" : ",") + R"({"componentType":5126,"bufferView":)" +
                      std::to_string(count_) + R"(,"type":")" + type + R"(","count":)" +
                      std::to_string(values.size() / width) + "}";
        return count_++;
    }

    /// `rest`: members of the file besides those of geometry, such as nodes.
    std::filesystem::path write(const TemporaryFolder& folder, const std::string& rest) const {
        folder.write("a.bin", bytes_);
        return folder.write("a.gltf", R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"accessors":[)" +
                                          accessors_ + R"(],"bufferViews":[)" + views_ +
                                          R"(],"buffers":[{"uri":"a.bin","byteLength":)" +
                                          std::to_string(bytes_.size()) + "}]," + rest + "}");
    }

private:
    std::string bytes_;
    std::string views_;
    std::string accessors_;
    int count_ = 0;
};

}  // namespace test
