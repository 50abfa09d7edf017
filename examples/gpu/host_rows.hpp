// SPDX-License-Identifier: MIT
#pragma once

#include "gpu/compute.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace demo {

/// The host's answers about some pixels of a batch: a row of S of all lights for each of them. Shaders see
/// them by host_rows.glsl.
class HostRows {
public:
    /// For batches of up to so many pixels.
    HostRows(const ComputeDevice& device, std::size_t pixels)
        : device_(device), row_of_pixel_(pixels), rows_(device, pixels * sizeof(std::uint32_t)),
          answers_(device, std::size_t{16}) {}

    /// Forgets all rows: the pixels have other points now.
    void clear() {
        if (values_.empty())
            return;
        values_.clear();
        std::ranges::fill(row_of_pixel_, 0u);
        rows_.write(0, std::as_bytes(std::span(row_of_pixel_)));
    }

    /// Adds rows for pixels that have none, of which find(values) writes all. Then the buffers are others.
    template <class Find>
    void add(std::span<const std::uint32_t> pixels, std::size_t lights, Find&& find) {
        const std::size_t first_row = lights == 0 ? 0 : values_.size() / lights;
        values_.resize((first_row + pixels.size()) * lights);
        find(std::span(values_).subspan(first_row * lights));
        for (std::size_t i = 0; i < pixels.size(); ++i)
            row_of_pixel_[pixels[i]] = static_cast<std::uint32_t>(first_row + i + 1);
        rows_.write(0, std::as_bytes(std::span(row_of_pixel_)));
        answers_ = ComputeBuffer(device_, std::as_bytes(std::span(values_)));
    }

    /// The two bindings from `first` on.
    std::vector<ComputeBinding> bindings(std::uint32_t set, std::uint32_t first) const {
        return {{.set = set, .binding = first, .resource = rows_},
                {.set = set, .binding = first + 1, .resource = answers_}};
    }

private:
    ComputeDevice device_;
    std::vector<std::uint32_t> row_of_pixel_;  ///< plus one; 0: none
    ComputeBuffer rows_;
    std::vector<float> values_;
    ComputeBuffer answers_;
};

}  // namespace demo
