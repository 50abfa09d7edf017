// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/segment.hpp>
#include <lightmesh/support/check.hpp>

#include <cstddef>
#include <string>

namespace lightmesh::detail {

/// "3,812".
inline std::string grouped(std::size_t number) {
    std::string text = std::to_string(number);
    for (std::size_t digits = 3; digits < text.size(); digits += 4)
        text.insert(text.size() - digits, ",");
    return text;
}

/// The number of answers of a kind that are wrong, and the first of them.
struct Finding {
    std::size_t wrong = 0;
    std::size_t all = 0;
    Segment example{};

    void add(bool is_wrong, const Segment& segment) {
        ++all;
        if (is_wrong && wrong++ == 0)
            example = segment;
    }

    void add(const Finding& other) {
        if (wrong == 0)
            example = other.example;
        wrong += other.wrong;
        all += other.all;
    }

    /// More than this share, and more than a few where there are few.
    bool is_clearly_more_than(double share) const {
        return static_cast<double>(wrong) > 3.0 + share * static_cast<double>(all);
    }

    bool is_more_than(double share) const {
        return static_cast<double>(wrong) > share * static_cast<double>(all);
    }

    /// "lightmesh: 3,812 of 4,000 WHAT: WHY; for example from (..) to (..)."
    std::string sentence(const std::string& what, const std::string& why) const {
        return "lightmesh: " + grouped(wrong) + " of " + grouped(all) + ' ' + what + ": " + why +
               "; for example from " + to_text(example.origin) + " to " + to_text(example.target) + '.';
    }
};

}  // namespace lightmesh::detail
