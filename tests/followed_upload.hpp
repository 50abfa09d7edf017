// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/gpu/upload.hpp>

#include <doctest/doctest.h>

#include <algorithm>
#include <cstddef>
#include <vector>

namespace test {

/// What a host that follows the ranges of an upload has in its buffers. `Upload`: of a mesh or of a cache.
template <class Upload>
class FollowedUpload {
public:
    explicit FollowedUpload(const Upload& upload) {
        for (const lightmesh::UploadBuffer& buffer : upload.buffers())
            buffers_.emplace_back(buffer.bytes.begin(), buffer.bytes.end());
    }

    /// Returns how many bytes were written.
    std::size_t write(const Upload& upload, const std::vector<lightmesh::UploadRange>& ranges) {
        std::size_t written = 0;
        for (const lightmesh::UploadRange& range : ranges) {
            buffers_[range.binding].resize(upload.buffers()[range.binding].bytes.size());
            REQUIRE(range.offset + range.bytes.size() <= buffers_[range.binding].size());
            std::ranges::copy(range.bytes,
                              buffers_[range.binding].begin() + static_cast<std::ptrdiff_t>(range.offset));
            written += range.bytes.size();
        }
        return written;
    }
    bool equals(const Upload& upload) const {
        return std::ranges::all_of(upload.buffers(), [this](const lightmesh::UploadBuffer& buffer) {
            return std::ranges::equal(buffers_[buffer.binding], buffer.bytes);
        });
    }
    std::size_t size() const {
        std::size_t sum = 0;
        for (const auto& buffer : buffers_)
            sum += buffer.size();
        return sum;
    }

private:
    std::vector<std::vector<std::byte>> buffers_;
};

}  // namespace test
