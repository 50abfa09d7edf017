// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

namespace demo {

/// Text in columns: the first to the left, all others to the right.
class TextTable {
public:
    /// Throws std::invalid_argument for a row that is not as long as those before it.
    void add_row(std::vector<std::string> cells);
    /// A rule below the last row.
    void add_rule();
    /// All lines, each with a line break.
    std::string text() const;

private:
    std::vector<std::vector<std::string>> rows_;  // no cells: a rule
};

/// 12345678 as "12,345,678".
std::string grouped(unsigned long long number);
/// With so many digits behind the point.
std::string fixed(double number, int digits);
/// With as many digits as tell floats apart.
std::string exactly(double number);
/// With four digits, as short as can be.
std::string number(float value);
/// "1.5 MB"
std::string bytes_text(std::size_t bytes);

}  // namespace demo
