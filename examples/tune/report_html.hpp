// SPDX-License-Identifier: MIT
#pragma once

#include "tune/pictures.hpp"
#include "tune/report.hpp"

#include <optional>
#include <string>

namespace demo {

/// The report for people: one HTML file that needs nothing else.
std::string to_html(const Report& report, const std::optional<ReportPictures>& pictures);

}  // namespace demo
