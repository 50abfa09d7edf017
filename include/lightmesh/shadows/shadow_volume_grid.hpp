// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/adapters/occluders.hpp>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

/// The shadow volumes of triangles as a light sees them: a grid of lists over a quarter of a turn
/// in both directions, or over the scene for parallel light. In double throughout: a volume of a far triangle
/// is thin.

namespace lightmesh::detail {

/// A point as a light sees it: at (x / w, y / w) of a square from -1 to 1, and at a depth.
struct SeenPoint {
    glm::dvec3 xyw{0.0};
    double depth = 0.0;
};

/// The square: perspective from the eye through a face of a cube (w = depth), or parallel (w = 1).
struct LightFrame {
    glm::dvec3 eye{0.0};
    glm::dvec3 right{1.0, 0.0, 0.0};
    glm::dvec3 down{0.0, 1.0, 0.0};
    glm::dvec3 forward{0.0, 0.0, 1.0};
    bool parallel = false;

    bool operator==(const LightFrame&) const = default;

    SeenPoint see(const glm::vec3& point) const {
        const glm::dvec3 to_point = glm::dvec3(point) - eye;
        const double depth = glm::dot(forward, to_point);
        return {{glm::dot(right, to_point), glm::dot(down, to_point), parallel ? 1.0 : depth}, depth};
    }
};

using SeenTriangle = std::array<SeenPoint, 3>;

inline double determinant(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    return glm::dot(a, glm::cross(b, c));
}

/// True if a point lies in the shadow volume of a triangle: within the pyramid (or prism) from the light
/// through its edges, and beyond it. What the way to the point meets within `clearance` of its length from
/// the light does not count.
inline bool in_shadow_volume(const SeenPoint& point, const SeenTriangle& triangle, bool parallel,
                             double clearance) {
    const auto& [a, b, c] = triangle;
    const double whole = determinant(a.xyw, b.xyw, c.xyw);
    const double side = whole < 0.0 ? -1.0 : 1.0;
    const double of_a = side * determinant(point.xyw, b.xyw, c.xyw);
    const double of_b = side * determinant(point.xyw, c.xyw, a.xyw);
    const double of_c = side * determinant(point.xyw, a.xyw, b.xyw);
    if (of_a < 0.0 || of_b < 0.0 || of_c < 0.0 || whole == 0.0)
        return false;
    const double size = side * whole;
    if (parallel)
        return of_a * a.depth + of_b * b.depth + of_c * c.depth < size * point.depth;
    const double sum = of_a + of_b + of_c;  // the way meets the triangle at size / sum of its length
    return size < sum && size > clearance * sum;
}

/// The part of a triangle within the square: a convex polygon.
class ClippedTriangle {
public:
    explicit ClippedTriangle(const SeenTriangle& triangle) {
        if (outside(triangle))
            return;
        for (const SeenPoint& corner : triangle)
            corners_[count_++] = corner;
        for (int axis = 0; axis < 2; ++axis) {
            clip([axis](const SeenPoint& p) { return p.xyw.z - p.xyw[axis]; });
            clip([axis](const SeenPoint& p) { return p.xyw.z + p.xyw[axis]; });
        }
    }

    bool empty() const { return count_ == 0; }
    std::size_t size() const { return count_; }
    const SeenPoint& operator[](std::size_t i) const { return corners_[i % count_]; }

    double nearest_depth() const {
        double nearest = std::numeric_limits<double>::infinity();
        for (std::size_t i = 0; i < count_; ++i)
            nearest = (std::min)(nearest, corners_[i].depth);
        return nearest;
    }

private:
    /// All corners beyond one side of the square: most triangles.
    static bool outside(const SeenTriangle& triangle) {
        const auto all = [&](auto&& beyond) {
            return beyond(triangle[0].xyw) && beyond(triangle[1].xyw) && beyond(triangle[2].xyw);
        };
        return all([](const glm::dvec3& p) { return p.x > p.z; }) ||
               all([](const glm::dvec3& p) { return -p.x > p.z; }) ||
               all([](const glm::dvec3& p) { return p.y > p.z; }) ||
               all([](const glm::dvec3& p) { return -p.y > p.z; });
    }

    /// Keeps where inside(point) >= 0 (Sutherland and Hodgman 1974).
    template <class Inside>
    void clip(Inside&& inside) {
        std::array<SeenPoint, 8> kept;
        std::size_t kept_count = 0;
        for (std::size_t i = 0; i < count_; ++i) {
            const SeenPoint& here = corners_[i];
            const SeenPoint& next = corners_[(i + 1) % count_];
            const double at_here = inside(here);
            const double at_next = inside(next);
            if (at_here >= 0.0)
                kept[kept_count++] = here;
            if ((at_here >= 0.0) == (at_next >= 0.0))
                continue;
            const double t = at_here / (at_here - at_next);
            kept[kept_count++] = {here.xyw + t * (next.xyw - here.xyw),
                                  here.depth + t * (next.depth - here.depth)};
        }
        corners_ = kept;
        count_ = kept_count;
    }

    std::array<SeenPoint, 8> corners_{};
    std::size_t count_ = 0;
};

/// The triangles whose shadow volumes reach each cell of the square, nearest first.
class ShadowVolumeGrid {
public:
    ShadowVolumeGrid(const OccluderTriangles& triangles, const LightFrame& frame, int side)
        : frame_(frame), side_(side),
          begins_(static_cast<std::size_t>(side) * static_cast<std::size_t>(side) + 1) {
        std::vector<Placed> placed;
        for (std::size_t i = 0; i < triangles.size(); ++i)
            place(seen(triangles[i]), static_cast<std::uint32_t>(i), placed);
        fill(placed);
    }

