// SPDX-License-Identifier: MIT
#include "obj_text.hpp"

#include "model.hpp"

#include <glm/common.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <vector>

namespace demo {
namespace {

[[noreturn]] void fail(std::size_t line, const std::string& problem) {
    throw std::runtime_error("line " + std::to_string(line) + ": " + problem);
}

bool is_space(char c) {
    return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}

/// Words of a line, one after the other.
class Words {
public:
    explicit Words(std::string_view line) : rest_(line) {}
    /// Empty at the end of the line.
    std::string_view next() {
        while (!rest_.empty() && is_space(rest_.front()))
            rest_.remove_prefix(1);
        std::size_t length = 0;
        while (length < rest_.size() && !is_space(rest_[length]))
            ++length;
        const std::string_view word = rest_.substr(0, length);
        rest_.remove_prefix(length);
        return word;
    }

private:
    std::string_view rest_;
};

/// Joins lines that end in a backslash, keeping their number by empty ones.
void join_lines(std::string& text) {
    std::size_t joined = 0;
    std::size_t to = 0;
    for (std::size_t from = 0; from < text.size(); ++from) {
        std::size_t end = from + 1;
        while (text[from] == '\\' && end < text.size() && is_space(text[end]))
            ++end;
        if (text[from] == '\\' && (end >= text.size() || text[end] == '\n')) {
            text[to++] = ' ';
            from = end;
            ++joined;
        } else if (text[from] == '\n') {
            text[to++] = '\n';
            for (; joined > 0 && to < from; --joined)
                text[to++] = '\n';
        } else {
            text[to++] = text[from];
        }
    }
    text.resize(to);
}

/// Checks the part of a corner's text up to a slash: a number of one of `count` things, from 1, or from the
/// last one backwards.
void check_index(std::string_view text, std::size_t count, const char* what, std::size_t line) {
    if (text.empty())
        return;
    long long number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc() || end != text.data() + text.size() || number == 0)
        fail(line, "'" + std::string(text) + "' is no number of a " + what);
    if (static_cast<unsigned long long>(std::abs(number)) > count)
        fail(line, std::string("a face refers to ") + what + " " + std::string(text) +
                       ", but there are only " + std::to_string(count));
}

struct Counts {
    std::size_t vertices = 0;
    std::size_t coordinates = 0;
    std::size_t normals = 0;
};

void check_face(Words words, const Counts& counts, std::size_t line) {
    std::size_t corners = 0;
    for (std::string_view corner = words.next(); !corner.empty() && corner.front() != '#';
         corner = words.next()) {
        ++corners;
        const std::size_t first = corner.find('/');
        const std::string_view rest =
            first == std::string_view::npos ? std::string_view() : corner.substr(first + 1);
        const std::size_t second = rest.find('/');
        if (corner.substr(0, first).empty())
            fail(line, "a corner of a face names no vertex: '" + std::string(corner) + "'");
        check_index(corner.substr(0, first), counts.vertices, "vertex", line);
        check_index(rest.substr(0, second), counts.coordinates, "texture vertex", line);
        if (second != std::string_view::npos)
            check_index(rest.substr(second + 1), counts.normals, "vertex normal", line);
    }
    if (corners < 3)
        fail(line, "a face of " + std::to_string(corners) + " corners");
}

/// Calls use(line, its number) for each line without its end.
template <class Use>
void for_each_line(std::string_view text, Use&& use) {
    std::size_t number = 1;
    for (std::size_t start = 0; start < text.size(); ++number) {
        const std::size_t end = (std::min)(text.find('\n', start), text.size());
        use(text.substr(start, end - start), number);
        start = end + 1;
    }
}

double number_of(std::string_view word) {
    return std::strtod(std::string(word).c_str(), nullptr);
}

glm::dvec3 position_of(Words words) {
    const double x = number_of(words.next());
    const double y = number_of(words.next());
    return {x, y, number_of(words.next())};
}

std::string moved(std::string_view text, const glm::dvec3& origin) {
    std::string result;
    result.reserve(text.size() + text.size() / 8);
    for_each_line(text, [&](std::string_view line, std::size_t) {
        Words words(line);
        if (words.next() == "v") {
            const glm::dvec3 p = position_of(words) - origin;
            char numbers[96];
            std::snprintf(numbers, sizeof numbers, "v %.9g %.9g %.9g", p.x, p.y, p.z);
            result += numbers;
            for (int skipped = 0; skipped < 3; ++skipped)
                words.next();
            for (std::string_view word = words.next(); !word.empty(); word = words.next())
                result.append(" ").append(word);
        } else {
            result += line;
        }
        result += '\n';
    });
    return result;
}

/// Writes numbers such as .5 as 0.5, which Assimp does not take for numbers.
std::string with_zeros(std::string_view text) {
    std::string result;
    result.reserve(text.size() + text.size() / 16);
    for_each_line(text, [&](std::string_view line, std::size_t) {
        const std::size_t start = line.find_first_not_of(" \t");
        const bool is_data = start != std::string_view::npos && line[start] == 'v';
        for (std::size_t i = 0; i < line.size(); ++i) {
            if (is_data && line[i] == '.' && i > 0 && is_space(line[i - 1]))
                result += '0';
            result += line[i];
        }
        result += '\n';
    });
    return result;
}

}  // namespace

ObjText prepare_obj(std::string text) {
    if (text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff"))
        throw std::runtime_error("is in UTF-16; OBJ is read in ASCII or UTF-8");
    join_lines(text);
    if (text.find(" .") != std::string::npos || text.find("\t.") != std::string::npos)
        text = with_zeros(text);
    Counts counts;
    glm::dvec3 low(0.0);
    glm::dvec3 high(0.0);
    for_each_line(text, [&](std::string_view line, std::size_t) {
        Words words(line);
        const std::string_view first = words.next();
        if (first == "v") {
            const glm::dvec3 p = position_of(words);
            low = counts.vertices == 0 ? p : glm::min(low, p);
            high = counts.vertices == 0 ? p : glm::max(high, p);
            ++counts.vertices;
        }
        counts.coordinates += first == "vt" ? 1 : 0;
        counts.normals += first == "vn" ? 1 : 0;
    });
    for_each_line(text, [&](std::string_view line, std::size_t number) {
        Words words(line);
        if (words.next() == "f")
            check_face(words, counts, number);
    });
    const std::optional<glm::dvec3> origin = far_middle(low, high);
    if (!origin)
        return {std::move(text), glm::dvec3(0.0)};
    return {moved(text, *origin), *origin};
}

}  // namespace demo
