// SPDX-License-Identifier: MIT
#include "rows.hpp"

#include <algorithm>
#include <array>

namespace bench {

namespace {

constexpr std::array light_counts{std::size_t{1}, std::size_t{4}, std::size_t{16}, std::size_t{64},
                                  std::size_t{256}};

/// Between these, warm meshes break even with hard shadows.
constexpr std::array few_lights{std::size_t{2}, std::size_t{3}, std::size_t{5}, std::size_t{8}};

/// Points for about this many pairs of point and light, but enough tiles to stand for the picture.
std::size_t points_for(std::size_t pairs, std::size_t lights) {
    constexpr std::size_t least = 24'000;
    return (std::max)(pairs / lights, least);
}

class Rows {
public:
    explicit Rows(const std::string& scene) : scene_(scene) {}

    void add_hard(const std::string& form, std::size_t lights) {
        rows_.push_back({.scene = scene_,
                         .algorithm = Algorithm::hard,
                         .lights = lights,
                         .most_points = points_for(8'000'000, lights),
                         .form = form});
    }

    void add_all_hard(std::size_t lights) {
        for (const std::string& form : hard_forms())
            add_hard(form, lights);
    }

    void add_area(const std::string& form, std::size_t lights) {
        rows_.push_back({.scene = scene_,
                         .algorithm = Algorithm::area,
                         .lights = lights,
                         .most_points = points_for(1'000'000, lights),
                         .form = form});
    }

    void add_shadow_maps(std::size_t lights) {
        rows_.push_back({.scene = scene_,
                         .algorithm = Algorithm::pcf,
                         .lights = lights,
                         .most_points = points_for(8'000'000, lights)});
    }

    /// Warm only: a cold frame adds to this what it adds to Express, the long tests.
    void add_exact(std::size_t lights, float quality) {
        rows_.push_back({.scene = scene_,
                         .algorithm = Algorithm::exact,
                         .lights = lights,
                         .most_points = 50'000,
                         .quality = quality});
    }

    void add_meshes(std::size_t lights, float quality, bool cold, Query query, int threads = 1) {
        for (const Algorithm algorithm : {Algorithm::linked, Algorithm::express})
            rows_.push_back({.scene = scene_,
                             .algorithm = algorithm,
                             .lights = lights,
                             .quality = quality,
                             .cold = cold,
                             .query = query,
                             .threads = threads});
    }

    const std::vector<Row>& rows() const { return rows_; }

private:
    std::string scene_;
    std::vector<Row> rows_;
};

/// Everything.
std::vector<Row> park_rows() {
    Rows rows("park");
    for (const std::size_t lights : light_counts) {
        rows.add_all_hard(lights);
        rows.add_area("single", lights);
        rows.add_shadow_maps(lights);
        rows.add_exact(lights, 4.0f);
        for (const bool cold : {false, true})
            for (const Query query : {Query::point, Query::tile})
                rows.add_meshes(lights, 4.0f, cold, query);
    }
    for (const std::size_t lights : few_lights) {
        rows.add_hard("single", lights);
        for (const Query query : {Query::point, Query::tile})
            rows.add_meshes(lights, 4.0f, false, query);
    }
    rows.add_area("packet16", 64);
    for (const float quality : {2.0f, 6.0f}) {
        rows.add_exact(64, quality);
        for (const bool cold : {false, true})
            rows.add_meshes(64, quality, cold, Query::tile);
    }
    for (const bool cold : {false, true})
        for (const Query query : {Query::point, Query::tile})
            rows.add_meshes(64, 4.0f, cold, query, 2);
    return rows.rows();
}

std::vector<Row> other_rows(const std::string& scene) {
    Rows rows(scene);
    for (const std::size_t lights : light_counts) {
        rows.add_hard("single", lights);
        for (const bool cold : {false, true})
            rows.add_meshes(lights, 4.0f, cold, Query::tile);
    }
    for (const std::string& form : hard_forms())
        if (form != "single")
            rows.add_hard(form, 64);
    rows.add_area("single", 64);
    rows.add_shadow_maps(64);
    for (const float quality : {2.0f, 4.0f, 6.0f})
        rows.add_exact(64, quality);
    for (const float quality : {2.0f, 6.0f})
        for (const bool cold : {false, true})
            rows.add_meshes(64, quality, cold, Query::tile);
    return rows.rows();
}

}  // namespace

std::vector<Row> all_rows() {
    std::vector<Row> rows = park_rows();
    for (const char* scene : {"spheres", "rooms"})
        std::ranges::copy(other_rows(scene), std::back_inserter(rows));
    return rows;
}

}  // namespace bench
