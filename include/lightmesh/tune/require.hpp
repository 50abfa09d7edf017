// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>

#include <cmath>
#include <cstddef>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>

namespace lightmesh::tune::detail {

inline std::string value_text(const glm::vec3& v) {
    std::ostringstream text;
    text.precision(std::numeric_limits<float>::max_digits10);
    text << '(' << v.x << ", " << v.y << ", " << v.z << ')';
    return text.str();
}

template <class Number>
std::string value_text(Number value) {
    std::ostringstream text;
    text.precision(std::numeric_limits<float>::max_digits10);
    text << value;
    return text.str();
}

inline bool is_finite(const glm::vec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// Throws std::invalid_argument "lightmesh: WHAT is VALUE; it must be RULE" unless `valid`.
template <class Value>
void require(bool valid, const std::string& what, const Value& value, const char* rule) {
    if (!valid)
        throw std::invalid_argument("lightmesh: " + what + " is " + value_text(value) + "; it must be " +
                                    rule);
}

}  // namespace lightmesh::tune::detail