    /// Is a point within the square in any shadow volume?
    bool dark(const OccluderTriangles& triangles, const SeenPoint& point, double clearance) const {
        const std::size_t cell = cell_of(point);
        for (std::size_t i = begins_[cell]; i < begins_[cell + 1]; ++i) {
            if (static_cast<double>(entries_[i].nearest) > point.depth)
                return false;
            if (in_shadow_volume(point, seen(triangles[entries_[i].triangle]), frame_.parallel, clearance))
                return true;
        }
        return false;
    }

    /// True if the grid of a frame may hold a triangle.
    static bool may_hold(const LightFrame& frame, const OccluderTriangles::Triangle& triangle) {
        return !ClippedTriangle(seen(frame, triangle)).empty();
    }

    std::size_t bytes() const {
        return sizeof *this + begins_.capacity() * sizeof(std::uint64_t) +
               entries_.capacity() * sizeof(Entry);
    }

private:
    struct Entry {
        float nearest;  ///< depth, or a little less
        std::uint32_t triangle;
    };
    struct Placed {
        std::size_t cell;
        Entry entry;
    };

    static SeenTriangle seen(const LightFrame& frame, const OccluderTriangles::Triangle& triangle) {
        return {frame.see(triangle[0]), frame.see(triangle[1]), frame.see(triangle[2])};
    }
    SeenTriangle seen(const OccluderTriangles::Triangle& triangle) const { return seen(frame_, triangle); }

    /// 0 to `side_` for -1 to 1.
    double to_cells(double coordinate) const { return (coordinate + 1.0) * 0.5 * side_; }
    int whole(double cells) const { return static_cast<int>(std::clamp(cells, 0.0, side_ - 0.5)); }

    std::size_t cell_of(const SeenPoint& point) const {
        const double w = point.xyw.z;
        const int column = w > 0.0 ? whole(to_cells(point.xyw.x / w)) : 0;
        const int row = w > 0.0 ? whole(to_cells(point.xyw.y / w)) : 0;
        return index(column, row);
    }
    std::size_t index(int column, int row) const {
        return static_cast<std::size_t>(row) * static_cast<std::size_t>(side_) +
               static_cast<std::size_t>(column);
    }

    /// Adds a triangle to the cells that it touches, row by row.
    void place(const SeenTriangle& triangle, std::uint32_t number, std::vector<Placed>& placed) const {
        const ClippedTriangle polygon(triangle);
        if (polygon.empty())
            return;
        const auto& [a, b, c] = triangle;
        if (determinant(a.xyw, b.xyw, c.xyw) == 0.0)
            return;  // seen from its edge
        const auto nearest = static_cast<float>(polygon.nearest_depth());
        const Entry entry{nearest - 1e-6f * std::abs(nearest), number};

        std::array<double, 8> x{};
        std::array<double, 8> y{};
        for (std::size_t i = 0; i < polygon.size(); ++i) {
            const glm::dvec3& corner = polygon[i].xyw;
            x[i] = to_cells(corner.z > 0.0 ? corner.x / corner.z : 0.0);
            y[i] = to_cells(corner.z > 0.0 ? corner.y / corner.z : 0.0);
        }
        const std::span<const double> columns(x.data(), polygon.size());
        const std::span<const double> rows(y.data(), polygon.size());
        const auto [top, bottom] = std::ranges::minmax(rows);
        for (int row = whole(top - slack); row <= whole(bottom + slack); ++row) {
            const auto [left, right] = extent(columns, rows, row - slack, row + 1 + slack);
            for (int column = whole(left - slack); column <= whole(right + slack); ++column)
                placed.push_back({index(column, row), entry});
        }
    }

    /// From where to where a convex polygon reaches between two rows.
    static std::pair<double, double> extent(std::span<const double> x, std::span<const double> y, double top,
                                            double bottom) {
        double left = std::numeric_limits<double>::infinity();
        double right = -left;
        const auto include = [&](double at) {
            left = (std::min)(left, at);
            right = (std::max)(right, at);
        };
        for (std::size_t i = 0; i < x.size(); ++i) {
            const std::size_t next = (i + 1) % x.size();
            if (y[i] >= top && y[i] <= bottom)
                include(x[i]);
            for (const double line : {top, bottom})
                if ((y[i] < line) != (y[next] < line))
                    include(x[i] + (x[next] - x[i]) * ((line - y[i]) / (y[next] - y[i])));
        }
        return {left, right};
    }

    void fill(const std::vector<Placed>& placed) {
        for (const Placed& p : placed)
            ++begins_[p.cell + 1];
        for (std::size_t i = 1; i < begins_.size(); ++i)
            begins_[i] += begins_[i - 1];
        entries_.resize(placed.size());
        std::vector<std::uint64_t> next(begins_.begin(), begins_.end() - 1);
        for (const Placed& p : placed)
            entries_[next[p.cell]++] = p.entry;
        for (std::size_t cell = 0; cell + 1 < begins_.size(); ++cell)
            std::sort(entries_.begin() + static_cast<std::ptrdiff_t>(begins_[cell]),
                      entries_.begin() + static_cast<std::ptrdiff_t>(begins_[cell + 1]),
                      [](const Entry& a, const Entry& b) { return a.nearest < b.nearest; });
    }

    static constexpr double slack = 1e-6;  // cells: far more than what doubles lose on the way

    LightFrame frame_;
    int side_;
    std::vector<std::uint64_t> begins_;  // of each cell's entries, and the end
    std::vector<Entry> entries_;
};

}  // namespace lightmesh::detail
