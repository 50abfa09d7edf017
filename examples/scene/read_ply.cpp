// SPDX-License-Identifier: MIT
#include "file_bytes.hpp"
#include "image/image.hpp"
#include "isolated.hpp"
#include "model.hpp"
#include "polygon.hpp"
#include "smooth_normals.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace demo {
namespace {

namespace fs = std::filesystem;

/// Types of numbers, by both families of names.
enum class Type { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

constexpr std::pair<std::string_view, Type> type_names[] = {
    {"char", Type::int8},      {"int8", Type::int8},       {"uchar", Type::uint8},
    {"uint8", Type::uint8},    {"short", Type::int16},     {"int16", Type::int16},
    {"ushort", Type::uint16},  {"uint16", Type::uint16},   {"int", Type::int32},
    {"int32", Type::int32},    {"uint", Type::uint32},     {"uint32", Type::uint32},
    {"float", Type::float32},  {"float32", Type::float32}, {"double", Type::float64},
    {"float64", Type::float64}};

Type type_named(const std::string& name) {
    for (const auto& [known, type] : type_names)
        if (known == name)
            return type;
    throw std::runtime_error("is damaged: its PLY header has the type '" + name + "'");
}

std::size_t size_of(Type type) {
    constexpr std::array<std::size_t, 8> sizes{1, 1, 2, 2, 4, 4, 4, 8};
    return sizes[static_cast<std::size_t>(type)];
}

/// The largest value of a colour of that type; 1 for floats.
double largest_of(Type type) {
    constexpr std::array<double, 8> values{127, 255, 32767, 65535, 2147483647, 4294967295, 1, 1};
    return values[static_cast<std::size_t>(type)];
}

struct Property {
    std::string name;
    Type type = Type::float32;
    std::optional<Type> count;  ///< of a list: the type of its length
};

struct Element {
    std::string name;
    std::size_t count = 0;
    std::vector<Property> properties;
};

enum class Format { ascii, little_endian, big_endian };

struct Header {
    Format format = Format::ascii;
    std::vector<Element> elements;
    std::string texture;   ///< name of a picture; empty: none
    std::size_t size = 0;  ///< of the header itself, in bytes
};

/// The bytes that an element takes at least.
std::size_t least_size(const Element& element, Format format) {
    std::size_t size = 0;
    for (const Property& property : element.properties)
        size += format == Format::ascii ? 2 : size_of(property.count.value_or(property.type));
    return size;
}

/// Throws if a file is too short for what its header promises.
void check_size(const Header& header, std::size_t rest) {
    for (const Element& element : header.elements) {
        const std::size_t least = least_size(element, header.format);
        // The last number of a text may end with it.
        if (least > 0 && element.count > (rest + 1) / least)
            throw std::runtime_error("is damaged: " + std::to_string(element.count) + " of the element '" +
                                     element.name + "' are more than the " + std::to_string(rest) +
                                     " bytes that are left for them; it may be cut off");
        rest -= (std::min)(rest, element.count * least);
    }
}

void read_element(std::istringstream& words, std::size_t file_size, Header& header) {
    Element element;
    long long count = -1;
    words >> element.name >> count;
    if (count < 0 || static_cast<std::uintmax_t>(count) > file_size)
        throw std::runtime_error("is damaged: " + std::to_string(count) + " of the element '" + element.name +
                                 "' are more than the file has bytes; it may be cut off");
    element.count = static_cast<std::size_t>(count);
    header.elements.push_back(std::move(element));
}

void read_property(std::istringstream& words, Header& header) {
    if (header.elements.empty())
        throw std::runtime_error("is damaged: its PLY header has a property of no element");
    Property property;
    std::string type;
    words >> type;
    if (type == "list") {
        words >> type;
        property.count = type_named(type);
        words >> type;
    }
    property.type = type_named(type);
    words >> property.name;
    header.elements.back().properties.push_back(std::move(property));
}

/// Programs that write textures name their picture so.
void read_comment(std::istringstream& words, Header& header) {
    std::string keyword;
    words >> keyword;
    if (keyword == "TextureFile" && header.texture.empty()) {
        std::getline(words >> std::ws, header.texture);
        header.texture.erase(header.texture.find_last_not_of(" \t\r") + 1);
    }
}

Header read_header(std::string_view content) {
    constexpr std::size_t longest_header = 65536;
    if (!content.starts_with("ply"))
        throw std::runtime_error("is damaged, or not what its name says");
    Header header;
    bool has_format = false;
    for (std::size_t start = 0; start < (std::min)(content.size(), longest_header);) {
        const std::size_t end = content.find('\n', start);
        if (end == std::string_view::npos)
            break;
        std::istringstream words{std::string(content.substr(start, end - start))};
        start = end + 1;
        std::string keyword;
        words >> keyword;
        if (keyword == "format") {
            std::string name;
            words >> name;
            has_format = true;
            if (name == "binary_little_endian")
                header.format = Format::little_endian;
            else if (name == "binary_big_endian")
                header.format = Format::big_endian;
            else if (name != "ascii")
                throw std::runtime_error("is damaged: its PLY header has the format '" + name + "'");
        } else if (keyword == "comment") {
            read_comment(words, header);
        } else if (keyword == "element") {
            read_element(words, content.size(), header);
        } else if (keyword == "property") {
            read_property(words, header);
        } else if (keyword == "end_header") {
            if (!has_format)
                throw std::runtime_error("is damaged: its PLY header has no format");
            header.size = start;
            check_size(header, content.size() - start);
            return header;
        }
    }
    throw std::runtime_error("is damaged: its PLY header has no end");
}

template <class Value>
double number_at(const char* bytes, bool is_swapped) {
    std::array<char, sizeof(Value)> own;
    std::copy_n(bytes, sizeof(Value), own.begin());
    if (is_swapped)
        std::ranges::reverse(own);
    return static_cast<double>(std::bit_cast<Value>(own));
}

/// The numbers behind the header, one after the other.
class Numbers {
public:
    Numbers(std::string_view content, Format format) : rest_(content), format_(format) {}

