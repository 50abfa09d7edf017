// SPDX-License-Identifier: MIT
#pragma once

#include <glm/vec3.hpp>

#include <cstddef>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>

/// Checks at the library's boundary and the wording of their errors.

namespace lightmesh::detail {

inline std::string to_text(const glm::vec3& v) {
    std::ostringstream text;
    text.precision(std::numeric_limits<float>::max_digits10);
    text << '(' << v.x << ", " << v.y << ", " << v.z << ')';
    return text.str();
}

template <class Number>
std::string to_text(Number value) {
    std::ostringstream text;
    text.precision(std::numeric_limits<float>::max_digits10);
    text << value;
    return text.str();
}

/// Throws std::invalid_argument "lightmesh: WHAT is VALUE; it must be RULE" unless `valid`.
template <class Value>
void require(bool valid, const std::string& what, const Value& value, const char* rule) {
    if (!valid)
        throw std::invalid_argument("lightmesh: " + what + " is " + to_text(value) + "; it must be " + rule);
}

/// Throws std::invalid_argument unless the span of `what` has the size that it must have.
inline void require_size(const char* what, std::size_t size, std::size_t expected) {
    if (size != expected)
        throw std::invalid_argument("lightmesh: the span of " + std::string(what) + " has " +
                                    std::to_string(size) + " places; it must have " +
                                    std::to_string(expected));
}

}  // namespace lightmesh::detail
