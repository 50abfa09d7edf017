// SPDX-License-Identifier: MIT
#pragma once

#include "model.hpp"

#include <tiny_gltf.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace demo {

using Bytes = std::vector<std::uint8_t>;

/// The member of an object of the file by the name of an extension, or null.
const tinygltf::Value* gltf_extension(const tinygltf::ExtensionMap& extensions, const char* name);

/// A glTF file's JSON as tinygltf takes it apart, with the buffers and pictures that it refers to.
///
/// Buffers and pictures are read here, by the rules of the specification: percent-encoded and data URIs,
/// buffers that are longer than their byteLength, fallback buffers of EXT_meshopt_compression that are not
/// there.
class GltfFile {
public:
    /// Throws std::exception with what is wrong.
    explicit GltfFile(const std::filesystem::path& file);

    const tinygltf::Model& model() const { return model_; }
    /// The nodes, to be posed otherwise than the file has them.
    std::vector<tinygltf::Node>& nodes() { return model_.nodes; }
    std::size_t image_count() const { return images_.size(); }
    /// The lights of KHR_lights_punctual, without their places.
    const std::vector<ModelLight>& lights() const { return lights_; }
    /// Remarks that the user should be told.
    const std::vector<std::string>& notes() const { return notes_; }
    void add_note(std::string note) { notes_.push_back(std::move(note)); }

    /// Picture `image`; one that cannot be read has its reason in `problem`.
    ModelImage image(std::size_t image) const;

    /// All values of an accessor, `components` for each element; normalized integers become [0, 1] or [-1,
    /// 1]. Throws std::runtime_error for one that is not there, has another number of components, or reaches
    /// beyond its buffer.
    std::vector<float> floats(int accessor, int components) const;
    /// As `floats`, of integers as they are.
    std::vector<std::uint32_t> integers(int accessor, int components) const;
    std::size_t count(int accessor) const;
    /// Components of an accessor's elements, such as 3 of a VEC3.
    int components(int accessor) const;

    /// The bytes of a buffer view, decompressed.
    std::span<const std::uint8_t> view(int buffer_view) const;

private:
    struct ImageSource {
        std::string name;
        std::string uri;
        int buffer_view = -1;
    };

    const tinygltf::Accessor& accessor(int number) const;
    template <class Value, class Convert>
    std::vector<Value> read(int number, int components, Convert&& convert) const;
    std::filesystem::path folder_;
    tinygltf::Model model_;
    std::vector<Bytes> buffers_;
    std::vector<ImageSource> images_;
    std::vector<ModelLight> lights_;
    std::vector<std::string> notes_;
    mutable std::map<int, Bytes> decompressed_;
};

/// Bytes of a URI of either kind. Throws std::runtime_error that names it.
Bytes read_uri(const std::string& uri, const std::filesystem::path& folder);

}  // namespace demo
