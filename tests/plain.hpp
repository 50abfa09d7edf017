// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/lights.hpp>
#include <lightmesh/segment.hpp>
#include <lightmesh/settings.hpp>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <glm/vector_relational.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <set>
#include <utility>
#include <variant>
#include <vector>

/// Equations (2) and (3) written down plainly: no bricks, no cache, no masks, all in double, every triangle
/// tested by every segment. What the library computes is held against this.
///
/// The library rounds, so some answers may fairly go either way: a light point very near to the sphere or the
/// tangent plane of (2), a segment that grazes an edge. Every question therefore has three answers, and every
/// visibility is an interval: of all the values that fair answers can give. Where nothing is unsure it is a
/// single value.

namespace test {

using Vec = glm::dvec3;

using lightmesh::ShortTest;
inline constexpr std::array all_short_tests{ShortTest::exact, ShortTest::linked, ShortTest::none};

struct Triangle {
    Vec a, b, c;
};

enum class Answer { no, unsure, yes };

inline Answer both(Answer a, Answer b) {
    return (std::min)(a, b);
}

inline double largest_coordinate(const Vec& v) {
    return (std::max)({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

/// `value > limit`, unsure within `band` of it.
inline Answer greater(double value, double limit, double band) {
    if (value > limit + band)
        return Answer::yes;
    return value < limit - band ? Answer::no : Answer::unsure;
}

/// Does the triangle lie strictly between the two ends? Moeller and Trumbore, "Fast, Minimum Storage
/// Ray/Triangle Intersection" (1997).
inline bool crosses(const Vec& origin, const Vec& target, const Triangle& triangle) {
    const Vec way = target - origin;
    const Vec edge_1 = triangle.b - triangle.a;
    const Vec edge_2 = triangle.c - triangle.a;
    const Vec p = glm::cross(way, edge_2);
    const double determinant = glm::dot(edge_1, p);
    if (determinant == 0.0)
        return false;
    const Vec s = origin - triangle.a;
    const double u = glm::dot(s, p) / determinant;
    if (u < 0.0 || u > 1.0)
        return false;
    const Vec q = glm::cross(s, edge_1);
    const double v = glm::dot(way, q) / determinant;
    if (v < 0.0 || u + v > 1.0)
        return false;
    const double t = glm::dot(edge_2, q) / determinant;
    return t > 0.0 && t < 1.0;
}

inline bool blocked(const Vec& origin, const Vec& target, const std::vector<Triangle>& triangles) {
    return std::any_of(triangles.begin(), triangles.end(),
                       [&](const Triangle& triangle) { return crosses(origin, target, triangle); });
}

/// Distance between two straight pieces: the least over both parameters, found by clamping one after the
/// other.
inline double distance(const Vec& a, const Vec& b, const Vec& c, const Vec& d) {
    const Vec ab = b - a;
    const Vec cd = d - c;
    const Vec ca = a - c;
    const double ab_ab = glm::dot(ab, ab);
    const double ab_cd = glm::dot(ab, cd);
    const double cd_cd = glm::dot(cd, cd);
    const double determinant = ab_ab * cd_cd - ab_cd * ab_cd;
    double s = 0.0;
    if (determinant > 0.0)
        s = std::clamp((ab_cd * glm::dot(cd, ca) - glm::dot(ab, ca) * cd_cd) / determinant, 0.0, 1.0);
    const double t = cd_cd > 0.0 ? std::clamp((ab_cd * s + glm::dot(cd, ca)) / cd_cd, 0.0, 1.0) : 0.0;
    if (ab_ab > 0.0)
        s = std::clamp((ab_cd * t - glm::dot(ab, ca)) / ab_ab, 0.0, 1.0);
    return glm::distance(a + s * ab, c + t * cd);
}

/// Can the answer for this triangle change when both ends move by up to `band`? Only if the segment comes
/// that near to an edge, or one of its ends to the triangle.
inline bool grazes(const Vec& origin, const Vec& target, const Triangle& triangle, double band) {
    const auto& [a, b, c] = triangle;
    const Vec normal = glm::cross(b - a, c - a);
    const double size = glm::length(normal);
    if (size == 0.0)
        return false;
    const double from = glm::dot(origin - a, normal) / size;
    const double to = glm::dot(target - a, normal) / size;
    if ((from > band && to > band) || (from < -band && to < -band))
        return false;
    if (distance(origin, target, a, b) <= band || distance(origin, target, b, c) <= band ||
        distance(origin, target, c, a) <= band)
        return true;
    const Vec step = normal / size * (2.0 * band);
    return (std::abs(from) <= band && crosses(origin - step, origin + step, triangle)) ||
           (std::abs(to) <= band && crosses(target - step, target + step, triangle));
}

/// V of two points.
inline Answer sees(const Vec& origin, const Vec& target, const std::vector<Triangle>& triangles,
                   double band) {
    Answer answer = Answer::yes;
    for (const Triangle& triangle : triangles) {
        if (grazes(origin, target, triangle, band))
            answer = both(answer, Answer::unsure);
        else if (crosses(origin, target, triangle))
            return Answer::no;
    }
    return answer;
}

/// All that S_i(P) can fairly be.
struct Interval {
    double low = 0.0;
    double high = 0.0;

    bool is_sure() const { return low == high; }
    bool contains(float value) const {
        constexpr double rounding = 1e-6;
        return static_cast<double>(value) >= low - rounding && static_cast<double>(value) <= high + rounding;
    }
};

/// A light point that may belong to D(P, r).
struct Neighbour {
    Vec position;
    Answer belongs = Answer::yes;
};

class PlainMesh {
public:
    /// `origin` and `step` of the grid are the library's own.
    PlainMesh(std::vector<Triangle> triangles, std::vector<lightmesh::Light> lights, const Vec& origin,
              double step, double quality, ShortTest short_test)
        : triangles_(std::move(triangles)), lights_(std::move(lights)), origin_(origin), step_(step),
          quality_(quality), short_test_(short_test) {
        for (const Triangle& t : triangles_)
            for (const Vec& corner : {t.a, t.b, t.c})
                extent_ = (std::max)(extent_, largest_coordinate(corner));
        // Ends are floats: 2^-24 of a coordinate each, and some steps of computation.
        segment_band_ = 0x1p-20 * (extent_ + quality_ * step_);
    }

    /// D(P, r) of equation (2), and what may belong to it.
    std::vector<Neighbour> neighbours(const Vec& point, const Vec& normal) const {
        std::vector<Neighbour> found = hemisphere(point, normal);
        if (found.empty() || short_test_ == ShortTest::none)
            return found;
        const Vec n = glm::normalize(normal);
        if (short_test_ == ShortTest::linked)
            return linked(point, n, std::move(found));
        const Vec end = surface_end(point, n);
        for (Neighbour& x : found)
            x.belongs = both(x.belongs, sees(end, x.position, triangles_, segment_band_));
        std::erase_if(found, [](const Neighbour& x) { return x.belongs == Answer::no; });
        return found;
    }

    /// S_i(P) of equation (3), for the `neighbours` of the same point and normal.
    Interval visibility(const Vec& point, const Vec& normal, const std::vector<Neighbour>& neighbours,
                        std::size_t light) const {
        const Vec n = normal == Vec(0.0) ? normal : glm::normalize(normal);
        const Answer lit = reaches(light, point, n);
        if (lit == Answer::no)
            return {0.0, 0.0};
        Interval s = average(neighbours, light);
        if (std::none_of(neighbours.begin(), neighbours.end(),
                         [](const Neighbour& x) { return x.belongs == Answer::yes; })) {
            // m may be 0: the exact shadow ray.
            const Answer v = light_reaches(light, surface_end(point, n));
            s.low = (std::min)(s.low, v == Answer::yes ? 1.0 : 0.0);
            s.high = (std::max)(s.high, v == Answer::no ? 0.0 : 1.0);
        }
        if (lit == Answer::unsure)
            s.low = 0.0;
        return s;
    }

    Interval visibility(const Vec& point, const Vec& normal, std::size_t light) const {
        return visibility(point, normal, neighbours(point, normal), light);
    }

private:
    /// D(P, r) without its short test.
    std::vector<Neighbour> hemisphere(const Vec& point, const Vec& normal) const {
        std::vector<Neighbour> found;
        if (normal == Vec(0.0))
            return found;
        const Vec n = glm::normalize(normal);
        const double radius = quality_ * step_;
        // The library's positions are fixed-point numbers: half a unit of rounding in each axis.
        const double unit = step_ * (quality_ <= 8.0 ? 0x1p-11 : 0x1p-10);
        const double sphere_band = 0.51 * unit * std::sqrt(3.0);
        // A light point must lie this far above the tangent plane; normals are rounded too, to 2^-15.
        const double lowest = 2.0 * unit + largest_coordinate(point) * 0x1p-22;
        const double plane_band = sphere_band + radius * 0x1p-15;
        const Vec first = glm::floor((point - origin_) / step_ - quality_);
        const int count = 2 * static_cast<int>(std::ceil(quality_)) + 3;
        for (int k = 0; k < count; ++k) {
            for (int j = 0; j < count; ++j) {
                for (int i = 0; i < count; ++i) {
                    const Vec x = origin_ + step_ * (first + Vec(i, j, k));
                    const Answer belongs = both(greater(radius, glm::distance(x, point), sphere_band),
                                                greater(glm::dot(n, x - point), lowest, plane_band));
                    if (belongs != Answer::no)
                        found.push_back({x, belongs});
                }
            }
        }
        return found;
    }

    /// The linked short test: light points next to P that P sees, seeds, one after the other until two thirds
    /// of D can be reached from them over open links, each step leading away from its seed; those that are
    /// reached already are no seeds. Then some of all D until a quarter can be reached, and all D until P
    /// sees one. Links play no part farther than q + 1 steps from a seed, and what lies there is doubtful.
    /// One doubt about a seed, a link, or the share makes all light points doubtful.
    std::vector<Neighbour> linked(const Vec& point, const Vec& n, std::vector<Neighbour> inside) const {
        std::vector<Neighbour> doubtful = inside;
        for (Neighbour& x : doubtful)
            x.belongs = Answer::unsure;
        for (const Neighbour& x : inside)
            if (x.belongs == Answer::unsure)
                return doubtful;
        const std::optional<std::vector<Index>> seeds = seeds_of(point, n, inside);
        if (!seeds)
            return doubtful;

        std::vector<Index> candidates = *seeds;
        for (const Index& seed : far_seeds_of(inside))
            candidates.push_back(seed);

        std::vector<Answer> reached(inside.size(), Answer::no);
        std::size_t least = 0;
        std::size_t most = 0;
        for (std::size_t tried = 0; tried < candidates.size(); ++tried) {
            const Index& seed = candidates[tried];
            // Far ones, where those before reach less than a quarter.
            if (tried >= seeds->size()) {
                if (4 * least >= inside.size() || (tried >= seeds->size() + 12 && least > 0))
                    break;
                if (4 * most >= inside.size())
                    return doubtful;
            }
            const auto itself = static_cast<std::size_t>(
                std::ranges::find(inside, seed, [&](const Neighbour& x) { return index_of(x.position); }) -
                inside.begin());
            if (reached[itself] == Answer::unsure)
                return doubtful;
            if (reached[itself] == Answer::yes)
                continue;
            const Answer sees_seed =
                sees(surface_end(point, n), position_of(seed), triangles_, segment_band_);
            if (sees_seed == Answer::unsure)
                return doubtful;
            if (sees_seed == Answer::no)
                continue;
            const std::optional<std::set<Index>> from_seed = reach_of(seed);
            if (!from_seed)
                return doubtful;
            least = 0;
            most = 0;
            for (std::size_t i = 0; i < inside.size(); ++i) {
                const Index index = index_of(inside[i].position);
                if (from_seed->contains(index))
                    reached[i] = Answer::yes;
                else if (!is_near(index, seed) && reached[i] == Answer::no)
                    reached[i] = Answer::unsure;
                least += reached[i] == Answer::yes;
                most += reached[i] != Answer::no;
            }
            if (3 * least >= 2 * inside.size())
                break;
            if (3 * most >= 2 * inside.size())
                return doubtful;
        }
        std::vector<Neighbour> found;
        for (std::size_t i = 0; i < inside.size(); ++i)
            if (reached[i] != Answer::no)
                found.push_back({inside[i].position, reached[i]});
        return found;
    }

    using Index = std::array<int, 3>;

    Index index_of(const Vec& x) const {
        const Vec steps = glm::round((x - origin_) / step_);
        return {static_cast<int>(steps.x), static_cast<int>(steps.y), static_cast<int>(steps.z)};
    }

    Vec position_of(const Index& index) const { return origin_ + step_ * Vec(index[0], index[1], index[2]); }

    /// Whether a light point lies within q + 1 steps from a seed.
    bool is_near(const Index& index, const Index& seed) const {
        double square = 0.0;
        for (std::size_t axis = 0; axis < 3; ++axis)
            square += std::pow(index[axis] - seed[axis], 2);
        return square <= std::pow(quality_ + 1.0, 2);
    }

    /// All light points that the seed reaches; nothing if a link is in doubt.
    std::optional<std::set<Index>> reach_of(const Index& seed) const {
        std::set<Index> reached{seed};
        std::vector<Index> waiting{seed};
        while (!waiting.empty()) {
            const Index from = waiting.back();
            waiting.pop_back();
            for (std::size_t axis = 0; axis < 3; ++axis) {
                for (const int way : {-1, 1}) {
                    Index to = from;
                    to[axis] += way;
                    const bool leads_away = (from[axis] - seed[axis]) * way >= 0;
                    if (!leads_away || !is_near(to, seed) || reached.contains(to))
                        continue;
                    const Answer link = sees(position_of(from), position_of(to), triangles_, segment_band_);
                    if (link == Answer::unsure)
                        return std::nullopt;
                    if (link == Answer::yes) {
                        reached.insert(to);
                        waiting.push_back(to);
                    }
                }
            }
        }
        return reached;
    }

    /// The corners of the grid cube just above P's tangent plane that belong to the hemisphere: even ones
    /// first, near ones before far ones; nothing if that is in doubt.
    std::optional<std::vector<Index>> seeds_of(const Vec& point, const Vec& n,
                                               const std::vector<Neighbour>& inside) const {
        const Vec above = point + step_ * seed_height(point) * n;
        const Vec in_steps = (above - origin_) / step_;
        const auto to_plane = glm::abs(in_steps - glm::round(in_steps));
        if ((std::min)({to_plane.x, to_plane.y, to_plane.z}) < 1e-6)
            return std::nullopt;  // Which cube?

        std::vector<std::size_t> around;
        for (std::size_t i = 0; i < inside.size(); ++i)
            if (glm::all(glm::lessThan(glm::abs(inside[i].position - above), Vec(step_))))
                around.push_back(i);
        const auto rank = [&](std::size_t i) {
            const Index index = index_of(inside[i].position);
            const bool is_odd = (index[0] + index[1] + index[2]) % 2 != 0;
            return glm::distance(inside[i].position, above) + (is_odd ? 10.0 * step_ : 0.0);
        };
        std::sort(around.begin(), around.end(),
                  [&](std::size_t a, std::size_t b) { return rank(a) < rank(b); });
        std::vector<Index> seeds;
        for (std::size_t i = 0; i < around.size(); ++i) {
            if (i + 1 < around.size() && rank(around[i + 1]) - rank(around[i]) < 4e-3 * step_)
                return std::nullopt;
            seeds.push_back(index_of(inside[around[i]].position));
        }
        return seeds;
    }

    /// Twelve of D, evenly, and then all, in the library's order: bricks of 4x4x4 along x, then y, then z, in
    /// them cells of 2x2x2, in these light points.
    std::vector<Index> far_seeds_of(const std::vector<Neighbour>& inside) const {
        if (inside.empty())
            return {};
        std::vector<std::pair<std::array<int, 9>, Index>> order;
        for (const Neighbour& x : inside) {
            const Index index = index_of(x.position);
            std::array<int, 9> key;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                key[2 - axis] = index[axis] >> 2;
                key[5 - axis] = index[axis] >> 1 & 1;
                key[8 - axis] = index[axis] & 1;
            }
            order.emplace_back(key, index);
        }
        std::sort(order.begin(), order.end());
        std::vector<Index> seeds;
        for (std::size_t i = 0; i < 12; ++i)
            seeds.push_back(order[(2 * i + 1) * order.size() / 24].second);
        for (const auto& each : order)
            seeds.push_back(each.second);
        return seeds;
    }

    /// In steps: a power of two over 2^-8 and what floats cannot tell.
    double seed_height(const Vec& point) const {
        return std::exp2(std::floor(std::log2(0x1p-8 + largest_coordinate(point) * 0x1p-20 / step_)) + 1.0);
    }

    /// The least and the greatest average over D. A light point that may belong to D lowers the average if it
    /// is dark and raises it if it is lit. Empty (low > high) if D must be empty.
    Interval average(const std::vector<Neighbour>& neighbours, std::size_t light) const {
        double low_lit = 0.0, low_count = 0.0, high_lit = 0.0, high_count = 0.0;
        for (const Neighbour& x : neighbours) {
            const Answer lit = light_reaches(light, x.position);
            const bool surely_in = x.belongs == Answer::yes;
            const bool lit_at_least = lit == Answer::yes;
            const bool lit_at_most = lit != Answer::no;
            if (surely_in || !lit_at_least)
                low_count += 1.0;
            if (surely_in && lit_at_least)
                low_lit += 1.0;
            if (surely_in || lit_at_most)
                high_count += 1.0;
            if (lit_at_most)
                high_lit += 1.0;
        }
        if (neighbours.empty())
            return {1.0, 0.0};
        return {low_count > 0.0 ? low_lit / low_count : 1.0, high_count > 0.0 ? high_lit / high_count : 0.0};
    }

    double end_offset(const Vec& point) const {
        return largest_coordinate(point) * 0x1p-19 + step_ * 0x1p-11;
    }

    Vec surface_end(const Vec& point, const Vec& n) const { return point + end_offset(point) * n; }

    /// V(L_i, point), for the long test and for the shadow ray.
    Answer light_reaches(std::size_t light, const Vec& point) const {
        if (const auto* sun = std::get_if<lightmesh::DirectionalLight>(&lights_[light])) {
            const double outside = 4.0 * (extent_ + largest_coordinate(point));
            return sees(point, point - outside * glm::normalize(Vec(sun->direction)), triangles_,
                        segment_band_);
        }
        const Vec position = position_of(light);
        const Vec way = point - position;
        const double offset = (std::min)(end_offset(position), 0.5 * glm::length(way));
        if (way == Vec(0.0))
            return Answer::yes;
        return sees(position + offset * glm::normalize(way), point, triangles_, segment_band_);
    }

    /// chi of equation (3), range and cone.
    Answer reaches(std::size_t light, const Vec& point, const Vec& n) const {
        constexpr double relative_band = 1e-5;
        if (const auto* sun = std::get_if<lightmesh::DirectionalLight>(&lights_[light]))
            return n == Vec(0.0)
                       ? Answer::yes
                       : greater(-glm::dot(n, glm::normalize(Vec(sun->direction))), 0.0, relative_band);
        const Vec way = position_of(light) - point;
        const double length = glm::length(way);
        const double band = relative_band * (length + largest_coordinate(point));
        Answer answer = n == Vec(0.0) ? Answer::yes : greater(glm::dot(n, way), 0.0, band);
        const double range = range_of(light);
        if (range < std::numeric_limits<double>::infinity())
            answer = both(answer, greater(range, length, relative_band * range + band));
        if (const auto* spot = std::get_if<lightmesh::SpotLight>(&lights_[light])) {
            const Vec axis = glm::normalize(Vec(spot->axis));
            const double angle = std::atan2(glm::length(glm::cross(axis, way)), -glm::dot(axis, way));
            const auto cone = static_cast<double>(spot->cone);
            if (spot->cone < 3.14159f)
                answer = both(answer, greater(cone, angle, 1e-3 * (std::min)(cone, 1.0)));
        }
        return answer;
    }

    Vec position_of(std::size_t light) const {
        if (const auto* lamp = std::get_if<lightmesh::PointLight>(&lights_[light]))
            return Vec(lamp->position);
        return Vec(std::get<lightmesh::SpotLight>(lights_[light]).position);
    }

    double range_of(std::size_t light) const {
        if (const auto* lamp = std::get_if<lightmesh::PointLight>(&lights_[light]))
            return static_cast<double>(lamp->range);
        return static_cast<double>(std::get<lightmesh::SpotLight>(lights_[light]).range);
    }

    std::vector<Triangle> triangles_;
    std::vector<lightmesh::Light> lights_;
    Vec origin_;
    double step_;
    double quality_;
    ShortTest short_test_;
    double extent_ = 0.0;
    double segment_band_ = 0.0;
};

/// The adapter that goes with it: the same tracer, without the doubts.
struct PlainTracer {
    const std::vector<Triangle>* triangles;

    bool occluded(const lightmesh::Segment& segment) const {
        return blocked(Vec(segment.origin), Vec(segment.target), *triangles);
    }
};

}  // namespace test
