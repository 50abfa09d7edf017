// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/settings.hpp>

#include <cstdlib>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

namespace lightmesh::tune {

using lightmesh::LongTest;

/// One way to set up a light mesh, to be tried. Two candidates are the same if all members are equal.
struct Candidate {
    float radius = 1.0f;                       ///< r, world units: as `Settings::radius`
    float quality = 4.0f;                      ///< q: as `Settings::quality`
    ShortTest short_test = ShortTest::linked;  ///< how V(P, x) is found
    LongTest long_test = LongTest::rays;       ///< how V(L, x) is found
    int shadow_map_size = 0;  ///< texels to a side, for shadow maps; 0 for all other long tests

    /// Equal in all members.
    bool operator==(const Candidate&) const = default;
};

/// Whether a map size matters.
inline bool uses_shadow_maps(LongTest long_test) {
    return long_test == LongTest::shadow_maps || long_test == LongTest::refined_shadow_maps;
}

/// What a grid of candidates is made of: every combination of the members' values.
struct Choices {
    std::vector<float> radii;                              ///< world units; `suggest_radii` has an idea
    std::vector<float> qualities{2.0f, 3.0f, 4.0f, 6.0f};  ///< in [1, 16]
    /// How V(P, x) may be found.
    std::vector<ShortTest> short_tests{ShortTest::none, ShortTest::linked, ShortTest::exact};
    std::vector<LongTest> long_tests{LongTest::rays};  ///< how V(L, x) may be found
    std::vector<int> shadow_map_sizes{512, 1024};      ///< only for shadow maps
};

/// All combinations, radius by radius; within a radius the qualities rise.
inline std::vector<Candidate> make_candidates(const Choices& choices) {
    std::vector<Candidate> candidates;
    const std::vector<int> no_map{0};
    for (const float radius : choices.radii)
        for (const float quality : choices.qualities)
            for (const LongTest long_test : choices.long_tests)
                for (const int size : uses_shadow_maps(long_test) ? choices.shadow_map_sizes : no_map)
                    for (const ShortTest short_test : choices.short_tests)
                        candidates.push_back({radius, quality, short_test, long_test, size});
    return candidates;
}

/// The settings of a candidate; `base` has what candidates leave open (origin, scene bounds).
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

namespace detail {

/// With as few digits as tell it from all other floats.
inline std::string shortest(float value) {
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

/// A float as C++ source: always with a point or an exponent, so that the suffix f is legal.
inline std::string to_source(float value) {
    std::string text = shortest(value);
    if (text.find_first_of(".e") == std::string::npos)
        text += ".0";
    return text + "f";
}

}  // namespace detail

/// For people: "r 3, q 4, linked, shadow maps 1024".
inline std::string describe(const Candidate& candidate) {
    std::string text = "r " + detail::shortest(candidate.radius) + ", q " +
                       detail::shortest(candidate.quality) + ", " + name_of(candidate.short_test) + ", " +
                       name_of(candidate.long_test);
    if (uses_shadow_maps(candidate.long_test))
        text += " " + std::to_string(candidate.shadow_map_size);
    return text;
}

/// For programs, to be pasted: "lightmesh::Settings{.radius = 3.0f, .quality = 4.0f, ...}".
inline std::string to_source(const Candidate& candidate) {
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
