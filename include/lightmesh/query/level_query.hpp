// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/fill/unit_table.hpp>
#include <lightmesh/mesh/level.hpp>
#include <lightmesh/query/block_query.hpp>
#include <lightmesh/query/point_query.hpp>
#include <lightmesh/query/query_point.hpp>
#include <lightmesh/statistics.hpp>
#include <lightmesh/surface_point.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

/// Queries of points with footprints: each asks one level of a mesh, or the two that it lies between.

namespace lightmesh::detail {

/// S of one light at one point.
template <class Levels>
float query_one(const Levels& levels, const SurfacePoint& point, std::size_t light,
                QueryStatistics* statistics) {
    const LevelChoice choice = levels.rule()(point.footprint);
    const auto ask = [&](int level) {
        return query_one(levels.level(level), point.position, point.normal, light, statistics);
    };
    const float fine = ask(choice.level);
    return choice.is_between() ? blended(fine, ask(choice.level + 1), choice.coarser_share) : fine;
}

/// S of all lights for a block of points. Its memory is on the stack.
template <class Levels>
class LevelQuery {
public:
    static constexpr std::size_t most_points = 256;

    LevelQuery(const Levels& levels, QueryStatistics* statistics)
        : levels_(levels), statistics_(statistics) {}

    /// As `LightMesh::visibility` for up to `most_points` points.
    void run(std::span<const SurfacePoint> points, std::span<float> all) {
        for_each_level(points, [&](int k, const PointBatch& batch) {
            BlockQuery(levels_.level(k), statistics_).run(batch, all);
        });
    }

    /// As `BlockQuery::fill`, for as many points.
    void fill(std::span<const SurfacePoint> points) {
        for_each_level(points, [&](int k, const PointBatch& batch) {
            BlockQuery(levels_.level(k), statistics_).fill(batch);
        });
    }

    /// As `BlockQuery::list`, for as many points; `units` are those of each level.
    void list(std::span<const SurfacePoint> points, std::vector<UnitTable>& units) {
        for_each_level(points, [&](int k, const PointBatch& batch) {
            BlockQuery(levels_.level(k), statistics_).list(batch, of_level(units, k));
        });
    }
    /// As `BlockQuery::list_links`, so too.
    void list_links(std::span<const SurfacePoint> points, std::vector<UnitTable>& cells) {
        for_each_level(points, [&](int k, const PointBatch& batch) {
            BlockQuery(levels_.level(k), statistics_).list_links(batch, of_level(cells, k));
        });
    }

private:
    static UnitTable& of_level(std::vector<UnitTable>& levels, int k) {
        const auto level = static_cast<std::size_t>(k);
        if (levels.size() <= level)
            levels.resize(level + 1);
        return levels[level];
    }

    /// Calls ask(k, batch) for the levels that serve any of the points, the finest first, so that a
    /// point's row has the finer level's values when those of the coarser are blended in.
    template <class Ask>
    void for_each_level(std::span<const SurfacePoint> points, Ask&& ask) {
        int first = levels_.rule().coarsest();
        int last = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            choices_[i] = levels_.rule()(points[i].footprint);
            first = (std::min)(first, choices_[i].level);
            last = (std::max)(last, choices_[i].level + (choices_[i].is_between() ? 1 : 0));
        }
        for (int k = first; k <= last; ++k) {
            size_ = 0;
            for (std::size_t i = 0; i < points.size(); ++i) {
                if (choices_[i].level == k)
                    add(points[i], i, 1.0f);
                else if (choices_[i].level + 1 == k && choices_[i].is_between())
                    add(points[i], i, choices_[i].coarser_share);
            }
            if (size_ != 0)
                ask(k, PointBatch{std::span<const glm::vec3>(positions_).first(size_),
                                  std::span<const glm::vec3>(normals_).first(size_),
                                  std::span<const std::uint32_t>(rows_).first(size_),
                                  std::span<const float>(shares_).first(size_)});
        }
    }

    void add(const SurfacePoint& point, std::size_t row, float share) {
        positions_[size_] = point.position;
        normals_[size_] = point.normal;
        rows_[size_] = static_cast<std::uint32_t>(row);
        shares_[size_++] = share;
    }

    const Levels& levels_;
    QueryStatistics* statistics_;
    std::size_t size_ = 0;
    std::array<LevelChoice, most_points> choices_;
    std::array<glm::vec3, most_points> positions_;
    std::array<glm::vec3, most_points> normals_;
    std::array<std::uint32_t, most_points> rows_;
    std::array<float, most_points> shares_;
};

}  // namespace lightmesh::detail
