// SPDX-License-Identifier: MIT
#include "checks.hpp"

#include "pass.hpp"
#include "workloads.hpp"

#include <cmath>
#include <cstring>
#include <map>
#include <sstream>
#include <vector>

namespace bench {

namespace {

constexpr std::size_t sample_tiles = 1024;

const ShadingPoints& sample_of(const std::string& scene) {
    static std::map<std::string, ShadingPoints> kept;
    auto found = kept.find(scene);
    if (found == kept.end())
        found = kept.emplace(scene, points_of(scene, 0).sample(sample_tiles)).first;
    return found->second;
}

std::vector<float> values(const Contestant& contestant, const Row& row) {
    const ShadingPoints& sample = sample_of(row.scene);
    std::vector<float> lit(sample.size() * row.lights);
    std::size_t done = 0;
    for (std::size_t t = 0; t < sample.tile_count(); ++t) {
        const std::size_t size = sample.tile(t).size() * row.lights;
        contestant.find(sample.tile(t), std::span(lit).subspan(done, size));
        done += size;
    }
    return lit;
}

const std::vector<float>& exact_values(const Row& row) {
    static std::map<std::string, std::vector<float>> kept;
    Row exact{
        .scene = row.scene, .algorithm = Algorithm::exact, .lights = row.lights, .quality = row.quality};
    exact.cold = true;  // it fills itself with what the sample needs, which is less than the picture does
    std::vector<float>& lit = kept[exact.name()];
    if (lit.empty()) {
        const std::shared_ptr<const Contestant> mesh = contestant(exact);
        Pass(sample_of(row.scene), row.lights, 0).run(*mesh);
        lit = values(*mesh, exact);
    }
    return lit;
}

std::string find_bad_value(const std::vector<float>& lit) {
    for (const float value : lit) {
        if (value >= 0.0f && value <= 1.0f)
            continue;
        std::ostringstream text;
        text << "a visibility of " << value;
        return text.str();
    }
    return {};
}

bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

std::string check_other_form(const Row& row, const std::vector<float>& lit) {
    Row single = row;
    single.form = "single";
    const std::vector<float> expected = values(*contestant(single), single);
    std::size_t different = 0;
    for (std::size_t i = 0; i < lit.size(); ++i)
        different += lit[i] != expected[i] ? 1 : 0;
    if (static_cast<double>(different) <= largest_mismatch * static_cast<double>(lit.size()))
        return {};
    return std::to_string(different) + " of " + std::to_string(lit.size()) +
           " values differ from rtcOccluded1's";
}

std::string check_other_query(const Row& row, const std::vector<float>& lit) {
    Row other = row;
    other.query = row.query == Query::tile ? Query::point : Query::tile;
    if (same_bits(lit, values(*contestant(other), other)))
        return {};
    return "the query for many points and that for one give different values";
}

/// Over lights that face the point.
void measure(const Row& row, const std::vector<float>& lit, Checked& checked) {
    const std::vector<float>& exact = exact_values(row);
    const ShadingPoints& sample = sample_of(row.scene);
    const Workload& work = workload(row.scene, row.lights);
    const std::shared_ptr<const Contestant> spender = contestant(row);
    std::size_t pairs = 0;
    std::size_t i = 0;
    std::uint64_t rays = 0;
    for (std::size_t t = 0; t < sample.tile_count(); ++t) {
        const Points tile = sample.tile(t);
        rays += spender->rays(tile);
        for (std::size_t p = 0; p < tile.size(); ++p) {
            for (std::size_t l = 0; l < row.lights; ++l, ++i) {
                if (!work.faces(l, tile.positions[p], tile.normals[p]))
                    continue;
                const double error = std::abs(static_cast<double>(lit[i]) - static_cast<double>(exact[i]));
                checked.error += error;
                checked.error_rms += error * error;
                ++pairs;
            }
        }
    }
    const double count = pairs > 0 ? static_cast<double>(pairs) : 1.0;
    checked.error /= count;
    checked.error_rms = std::sqrt(checked.error_rms / count);
    checked.rays_per_point = static_cast<double>(rays) / static_cast<double>(sample.size());
}

Checked check_now(const Row& row) {
    Checked checked;
    const std::vector<float> lit = values(*contestant(row), row);
    checked.problem = find_bad_value(lit);
    if (checked.problem.empty() && row.algorithm == Algorithm::hard)
        checked.problem = check_other_form(row, lit);
    if (checked.problem.empty() && row.is_mesh())
        checked.problem = check_other_query(row, lit);
    if (!checked.problem.empty())
        return checked;
    measure(row, lit, checked);
    const bool is_tight =
        row.algorithm == Algorithm::exact ? checked.error == 0.0 : checked.error <= largest_error;
    if (row.is_mesh() && !is_tight)
        checked.problem = "a mean absolute error to exact of " + std::to_string(checked.error);
    return checked;
}

}  // namespace

const Checked& check(const Row& row) {
    static std::map<std::string, Checked> kept;
    const Row checked_row = warm(row);
    auto found = kept.find(checked_row.name());
    if (found == kept.end())
        found = kept.emplace(checked_row.name(), check_now(checked_row)).first;
    return found->second;
}

bool same_values(const Row& row, const Contestant& filled) {
    return same_bits(values(filled, row), values(*contestant(warm(row)), row));
}

}  // namespace bench
