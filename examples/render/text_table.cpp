// SPDX-License-Identifier: MIT
#include "render/text_table.hpp"

#include <algorithm>
#include <cstdio>
#include <stdexcept>
#include <utility>

namespace demo {

void TextTable::add_row(std::vector<std::string> cells) {
    if (cells.empty() || (!rows_.empty() && cells.size() != rows_.front().size()))
        throw std::invalid_argument("a row of " + std::to_string(cells.size()) +
                                    " cells does not fit the table");
    rows_.push_back(std::move(cells));
}

void TextTable::add_rule() {
    rows_.emplace_back();
}

std::string TextTable::text() const {
    std::vector<std::size_t> widths;
    for (const auto& row : rows_) {
        widths.resize((std::max)(widths.size(), row.size()));
        for (std::size_t i = 0; i < row.size(); ++i)
            widths[i] = (std::max)(widths[i], row[i].size());
    }
    std::size_t whole = widths.empty() ? 0 : 2 * (widths.size() - 1);
    for (const std::size_t width : widths)
        whole += width;
    std::string text;
    for (const auto& row : rows_) {
        if (row.empty())
            text += std::string(whole, '-');
        for (std::size_t i = 0; i < row.size(); ++i) {
            const std::string space(widths[i] - row[i].size(), ' ');
            text += i == 0 ? row[i] + space : "  " + space + row[i];
        }
        text += '\n';
    }
    return text;
}

std::string grouped(unsigned long long number) {
    std::string digits = std::to_string(number);
    for (std::size_t i = digits.size(); i > 3; i -= 3)
        digits.insert(i - 3, ",");
    return digits;
}

std::string fixed(double number, int digits) {
    char text[64];
    std::snprintf(text, sizeof text, "%.*f", digits, number);
    return text;
}

std::string exactly(double number) {
    char text[40];
    std::snprintf(text, sizeof text, "%.9g", number);
    return text;
}

std::string number(float value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.4g", static_cast<double>(value));
    return text;
}

std::string bytes_text(std::size_t bytes) {
    return fixed(static_cast<double>(bytes) / 1e6, 1) + " MB";
}

}  // namespace demo
