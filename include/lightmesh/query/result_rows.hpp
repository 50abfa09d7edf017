// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/mesh/level.hpp>
#include <lightmesh/mesh/light_table.hpp>
#include <lightmesh/query/query_point.hpp>

#include <algorithm>
#include <cstddef>
#include <span>

namespace lightmesh::detail {

/// The result of a query of many points: a row of all lights at each. Values come a tile at a time.
class ResultRows {
public:
    /// Without `all` nothing can be written but `fill`, which does nothing.
    explicit ResultRows(const LightTable& lights, std::span<float> all = {}) : lights_(&lights), all_(all) {}

    /// Sets all of a point's row.
    void fill(const QueryPoint& point, float value) const {
        if (!all_.empty())
            std::ranges::fill(row(point), value);
    }

    /// Whether all of a point's row is set to 0 at once, before its tiles are given: where the values of a
    /// tile stand apart in it, one by one would take longer, and of thousands of lights with ranges few tiles
    /// reach.
    bool begins_with_zeros(const QueryPoint& point) const {
        return point.share == 1.0f && !lights_->order().is_given();
    }

    /// Where the values of a tile's 64 slots stand side by side in the point's row; null if they do not.
    float* whole_tile_of(const QueryPoint& point, std::size_t tile) const {
        const bool is_whole = point.share == 1.0f && lights_->order().is_given() &&
                              (tile + 1) * lights_per_tile <= lights_->size();
        return is_whole ? row(point).data() + tile * lights_per_tile : nullptr;
    }

    /// Writes the values of a tile to the point's row; null: all 0.
    void give(const QueryPoint& point, std::size_t tile, const float* values) const {
        const std::span<float> result = row(point);
        const std::size_t first = tile * lights_per_tile;
        const auto size = static_cast<std::size_t>(lights_->tile_size(tile));
        if (point.share != 1.0f) {
            for (std::size_t l = 0; l < size; ++l) {
                float& value = result[lights_->order().light_at(first + l)];
                value = blended(value, values != nullptr ? values[l] : 0.0f, point.share);
            }
            return;
        }
        if (lights_->order().is_given()) {
            if (values != nullptr)
                std::copy_n(values, size, result.data() + first);
            else
                std::fill_n(result.data() + first, size, 0.0f);
            return;
        }
        if (values == nullptr)
            return;
        for (std::size_t l = 0; l < size; ++l)
            result[lights_->order().light_at(first + l)] = values[l];
    }

private:
    std::span<float> row(const QueryPoint& point) const {
        return all_.subspan(point.row * lights_->size(), lights_->size());
    }

    const LightTable* lights_;
    std::span<float> all_;
};

}  // namespace lightmesh::detail