    double next(Type type) { return format_ == Format::ascii ? next_word() : next_bytes(type); }

    void check_list(double count, const Property& property) const {
        // An element of a list takes a byte at least.
        if (!(count >= 0.0 && count <= static_cast<double>(rest_.size()) && count == std::floor(count)))
            throw std::runtime_error("is damaged: a list '" + property.name + "' of " +
                                     std::to_string(count) + " numbers; the file may be cut off");
    }

private:
    [[noreturn]] static void fail_at_end() {
        throw std::runtime_error("is damaged: it ends before its last element; it may be cut off");
    }

    double next_word() {
        const std::size_t start = rest_.find_first_not_of(" \t\r\n\v\f");
        if (start == std::string_view::npos)
            fail_at_end();
        rest_.remove_prefix(start);
        const std::size_t length = (std::min)(rest_.find_first_of(" \t\r\n\v\f"), rest_.size());
        const std::string_view word = rest_.substr(rest_.front() == '+' ? 1 : 0, length);
        double value = 0.0;
        const auto [end, error] = std::from_chars(word.data(), rest_.data() + length, value);
        if (end != rest_.data() + length || error == std::errc::invalid_argument)
            throw std::runtime_error("is damaged: '" +
                                     std::string(rest_.substr(0, (std::min)(length, std::size_t{40}))) +
                                     "' is no number");
        rest_.remove_prefix(length);
        return value;
    }

    double next_bytes(Type type) {
        const std::size_t size = size_of(type);
        if (rest_.size() < size)
            fail_at_end();
        const char* bytes = rest_.data();
        rest_.remove_prefix(size);
        const bool is_swapped = (format_ == Format::big_endian) != (std::endian::native == std::endian::big);
        switch (type) {
        case Type::int8:
            return number_at<std::int8_t>(bytes, is_swapped);
        case Type::uint8:
            return number_at<std::uint8_t>(bytes, is_swapped);
        case Type::int16:
            return number_at<std::int16_t>(bytes, is_swapped);
        case Type::uint16:
            return number_at<std::uint16_t>(bytes, is_swapped);
        case Type::int32:
            return number_at<std::int32_t>(bytes, is_swapped);
        case Type::uint32:
            return number_at<std::uint32_t>(bytes, is_swapped);
        case Type::float32:
            return number_at<float>(bytes, is_swapped);
        case Type::float64:
            break;
        }
        return number_at<double>(bytes, is_swapped);
    }

