// SPDX-License-Identifier: MIT
#include "rows.hpp"

#include <algorithm>
#include <array>
#include <iterator>

namespace bench {

namespace {

constexpr std::array light_counts{std::size_t{1}, std::size_t{4}, std::size_t{16}, std::size_t{64},
                                  std::size_t{256}};

/// What the other sweeps are done at.
constexpr std::size_t main_lights = 64;

/// Between these, warm meshes break even with hard shadows.
constexpr std::array few_lights{std::size_t{2}, std::size_t{3}, std::size_t{5}, std::size_t{8}};

class Rows {
public:
    explicit Rows(const std::string& scene) : scene_(scene) {}

    void add_hard(const std::string& form, std::size_t lights) {
        // The rows that figures are taken from get more points.
        const std::size_t pairs = lights == main_lights ? 8'000'000 : 4'000'000;
        rows_.push_back({.scene = scene_,
                         .algorithm = Algorithm::hard,
                         .lights = lights,
                         .most_points = (std::max)(pairs / lights, std::size_t{24'000}),
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
                         .most_points = (std::max)(1'500'000 / lights, std::size_t{8'000}),
                         .repetitions = 2,
                         .form = form});
    }

    void add_shadow_maps(std::size_t lights) {
        rows_.push_back({.scene = scene_,
                         .algorithm = Algorithm::pcf,
                         .lights = lights,
                         .most_points = (std::max)(4'000'000 / lights, std::size_t{24'000}),
                         .repetitions = lights > main_lights ? 1 : 3});
    }

    /// Warm only: a cold frame adds to this what it adds to Express, the long tests.
    void add_exact(std::size_t lights, float quality) {
        rows_.push_back({.scene = scene_,
                         .algorithm = Algorithm::exact,
                         .lights = lights,
                         .most_points = 50'000,
                         .quality = quality});
    }

    /// Linked and Express.
    void add_meshes(const Row& like) {
        for (const Algorithm algorithm : {Algorithm::linked, Algorithm::express}) {
            rows_.push_back(like);
            rows_.back().scene = scene_;
            rows_.back().algorithm = algorithm;
        }
    }

    void add_warm_meshes(std::size_t lights, Query query, int repetitions = 3) {
        add_meshes({.lights = lights, .repetitions = repetitions, .query = query});
    }

    void add_cold_meshes(std::size_t lights, Query query) {
        const int repetitions = lights == main_lights ? 3 : 1;
        add_meshes({.lights = lights, .repetitions = repetitions, .cold = true, .query = query});
    }

    void sweep_quality() {
        for (const float quality : {2.0f, 6.0f}) {
            add_exact(main_lights, quality);
            add_meshes({.repetitions = 2, .quality = quality});
            add_meshes({.repetitions = 1, .quality = quality, .cold = true});
        }
    }

    const std::vector<Row>& rows() const { return rows_; }

private:
    std::string scene_;
    std::vector<Row> rows_;
};

std::vector<Row> park_rows() {
    Rows rows("park");
    for (const std::size_t lights : light_counts) {
        rows.add_all_hard(lights);
        rows.add_area("single", lights);
        rows.add_shadow_maps(lights);
        rows.add_exact(lights, 4.0f);
        rows.add_warm_meshes(lights, Query::tile);
        rows.add_cold_meshes(lights, Query::tile);
    }
    for (const std::size_t lights : few_lights) {
        rows.add_hard("single", lights);
        rows.add_warm_meshes(lights, Query::tile);
    }
    rows.add_area("packet16", main_lights);
    for (const std::size_t lights : {std::size_t{1}, main_lights, std::size_t{256}})
        rows.add_warm_meshes(lights, Query::point);
    rows.add_cold_meshes(main_lights, Query::point);
    for (const bool cold : {false, true})
        for (const Query query : {Query::point, Query::tile})
            rows.add_meshes({.cold = cold, .query = query, .threads = 2});
    rows.sweep_quality();
    return rows.rows();
}

std::vector<Row> other_rows(const std::string& scene) {
    Rows rows(scene);
    for (const std::size_t lights : light_counts) {
        rows.add_hard("single", lights);
        rows.add_warm_meshes(lights, Query::tile, lights == main_lights ? 3 : 1);
    }
    for (const std::string& form : hard_forms())
        if (form != "single")
            rows.add_hard(form, main_lights);
    rows.add_area("single", main_lights);
    rows.add_shadow_maps(main_lights);
    rows.add_exact(main_lights, 4.0f);
    rows.add_cold_meshes(main_lights, Query::tile);
    rows.sweep_quality();
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
