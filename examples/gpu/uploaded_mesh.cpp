// SPDX-License-Identifier: MIT
#include "uploaded_mesh.hpp"

#include <lightmesh/snapshot.hpp>

namespace demo {

UploadedMesh::UploadedMesh(const ComputeDevice& device, std::span<const std::byte> snapshot)
    : device_(device), upload_([&] {
          const lightmesh::SnapshotView view(snapshot);
          light_count_ = view.light_count();
          return lightmesh::MeshUpload(view);
      }()) {
    for (const lightmesh::UploadBuffer& buffer : upload_.buffers())
        buffers_.emplace_back(device_, buffer.bytes);
}

std::size_t UploadedMesh::update(std::span<const std::byte> snapshot) {
    const lightmesh::SnapshotView view(snapshot);
    std::size_t written = 0;
    for (const lightmesh::UploadRange& range : upload_.update(view)) {
        ComputeBuffer& buffer = buffers_[range.binding];
        if (buffer.size() != upload_.buffers()[range.binding].bytes.size())
            buffer = ComputeBuffer(device_, range.bytes);
        else
            buffer.write(range.offset, range.bytes);
        written += range.bytes.size();
    }
    light_count_ = view.light_count();
    return written;
}

std::vector<ComputeBinding> UploadedMesh::bindings(std::uint32_t set) const {
    std::vector<ComputeBinding> made;
    for (const ComputeBuffer& buffer : buffers_)
        made.push_back({set, static_cast<std::uint32_t>(made.size()), buffer});
    return made;
}

std::size_t UploadedMesh::size() const {
    std::size_t sum = 0;
    for (const ComputeBuffer& buffer : buffers_)
        sum += buffer.size();
    return sum;
}

}  // namespace demo
