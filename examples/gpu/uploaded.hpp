// SPDX-License-Identifier: MIT
#pragma once

#include "compute.hpp"

#include <lightmesh/gpu/cache_upload.hpp>
#include <lightmesh/gpu/mesh_upload.hpp>
#include <lightmesh/snapshot.hpp>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace demo {

/// A light mesh or a visibility cache in buffers of a device, as `Upload` lays it out:
/// `lightmesh::MeshUpload` or `lightmesh::CacheUpload`.
template <class Upload>
class Uploaded {
public:
    /// Throws what `lightmesh::SnapshotView`, `Upload` and `ComputeBuffer` throw.
    Uploaded(const ComputeDevice& device, std::span<const std::byte> snapshot)
        : Uploaded(device, lightmesh::SnapshotView(snapshot)) {}

    /// Uploads what has changed since the last snapshot. Returns how many bytes that were. Throws as above.
    std::size_t update(std::span<const std::byte> snapshot) {
        const lightmesh::SnapshotView view(snapshot);
        std::size_t written = 0;
        std::vector<std::vector<ComputeWrite>> writes(buffers_.size());
        for (const lightmesh::UploadRange& range : upload_.update(view)) {
            ComputeBuffer& buffer = buffers_[range.binding];
            if (buffer.size() != upload_.buffers()[range.binding].bytes.size())
                buffer = ComputeBuffer(device_, range.bytes);
            else
                writes[range.binding].push_back({range.offset, range.bytes});
            written += range.bytes.size();
        }
        for (std::size_t i = 0; i < buffers_.size(); ++i)
            buffers_[i].write(writes[i]);
        light_count_ = view.light_count();
        return written;
    }

    const Upload& upload() const { return upload_; }
    std::size_t light_count() const { return light_count_; }
    /// The binding where shaders see it in a descriptor set. After an update that made a buffer larger there
    /// is another one in its place.
    std::vector<ComputeBinding> bindings(std::uint32_t set) const {
        std::vector<ComputeBinding> made;
        for (const ComputeBuffer& buffer : buffers_)
            made.push_back({set, static_cast<std::uint32_t>(made.size()), buffer});
        return made;
    }
    /// Bytes of all buffers.
    std::size_t size() const {
        std::size_t sum = 0;
        for (const ComputeBuffer& buffer : buffers_)
            sum += buffer.size();
        return sum;
    }

private:
    Uploaded(const ComputeDevice& device, const lightmesh::SnapshotView& view)
        : device_(device), light_count_(view.light_count()), upload_(view) {
        for (const lightmesh::UploadBuffer& buffer : upload_.buffers())
            buffers_.emplace_back(device_, buffer.bytes);
    }

    ComputeDevice device_;
    std::size_t light_count_;
    Upload upload_;
    std::vector<ComputeBuffer> buffers_;
};

using UploadedMesh = Uploaded<lightmesh::MeshUpload>;
using UploadedCache = Uploaded<lightmesh::CacheUpload>;

}  // namespace demo
