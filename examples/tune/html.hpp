// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

namespace demo {

/// Text as it may stand in HTML, also in an attribute.
std::string escaped(std::string_view text);

/// A PNG file's bytes as an address that needs no file.
std::string png_address(std::string_view bytes);

}  // namespace demo
