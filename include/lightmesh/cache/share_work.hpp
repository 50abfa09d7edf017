// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/cache/lamp_pattern.hpp>
#include <lightmesh/cache/lamp_rows.hpp>
#include <lightmesh/cache/lamp_table.hpp>
#include <lightmesh/cache/lamp_words.hpp>
#include <lightmesh/cache/row.hpp>
#include <lightmesh/fill/ray_ends.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace lightmesh::detail {

/// The work that shaders are asked to do: shares of lamps, laid out for lamp_shares.glsl. The lights must not
/// change meanwhile.
class ShareWork {
public:
    ShareWork(const LampTable& lamps, double reach) {
        const auto reach_words = double_words(reach);
        words_ = {{0, first_lamp, 0, 0}, {reach_words[0], reach_words[1], 0, 0}};
        for (std::size_t i = 0; i < disc_points.size(); i += 4)
            words_.push_back({disc_word(i), disc_word(i + 1), disc_word(i + 2), disc_word(i + 3)});
        for (std::uint32_t i = 0; i < 1024; ++i)
            words_.push_back(turn_words(i));
        for (std::size_t i = 0; i < lamps.size(); ++i) {
            const LampWords lamp = detail::words_of(lamps.lamp(i), reach);
            for (std::size_t k = 0; k < lamp.size(); k += 4)
                words_.push_back({lamp[k], lamp[k + 1], lamp[k + 2], lamp[k + 3]});
        }
        rows_begin_ = words_.size();
    }

    /// Shares of some lights of a tile, in the order of these, all seen from one row.
    void add(const RowLook& look, std::size_t tile, std::uint64_t lights) {
        const auto row = static_cast<std::uint32_t>(words_.size());
        const RowOrigin& origin = look.origin;
        const float least_end = end_offset(glm::vec3(0.0f), static_cast<float>(origin.step));
        words_.push_back(words_of(origin.position, static_cast<std::uint32_t>(origin.seed >> 32)));
        words_.push_back(words_of(origin.unit_normal, float_word(least_end)));
        const auto number = [](std::size_t value) {
            return static_cast<std::uint32_t>(value);
        };
        words_.push_back(
            {number(static_cast<std::size_t>(look.around)) | (look.plan.has_rim ? 4u : 0u),
             number(look.plan.first), number(look.plan.most),
             number(look.place_count) | number(look.rays_of_place) << 8 | number(look.parts_apart) << 16});
        for (std::size_t i = 0; i < look.place_count; ++i) {
            const bool is_own = look.places[i].position == origin.position &&
                                look.places[i].unit_normal == origin.unit_normal;
            words_.push_back(words_of(look.places[i].position, look.part[i] | (is_own ? 256u : 0u)));
            words_.push_back(words_of(look.places[i].unit_normal, 0));
        }
        for (std::uint64_t rest = lights; rest != 0; rest &= rest - 1)
            shares_.push_back(
                {row, number(tile * lamps_per_tile + static_cast<std::size_t>(std::countr_zero(rest)))});
    }

    std::size_t share_count() const { return shares_.size(); }
    /// Bytes of rows.
    std::size_t size() const { return (words_.size() - rows_begin_) * sizeof(Words); }

    /// The bytes that shaders read.
    std::span<const std::byte> finish() {
        words_[0][0] = static_cast<std::uint32_t>(shares_.size());
        words_[0][2] = static_cast<std::uint32_t>(words_.size());
        for (std::size_t i = 0; i < shares_.size(); i += 2) {
            const auto& last = shares_[(std::min)(i + 1, shares_.size() - 1)];
            words_.push_back({shares_[i][0], shares_[i][1], last[0], last[1]});
        }
        return std::as_bytes(std::span(words_));
    }
    /// No shares again.
    void clear() {
        words_.resize(rows_begin_);
        shares_.clear();
    }

private:
    using Words = std::array<std::uint32_t, 4>;

    static constexpr std::uint32_t first_lamp = 2 + most_pattern_points / 4 + 1024;

    static Words words_of(const glm::vec3& vector, std::uint32_t word) {
        return {float_word(vector.x), float_word(vector.y), float_word(vector.z), word};
    }

    std::vector<Words> words_;
    std::size_t rows_begin_ = 0;
    std::vector<std::array<std::uint32_t, 2>> shares_;
};

}  // namespace lightmesh::detail