    std::string_view rest_;
    Format format_;
};

/// Which property of the vertices holds what; -1: none does.
class VertexLayout {
public:
    explicit VertexLayout(const Element& element) : element_(element) {
        position = {find({"x"}), find({"y"}), find({"z"})};
        normal = {find({"nx"}), find({"ny"}), find({"nz"})};
        colour = {find({"red", "r", "diffuse_red"}), find({"green", "g", "diffuse_green"}),
                  find({"blue", "b", "diffuse_blue"})};
        coordinate = {find({"s", "u", "texture_u", "tx"}), find({"t", "v", "texture_v", "ty"})};
    }

    template <std::size_t Size>
    static bool has(const std::array<int, Size>& places) {
        return std::ranges::all_of(places, [](int place) { return place >= 0; });
    }

    std::array<int, 3> position{};
    std::array<int, 3> normal{};
    std::array<int, 3> colour{};
    std::array<int, 2> coordinate{};

private:
    int find(std::initializer_list<std::string_view> names) const {
        for (const std::string_view name : names)
            for (std::size_t i = 0; i < element_.properties.size(); ++i)
                if (element_.properties[i].name == name && !element_.properties[i].count)
                    return static_cast<int>(i);
        return -1;
    }

    const Element& element_;
};

glm::dvec3 picked(const std::vector<double>& values, const std::array<int, 3>& places) {
    return {values[static_cast<std::size_t>(places[0])], values[static_cast<std::size_t>(places[1])],
            values[static_cast<std::size_t>(places[2])]};
}

class BodyReader {
public:
    BodyReader(const Header& header, std::string_view content)
        : header_(header), numbers_(content.substr(header.size), header.format) {}

    ModelMesh read() {
        for (const Element& element : header_.elements) {
            if (element.properties.empty())
                continue;
            if (element.name == "vertex")
                read_vertices(element);
            else
                read_others(element);
        }
        return std::move(mesh_);
    }

private:
    void read_vertices(const Element& element) {
        const VertexLayout layout(element);
        if (!VertexLayout::has(layout.position))
            throw std::runtime_error("is damaged: its vertices have no x, y and z");
        const bool has_normals = VertexLayout::has(layout.normal);
        const bool has_colours = VertexLayout::has(layout.colour);
        const bool has_coordinates = VertexLayout::has(layout.coordinate);
        mesh_.positions.reserve(element.count);
        mesh_.normals.reserve(has_normals ? element.count : 0);
        mesh_.colours.reserve(has_colours ? element.count : 0);
        std::vector<double> values(element.properties.size());
        for (std::size_t i = 0; i < element.count; ++i) {
            for (std::size_t p = 0; p < values.size(); ++p)
                values[p] = read_property(element.properties[p], nullptr);
            const glm::dvec3 position = picked(values, layout.position);
            if (!std::isfinite(position.x) || !std::isfinite(position.y) || !std::isfinite(position.z))
                throw std::runtime_error("vertex " + std::to_string(i) + " is not finite: (" +
                                         std::to_string(position.x) + ", " + std::to_string(position.y) +
                                         ", " + std::to_string(position.z) + ")");
            mesh_.positions.push_back(position);
            if (has_normals)
                mesh_.normals.emplace_back(picked(values, layout.normal));
            if (has_colours) {
                glm::vec4 colour(1.0f);
                for (int channel = 0; channel < 3; ++channel) {
                    const auto place =
                        static_cast<std::size_t>(layout.colour[static_cast<std::size_t>(channel)]);
                    colour[channel] = from_srgb(
                        static_cast<float>(values[place] / largest_of(element.properties[place].type)));
                }
                mesh_.colours.push_back(colour);
            }
            if (has_coordinates)
                mesh_.texture_coordinates[0].emplace_back(
                    values[static_cast<std::size_t>(layout.coordinate[0])],
                    1.0 - values[static_cast<std::size_t>(layout.coordinate[1])]);
        }
    }

