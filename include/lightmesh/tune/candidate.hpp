// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/cache_settings.hpp>
#include <lightmesh/settings.hpp>

#include <cstdlib>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

namespace lightmesh::tune {

using lightmesh::LongTest;

/// One way to set up a light mesh or a visibility cache, to be tried: a cache if `spacing` is not 0. Two
/// candidates are the same if all members are equal.
struct Candidate {
    float radius = 1.0f;                       ///< r, world units: as `Settings::radius`
    float quality = 4.0f;                      ///< q: as `Settings::quality`
    ShortTest short_test = ShortTest::linked;  ///< how V(P, x) is found
    LongTest long_test = LongTest::rays;       ///< how V(L, x) is found
    int shadow_map_size = 0;  ///< texels to a side, for shadow maps; 0 for all other long tests
    /// g, world units: as `CacheSettings::spacing`. 0: a light mesh, for which the next three say nothing.
    /// Else a cache, for which all of the above says nothing; `make_candidates` leaves 0 there.
    float spacing = 0.0f;
    int detail = 0;          ///< as `CacheSettings::detail`
    int lamp_rays = 0;       ///< as `CacheSettings::lamp_rays`
    bool shaft_rows = true;  ///< as `CacheSettings::shaft_rows`

    /// Equal in all members.
    bool operator==(const Candidate&) const = default;
};

/// True if it is a `VisibilityCache`, and no `LightMesh`.
inline bool is_cache(const Candidate& candidate) {
    return candidate.spacing != 0.0f;
}

/// r of a light mesh; 0 of a cache, whose penumbrae follow from the lamps.
inline float radius_of(const Candidate& candidate) {
    return is_cache(candidate) ? 0.0f : candidate.radius;
}

/// True if a map size matters.
inline bool uses_shadow_maps(LongTest long_test) {
    return long_test == LongTest::shadow_maps || long_test == LongTest::refined_shadow_maps;
}

/// The values that a grid of candidates is made of: every combination of the first five members' values for
/// light meshes, and of the last four for caches.
struct Choices {
    std::vector<float> radii{};                            ///< world units; `suggest_radii` has an idea
    std::vector<float> qualities{2.0f, 3.0f, 4.0f, 6.0f};  ///< in [1, 16]
    /// The ways that V(P, x) may be found.
    std::vector<ShortTest> short_tests{ShortTest::none, ShortTest::linked, ShortTest::exact};
    std::vector<LongTest> long_tests{LongTest::rays};  ///< how V(L, x) may be found
    std::vector<int> shadow_map_sizes{512, 1024};      ///< only for shadow maps
    std::vector<float> spacings{};       ///< g of caches, world units: a quarter of a radius is a good start
    std::vector<int> details{2, 3};      ///< halvings of g
    std::vector<int> lamp_rays{16, 64};  ///< in [1, 256]
    std::vector<bool> shaft_rows{true};  ///< as `CacheSettings::shaft_rows`
};

/// All combinations, radius by radius; within a radius the qualities rise. Caches come last.
inline std::vector<Candidate> make_candidates(const Choices& choices) {
    std::vector<Candidate> candidates;
    const std::vector<int> no_map{0};
    for (const float radius : choices.radii)
        for (const float quality : choices.qualities)
            for (const LongTest long_test : choices.long_tests)
                for (const int size : uses_shadow_maps(long_test) ? choices.shadow_map_sizes : no_map)
                    for (const ShortTest short_test : choices.short_tests)
                        candidates.push_back({radius, quality, short_test, long_test, size});
    for (const float spacing : choices.spacings)
        for (const int detail : choices.details)
            for (const int rays : choices.lamp_rays)
                for (const bool shaft_rows : choices.shaft_rows)
                    candidates.push_back({.radius = 0.0f,
                                          .quality = 0.0f,
                                          .spacing = spacing,
                                          .detail = detail,
                                          .lamp_rays = rays,
                                          .shaft_rows = shaft_rows});
    return candidates;
}

/// The settings of a cache.
inline CacheSettings cache_settings_of(const Candidate& candidate) {
    return {.spacing = candidate.spacing,
            .detail = candidate.detail,
            .lamp_rays = candidate.lamp_rays,
            .shaft_rows = candidate.shaft_rows};
}

/// The settings of a light mesh; `base` has what candidates leave open (origin, scene bounds).
inline Settings settings_of(const Candidate& candidate, Settings base = {}) {
    base.radius = candidate.radius;
    base.quality = candidate.quality;
    base.short_test = candidate.short_test;
    base.refine_shadow_maps = candidate.long_test == LongTest::refined_shadow_maps;
    if (uses_shadow_maps(candidate.long_test))
        base.shadow_map_size = candidate.shadow_map_size;
    return base;
}

/// For people: "linked".
inline const char* name_of(ShortTest short_test) {
    switch (short_test) {
    case ShortTest::none:
        return "none";
    case ShortTest::linked:
        return "linked";
    case ShortTest::exact:
        break;
    }
    return "exact";
}

/// For people: "shadow maps".
inline const char* name_of(LongTest long_test) {
    switch (long_test) {
    case LongTest::rays:
        return "rays";
    case LongTest::shadow_maps:
        return "shadow maps";
    case LongTest::refined_shadow_maps:
        return "refined shadow maps";
    case LongTest::shadow_volumes:
        break;
    }
    return "shadow volumes";
}

/// For people: with as few digits as tell it from all other floats.
inline std::string shortest_text(float value) {
    std::ostringstream text;
    for (int digits = 6; digits <= std::numeric_limits<float>::max_digits10; ++digits) {
        text.str({});
        text.precision(digits);
        text << value;
        if (std::strtof(text.str().c_str(), nullptr) == value)
            break;
    }
    return text.str();
}

namespace detail {

/// A float as C++ source: always with a point or an exponent, so that the suffix f is legal.
inline std::string to_source(float value) {
    std::string text = shortest_text(value);
    if (text.find_first_of(".e") == std::string::npos)
        text += ".0";
    return text + "f";
}

}  // namespace detail

/// For people: "r 3, q 4, linked, shadow maps 1024" or "cache, g 0.25, detail 3, 64 lamp rays", with "no
/// shaft rows" where there are none.
inline std::string describe(const Candidate& candidate) {
    if (is_cache(candidate))
        return "cache, g " + shortest_text(candidate.spacing) + ", detail " +
               std::to_string(candidate.detail) + ", " + std::to_string(candidate.lamp_rays) + " lamp rays" +
               (candidate.shaft_rows ? "" : ", no shaft rows");
    std::string text = "r " + shortest_text(candidate.radius) + ", q " + shortest_text(candidate.quality) +
                       ", " + name_of(candidate.short_test) + ", " + name_of(candidate.long_test);
    if (uses_shadow_maps(candidate.long_test))
        text += " " + std::to_string(candidate.shadow_map_size);
    return text;
}

/// For programs, to be pasted: "lightmesh::Settings{.radius = 3.0f, .quality = 4.0f, ...}" or
/// "lightmesh::CacheSettings{.spacing = 0.25f, ...}".
inline std::string to_source(const Candidate& candidate) {
    if (is_cache(candidate))
        return "lightmesh::CacheSettings{.spacing = " + detail::to_source(candidate.spacing) +
               ", .detail = " + std::to_string(candidate.detail) +
               ", .lamp_rays = " + std::to_string(candidate.lamp_rays) +
               (candidate.shaft_rows ? "}" : ", .shaft_rows = false}");
    std::string text = "lightmesh::Settings{.radius = " + detail::to_source(candidate.radius) +
                       ", .quality = " + detail::to_source(candidate.quality) +
                       ", .short_test = lightmesh::ShortTest::" + name_of(candidate.short_test);
    if (uses_shadow_maps(candidate.long_test))
        text += ", .shadow_map_size = " + std::to_string(candidate.shadow_map_size);
    if (candidate.long_test == LongTest::refined_shadow_maps)
        text += ", .refine_shadow_maps = true";
    return text + "}";
}

}  // namespace lightmesh::tune
