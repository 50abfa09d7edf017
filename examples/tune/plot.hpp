// SPDX-License-Identifier: MIT
#pragma once

#include "tune/report.hpp"

#include <string>

namespace demo {

/// Time and error of all candidates of a radius, both on logarithmic axes, with the frontier, what is
/// recommended, and the time of hard shadow rays: an SVG element. All radii share the axes.
std::string time_error_plot(const Report& report, float radius);

/// A legend of the plots' marks: an SVG element.
std::string plot_legend(const Report& report);

/// Quantities for people: "1.5 µs", "0.3 s", "2.1 %", "12 MB".
std::string seconds_text(double seconds);
std::string percent_text(double share);
std::string megabytes_text(double bytes);

}  // namespace demo
