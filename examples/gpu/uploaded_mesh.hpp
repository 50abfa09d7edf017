// SPDX-License-Identifier: MIT
#pragma once

#include "compute.hpp"

#include <lightmesh/gpu/mesh_upload.hpp>

#include <cstddef>
#include <span>
#include <vector>

namespace demo {

/// A light mesh in buffers of a device.
class UploadedMesh {
public:
    /// Throws what `lightmesh::SnapshotView` and `lightmesh::MeshUpload` throw.
    UploadedMesh(const ComputeDevice& device, std::span<const std::byte> snapshot);

    /// Uploads what has changed since the last snapshot. Returns how many bytes that were. Throws as above.
    std::size_t update(std::span<const std::byte> snapshot);

    std::size_t light_count() const { return light_count_; }
    /// As `lightmesh::MeshUpload::max_quality`.
    int max_quality() const { return upload_.max_quality(); }
    /// Where shaders see it in a descriptor set. After an update that made a buffer larger there is another
    /// one in its place.
    std::vector<ComputeBinding> bindings(std::uint32_t set) const;
    /// Bytes of all buffers.
    std::size_t size() const;

private:
    ComputeDevice device_;
    std::size_t light_count_ = 0;
    lightmesh::MeshUpload upload_;
    std::vector<ComputeBuffer> buffers_;
};

}  // namespace demo