    /// Faces and strips, and what is of no use here.
    void read_others(const Element& element) {
        std::vector<double> list;
        std::vector<std::uint32_t> corners;
        if (element.name == "face")
            mesh_.indices.reserve(3 * element.count);
        for (std::size_t i = 0; i < element.count; ++i)
            for (const Property& property : element.properties) {
                const bool is_corners =
                    property.count && (property.name == "vertex_indices" || property.name == "vertex_index");
                const bool is_wanted = is_corners && (element.name == "face" || element.name == "tristrips");
                read_property(property, is_wanted ? &list : nullptr);
                if (!is_wanted)
                    continue;
                if (element.name == "face")
                    take_face(list, i, corners);
                else
                    take_strips(list, i);
            }
    }

    /// A number; of a list its length, and its numbers in `list` if that is wanted.
    double read_property(const Property& property, std::vector<double>* list) {
        if (!property.count)
            return numbers_.next(property.type);
        const double count = numbers_.next(*property.count);
        numbers_.check_list(count, property);
        if (list != nullptr)
            list->clear();
        for (auto left = static_cast<std::size_t>(count); left > 0; --left) {
            const double value = numbers_.next(property.type);
            if (list != nullptr)
                list->push_back(value);
        }
        return count;
    }

    static std::uint32_t corner_of(double index, std::size_t face) {
        if (!(index >= 0.0 && index < 4294967295.0))
            throw std::runtime_error("face " + std::to_string(face) + " refers to vertex " +
                                     std::to_string(static_cast<long long>(index)));
        return static_cast<std::uint32_t>(index);
    }

    void take_face(const std::vector<double>& list, std::size_t number, std::vector<std::uint32_t>& corners) {
        corners.clear();
        for (const double index : list)
            corners.push_back(corner_of(index, number));
        if (corners.size() < 3)
            return;
        check_face(corners, number);
        add_polygon(corners, mesh_.positions, mesh_.indices);
    }

    void take_strips(const std::vector<double>& list, std::size_t number) {
        std::size_t start = 0;
        for (std::size_t i = 0; i < list.size(); ++i) {
            if (list[i] < 0.0) {  // begins another strip
                start = i + 1;
                continue;
            }
            if (i < start + 2)
                continue;
            const bool is_odd = (i - start) % 2 != 0;
            const std::array<std::uint32_t, 3> corners{corner_of(list[is_odd ? i - 1 : i - 2], number),
                                                       corner_of(list[is_odd ? i - 2 : i - 1], number),
                                                       corner_of(list[i], number)};
            check_face(corners, number);
            mesh_.indices.insert(mesh_.indices.end(), corners.begin(), corners.end());
        }
    }

    void check_face(std::span<const std::uint32_t> corners, std::size_t number) const {
        for (const std::uint32_t corner : corners)
            if (corner >= mesh_.positions.size())
                throw std::runtime_error("face " + std::to_string(number) + " refers to vertex " +
                                         std::to_string(corner) + ", but there are only " +
                                         std::to_string(mesh_.positions.size()));
    }

    const Header& header_;
    Numbers numbers_;
    ModelMesh mesh_;
};

}  // namespace

Model read_ply(const fs::path& file) {
    auto content = read_whole<std::string>(file);
    const Header header = read_header(content);
    Model model;
    model.meshes.push_back(BodyReader(header, content).read());
    content = std::string();
    ModelMesh& mesh = model.meshes.back();
    mesh.name = "the mesh";
    if (mesh.indices.empty())
        throw std::runtime_error("has no triangles");
    if (mesh.normals.empty())
        smooth_normals(mesh);
    Material material;
    material.name = "material 0";
    material.shadow = ShadowBy::opacity;
    // A scan has its colours; else the grey of what says nothing.
    material.diffuse = glm::vec3(mesh.colours.empty() ? 0.8f : 1.0f);
    if (!header.texture.empty() && !mesh.texture_coordinates[0].empty()) {
        ModelImage image;
        image.name = header.texture;
        try {
            image.encoded = read_whole<std::vector<std::uint8_t>>(file.parent_path() / header.texture);
            allow_file(image.encoded.size());
        } catch (const std::runtime_error&) {
            image.problem = "is not there";
        }
        model.images.push_back(std::move(image));
        material.base_map.texture = 0;
    }
    model.materials.push_back(material);
    return model;
}

}  // namespace demo
