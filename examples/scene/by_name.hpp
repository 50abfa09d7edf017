// SPDX-License-Identifier: MIT
#pragma once

#include <charconv>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

namespace demo {

/// The number of what the user asks for by its name, or its number from 0; 0 if `wanted` is empty. Throws
/// std::runtime_error that says which there are.
inline std::size_t number_by_name(const std::vector<std::string>& names, const std::string& wanted,
                                  const std::string& what) {
    if (wanted.empty())
        return 0;
    for (std::size_t i = 0; i < names.size(); ++i)
        if (names[i] == wanted)
            return i;
    std::size_t number = 0;
    const auto [end, error] = std::from_chars(wanted.data(), wanted.data() + wanted.size(), number);
    if (error == std::errc() && end == wanted.data() + wanted.size() && number < names.size())
        return number;
    std::string list;
    for (std::size_t i = 0; i < names.size(); ++i)
        list += (i == 0 ? "" : ", ") + std::to_string(i) + " '" + names[i] + "'";
    throw std::runtime_error("there is no " + what + " '" + wanted + "'; " +
                             (list.empty() ? "the file has none" : "there are " + list));
}

}  // namespace demo
