// SPDX-License-Identifier: MIT
#include "gltf_file.hpp"

#include "file_bytes.hpp"
#include "isolated.hpp"

#include <meshoptimizer.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <string_view>

namespace demo {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// glTF needs some ten levels; extras may have more.
constexpr int deepest_nesting = 128;

int hexadecimal(char c) {
    if (c >= '0' && c <= '9')
        return c - '0';
    if (c >= 'a' && c <= 'f')
        return c - 'a' + 10;
    return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

std::string percent_decoded(std::string_view text) {
    std::string decoded;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] == '%' && i + 2 < text.size() && hexadecimal(text[i + 1]) >= 0 &&
            hexadecimal(text[i + 2]) >= 0) {
            decoded.push_back(static_cast<char>(16 * hexadecimal(text[i + 1]) + hexadecimal(text[i + 2])));
            i += 2;
        } else {
            decoded.push_back(text[i]);
        }
    }
    return decoded;
}

Bytes base64_decoded(std::string_view text) {
    static const std::array<std::int8_t, 256> values = [] {
        std::array<std::int8_t, 256> made{};
        made.fill(-1);
        const std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
        for (std::size_t i = 0; i < digits.size(); ++i)
            made[static_cast<unsigned char>(digits[i])] = static_cast<std::int8_t>(i);
        made[static_cast<unsigned char>('-')] = 62;
        made[static_cast<unsigned char>('_')] = 63;
        return made;
    }();
    Bytes bytes;
    bytes.reserve(text.size() / 4 * 3 + 3);
    std::uint32_t bits = 0;
    int held = 0;
    for (const char c : text) {
        const int value = values[static_cast<unsigned char>(c)];
        if (value < 0)
            continue;  // padding and line breaks
        bits = bits << 6 | static_cast<std::uint32_t>(value);
        held += 6;
        if (held >= 8) {
            held -= 8;
            bytes.push_back(static_cast<std::uint8_t>(bits >> held));
        }
    }
    return bytes;
}

/// Throws if brackets nest deeper than what may be read by recursion.
void check_nesting(std::string_view text) {
    int depth = 0;
    bool in_string = false;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (in_string) {
            if (c == '\\')
                ++i;
            in_string = c != '"';
        } else if (c == '"') {
            in_string = true;
        } else if (c == '[' || c == '{') {
            if (++depth > deepest_nesting)
                throw std::runtime_error("its JSON is nested deeper than " + std::to_string(deepest_nesting) +
                                         " levels");
        } else if (c == ']' || c == '}') {
            --depth;
        }
    }
}

std::uint32_t little_endian(const Bytes& bytes, std::size_t at) {
    return bytes[at] | static_cast<std::uint32_t>(bytes[at + 1]) << 8 |
           static_cast<std::uint32_t>(bytes[at + 2]) << 16 | static_cast<std::uint32_t>(bytes[at + 3]) << 24;
}

/// The JSON of a file, and its binary chunk if it is a GLB that has one.
struct Chunks {
    std::string json;
    Bytes binary;
};

Chunks split(Bytes bytes) {
    constexpr std::size_t header = 12;
    constexpr std::size_t chunk_header = 8;
    const bool is_binary = bytes.size() >= 4 && std::memcmp(bytes.data(), "glTF", 4) == 0;
    if (!is_binary)
        return {std::string(bytes.begin(), bytes.end()), {}};
    if (bytes.size() < header + chunk_header)
        throw std::runtime_error("is damaged: a GLB of " + std::to_string(bytes.size()) + " bytes");
    if (const std::uint32_t version = little_endian(bytes, 4); version != 2)
        throw std::runtime_error("is a GLB of version " + std::to_string(version) +
                                 "; only version 2 can be read");
    Chunks chunks;
    for (std::size_t at = header; at + chunk_header <= bytes.size();) {
        const std::size_t length = little_endian(bytes, at);
        const std::uint32_t kind = little_endian(bytes, at + 4);
        const std::size_t start = at + chunk_header;
        if (length > bytes.size() - start)
            throw std::runtime_error("is damaged: a chunk of the GLB says that it has " +
                                     std::to_string(length) + " bytes, but only " +
                                     std::to_string(bytes.size() - start) +
                                     " follow; the file may be cut off");
        const auto first = bytes.begin() + static_cast<std::ptrdiff_t>(start);
        const auto last = first + static_cast<std::ptrdiff_t>(length);
        if (kind == 0x4E4F534A && chunks.json.empty())
            chunks.json.assign(first, last);
        else if (kind == 0x004E4942 && chunks.binary.empty())
            chunks.binary.assign(first, last);
        at = start + length;
    }
    return chunks;
}

/// A member that must be a number of something, or `otherwise` if it is not there.
std::uint64_t count_in(const json& object, const char* name, std::uint64_t otherwise) {
    const auto found = object.find(name);
    if (found == object.end())
        return otherwise;
    if (!found->is_number_unsigned())
        throw std::runtime_error(std::string("is damaged: '") + name + "' is " + found->dump() +
                                 ", not a number of something");
    return found->get<std::uint64_t>();
}

std::string text_in(const json& object, const char* name) {
    const auto found = object.find(name);
    return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

/// Takes an array of objects out of the JSON.
json taken(json& document, const char* name) {
    const auto found = document.find(name);
    if (found == document.end())
        return json::array();
    json array = std::move(*found);
    document.erase(name);
    if (!array.is_array() || !std::ranges::all_of(array, [](const json& e) { return e.is_object(); }))
        throw std::runtime_error(std::string("is damaged: '") + name + "' is no list of objects");
    return array;
}

double number_in(const json& object, const char* name, double otherwise) {
    const auto found = object.find(name);
    return found != object.end() && found->is_number() ? found->get<double>() : otherwise;
}

/// One light of KHR_lights_punctual. Values that no light can have become the nearest that one can, with a
/// note; a light of strength 0 stays, to be counted.
ModelLight light_of(const json& source, std::size_t number, std::vector<std::string>& notes) {
    constexpr double right_angle = 1.5707963267948966;
    ModelLight light;
    light.name = text_in(source, "name");
    const std::string where =
        "light " + std::to_string(number) + (light.name.empty() ? "" : " '" + light.name + "'");
    if (light.name.empty())
        light.name = std::to_string(number);
    const std::string type = text_in(source, "type");
    if (type == "directional")
        light.kind = ModelLight::Kind::directional;
    else if (type == "spot")
        light.kind = ModelLight::Kind::spot;
    else if (type != "point")
        throw std::runtime_error("is damaged: " + where + " has the type '" + type + "'");
    const auto colour = source.find("color");
    const double intensity = number_in(source, "intensity", 1.0);
    for (int channel = 0; channel < 3; ++channel) {
        double share = 1.0;
        if (colour != source.end() && colour->is_array() && colour->size() >= 3 &&
            (*colour)[static_cast<std::size_t>(channel)].is_number())
            share = (*colour)[static_cast<std::size_t>(channel)].get<double>();
        const double strength = intensity * share;
        if (!(strength >= 0.0) || !(strength <= 1e37))
            throw std::runtime_error(where + " has the strength " + std::to_string(strength));
        light.intensity[channel] = static_cast<float>(strength);
    }
    if (const double range = number_in(source, "range", 0.0); range > 0.0)
        light.range = static_cast<float>(range);
    else if (source.contains("range"))
        notes.push_back(where + " has the range " + std::to_string(range) + ": taken as without limit");
    const json spot = source.contains("spot") && source["spot"].is_object() ? source["spot"] : json::object();
    const double outer = number_in(spot, "outerConeAngle", 0.7853981633974483);
    if (light.kind == ModelLight::Kind::spot && outer > right_angle)
        notes.push_back(where + " has a cone of " + std::to_string(outer) + ": taken as half a sphere");
    light.outer_cone = static_cast<float>((std::min)(outer, right_angle));
    light.inner_cone = static_cast<float>((std::max)(0.0, number_in(spot, "innerConeAngle", 0.0)));
    return light;
}

bool is_fallback(const json& buffer) {
    for (const char* extension : {"EXT_meshopt_compression", "KHR_meshopt_compression"})
        if (buffer.contains("extensions") && buffer["extensions"].contains(extension))
            return true;
    return false;
}

std::size_t size_of_component(int type) {
    switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return 1;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return 2;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
        return 4;
    default:
        throw std::runtime_error("is damaged: an accessor's componentType is " + std::to_string(type));
    }
}

int components_of_type(int type) {
    switch (type) {
    case TINYGLTF_TYPE_SCALAR:
        return 1;
    case TINYGLTF_TYPE_VEC2:
        return 2;
    case TINYGLTF_TYPE_VEC3:
        return 3;
    case TINYGLTF_TYPE_VEC4:
        return 4;
    case TINYGLTF_TYPE_MAT4:
        return 16;
    default:
        return 0;
    }
}

template <class Value>
Value value_at(const std::uint8_t* bytes) {
    Value value;
    std::memcpy(&value, bytes, sizeof(Value));
    return value;
}

/// One component as a double, and the largest value of its type: 0 for floats.
struct Component {
    double value;
    double largest;
};

Component component_at(const std::uint8_t* bytes, int type) {
    switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
        return {static_cast<double>(value_at<std::int8_t>(bytes)), 127.0};
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return {static_cast<double>(*bytes), 255.0};
    case TINYGLTF_COMPONENT_TYPE_SHORT:
        return {static_cast<double>(value_at<std::int16_t>(bytes)), 32767.0};
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return {static_cast<double>(value_at<std::uint16_t>(bytes)), 65535.0};
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
        return {static_cast<double>(value_at<std::uint32_t>(bytes)), 4294967295.0};
    default:
        return {static_cast<double>(value_at<float>(bytes)), 0.0};
    }
}

/// A number in an extension, or `otherwise`.
double number_in(const tinygltf::Value& object, const char* name, double otherwise) {
    return object.Has(name) && object.Get(name).IsNumber() ? object.Get(name).GetNumberAsDouble() : otherwise;
}

/// The words of EXT_meshopt_compression about a buffer view; null if nothing.
const tinygltf::Value* meshopt_of(const tinygltf::BufferView& view) {
    for (const char* name : {"EXT_meshopt_compression", "KHR_meshopt_compression"})
        if (const auto found = view.extensions.find(name); found != view.extensions.end())
            return &found->second;
    return nullptr;
}

Bytes meshopt_decoded(const tinygltf::Value& extension, std::span<const std::uint8_t> source,
                      const std::string& where) {
    const auto count = static_cast<std::size_t>(number_in(extension, "count", 0.0));
    const auto stride = static_cast<std::size_t>(number_in(extension, "byteStride", 0.0));
    const std::string mode = extension.Has("mode") ? extension.Get("mode").Get<std::string>() : "";
    const std::string filter =
        extension.Has("filter") ? extension.Get("filter").Get<std::string>() : std::string("NONE");
    const bool is_vertices = mode == "ATTRIBUTES";
    const bool fits =
        is_vertices ? stride > 0 && stride <= 256 && stride % 4 == 0 : stride == 2 || stride == 4;
    // A vertex takes a 64th of its size at least, and a triangle or an index a byte.
    const double least = static_cast<double>(count) * (is_vertices ? static_cast<double>(stride) / 64.0
                                                       : mode == "TRIANGLES" ? 1.0 / 3.0
                                                                             : 1.0);
    if (!fits || least > static_cast<double>(source.size()) || (mode == "TRIANGLES" && count % 3 != 0))
        throw std::runtime_error("is damaged: the compression of " + where + " has count " +
                                 std::to_string(count) + " and byteStride " + std::to_string(stride) +
                                 " for " + std::to_string(source.size()) + " bytes");
    allow_memory(4 * count * stride);
    Bytes decoded(count * stride);
    int failed = 1;
    if (is_vertices)
        failed = meshopt_decodeVertexBuffer(decoded.data(), count, stride, source.data(), source.size());
    else if (mode == "TRIANGLES")
        failed = meshopt_decodeIndexBuffer(decoded.data(), count, stride, source.data(), source.size());
    else if (mode == "INDICES")
        failed = meshopt_decodeIndexSequence(decoded.data(), count, stride, source.data(), source.size());
    if (failed != 0)
        throw std::runtime_error("is damaged: " + where + " cannot be decompressed (" + mode + ")");
    // The decoders work on vectors of four; what is left over they take as a shorter one.
    if (filter == "OCTAHEDRAL" && (stride == 4 || stride == 8))
        meshopt_decodeFilterOct(decoded.data(), count, stride);
    else if (filter == "QUATERNION" && stride == 8)
        meshopt_decodeFilterQuat(decoded.data(), count, stride);
    else if (filter == "EXPONENTIAL" && stride % 4 == 0)
        meshopt_decodeFilterExp(decoded.data(), count, stride);
    else if (filter != "NONE")
        throw std::runtime_error("is damaged: " + where + " has the filter '" + filter +
                                 "' with byteStride " + std::to_string(stride));
    return decoded;
}

}  // namespace

Bytes read_uri(const std::string& uri, const fs::path& folder) {
    if (uri.starts_with("data:")) {
        const std::size_t comma = uri.find(',');
        if (comma == std::string::npos)
            throw std::runtime_error("is damaged: a data URI without a comma");
        const std::string_view content = std::string_view(uri).substr(comma + 1);
        if (uri.substr(0, comma).ends_with(";base64"))
            return base64_decoded(content);
        const std::string decoded = percent_decoded(content);
        return {decoded.begin(), decoded.end()};
    }
    if (uri.find("://") != std::string::npos)
        throw std::runtime_error("refers to '" + uri + "'; only files can be read");
    // Exporters that do not encode exist: a file of that very name comes first.
    const fs::path plain = folder / uri;
    std::error_code ignored;
    auto bytes = read_whole<Bytes>(fs::exists(plain, ignored) ? plain : folder / percent_decoded(uri));
    allow_file(bytes.size());
    return bytes;
}

const tinygltf::Value* gltf_extension(const tinygltf::ExtensionMap& extensions, const char* name) {
    const auto found = extensions.find(name);
    return found == extensions.end() ? nullptr : &found->second;
}

GltfFile::GltfFile(const fs::path& file) : folder_(file.parent_path()) {
    Chunks chunks = split(read_whole<Bytes>(file));
    check_nesting(chunks.json);
    // Small objects take many times the place of their text, once as they are and once as tinygltf has them.
    allow_memory(40 * chunks.json.size());
    json document = json::parse(chunks.json, nullptr, false);
    chunks.json = std::string();
    if (document.is_discarded() || !document.is_object())
        throw std::runtime_error("is damaged, or not what its name says");
    const json asset = document.contains("asset") ? document["asset"] : json();
    if (const std::string version = asset.is_object() ? text_in(asset, "version") : "";
        !version.starts_with("2."))
        throw std::runtime_error(version.empty()
                                     ? "does not say its version of glTF; only version 2 can be read"
                                     : "is glTF of version '" + version + "'; only version 2 can be read");
    json buffers = taken(document, "buffers");
    for (json& buffer : buffers) {
        const std::uint64_t length = count_in(buffer, "byteLength", 0);
        const std::string where = "buffer " + std::to_string(buffers_.size());
        auto uri = buffer.find("uri");
        Bytes bytes;
        if (uri != buffer.end() && uri->is_string())
            bytes = read_uri(uri->get_ref<const std::string&>(), folder_);
        else if (buffers_.empty() && !chunks.binary.empty())
            bytes = std::move(chunks.binary);
        else if (!is_fallback(buffer))
            throw std::runtime_error("is damaged: " + where + " has no URI, and the file no binary chunk");
        buffer.clear();
        if (bytes.size() < length && !bytes.empty())
            throw std::runtime_error("is damaged: " + where + " should have " + std::to_string(length) +
                                     " bytes, but has " + std::to_string(bytes.size()));
        buffers_.push_back(std::move(bytes));
    }
    const json images = taken(document, "images");
    for (const json& image : images)
        images_.push_back({text_in(image, "name"), text_in(image, "uri"),
                           static_cast<int>(count_in(image, "bufferView", static_cast<std::uint64_t>(-1)))});
    // tinygltf refuses indices that only a compressed mesh has.
    if (auto meshes = document.find("meshes"); meshes != document.end() && meshes->is_array())
        for (json& mesh : *meshes)
            if (mesh.is_object() && mesh.contains("primitives") && mesh["primitives"].is_array())
                for (json& primitive : mesh["primitives"])
                    if (primitive.is_object() && primitive.contains("extensions") &&
                        primitive["extensions"].contains("KHR_draco_mesh_compression"))
                        primitive.erase("indices");
    // It also refuses lights that leave their cone to the default.
    if (auto extensions = document.find("extensions"); extensions != document.end() &&
                                                       extensions->is_object() &&
                                                       extensions->contains("KHR_lights_punctual")) {
        for (const json& light : taken((*extensions)["KHR_lights_punctual"], "lights"))
            lights_.push_back(light_of(light, lights_.size(), notes_));
        extensions->erase("KHR_lights_punctual");
    }
    const std::string text = document.dump(-1, ' ', false, json::error_handler_t::replace);
    document = json();
    if (text.size() > std::numeric_limits<unsigned>::max())
        throw std::runtime_error("has more than 4 GB of JSON");
    std::string error;
    std::string warning;
    tinygltf::TinyGLTF reader;
    if (!reader.LoadASCIIFromString(&model_, &error, &warning, text.data(),
                                    static_cast<unsigned>(text.size()), "")) {
        std::ranges::replace(error, '\n', ' ');
        throw std::runtime_error("is damaged: " + error.substr(0, error.find_last_not_of(' ') + 1));
    }
}

ModelImage GltfFile::image(std::size_t number) const {
    const ImageSource& source = images_[number];
    ModelImage image;
    image.name = source.name;
    if (image.name.empty())
        image.name =
            source.uri.empty() || source.uri.starts_with("data:") ? std::to_string(number) : source.uri;
    try {
        if (!source.uri.empty()) {
            image.encoded = read_uri(source.uri, folder_);
        } else {
            const auto bytes = view(source.buffer_view);
            image.encoded.assign(bytes.begin(), bytes.end());
        }
    } catch (const std::exception& error) {
        image.problem = error.what();
    }
    return image;
}

std::span<const std::uint8_t> GltfFile::view(int number) const {
    const std::string where = "buffer view " + std::to_string(number);
    if (number < 0 || static_cast<std::size_t>(number) >= model_.bufferViews.size())
        throw std::runtime_error("is damaged: there is no " + where);
    const tinygltf::BufferView& view = model_.bufferViews[static_cast<std::size_t>(number)];
    const auto part = [&](double buffer, double offset, double length) {
        const bool is_there = buffer >= 0.0 && buffer < static_cast<double>(buffers_.size());
        const double size =
            is_there ? static_cast<double>(buffers_[static_cast<std::size_t>(buffer)].size()) : 0.0;
        if (!is_there || !(offset >= 0.0 && length >= 0.0 && offset + length <= size))
            throw std::runtime_error("is damaged: " + where + " reaches beyond its buffer");
        return std::span(buffers_[static_cast<std::size_t>(buffer)])
            .subspan(static_cast<std::size_t>(offset), static_cast<std::size_t>(length));
    };
    if (const tinygltf::Value* extension = meshopt_of(view)) {
        const auto found = decompressed_.find(number);
        if (found != decompressed_.end())
            return found->second;
        const auto source =
            part(number_in(*extension, "buffer", -1.0), number_in(*extension, "byteOffset", 0.0),
                 number_in(*extension, "byteLength", -1.0));
        return decompressed_.emplace(number, meshopt_decoded(*extension, source, where)).first->second;
    }
    return part(view.buffer, static_cast<double>(view.byteOffset), static_cast<double>(view.byteLength));
}

const tinygltf::Accessor& GltfFile::accessor(int number) const {
    if (number < 0 || static_cast<std::size_t>(number) >= model_.accessors.size())
        throw std::runtime_error("is damaged: there is no accessor " + std::to_string(number));
    return model_.accessors[static_cast<std::size_t>(number)];
}

std::size_t GltfFile::count(int number) const {
    return accessor(number).count;
}

int GltfFile::components(int number) const {
    return components_of_type(accessor(number).type);
}

template <class Value, class Convert>
std::vector<Value> GltfFile::read(int number, int components, Convert&& convert) const {
    const tinygltf::Accessor& source = accessor(number);
    const std::string where = "accessor " + std::to_string(number);
    if (components_of_type(source.type) != components)
        throw std::runtime_error("is damaged: " + where + " has " +
                                 std::to_string(components_of_type(source.type)) + " components, not " +
                                 std::to_string(components));
    const std::size_t width = size_of_component(source.componentType);
    const auto per_element = static_cast<std::size_t>(components);
    // Strided values of a view, of which `count` must lie within it.
    const auto values = [&](int view_number, std::size_t offset, std::size_t count, std::size_t element,
                            std::size_t stride) {
        const auto bytes = view(view_number);
        if (offset > bytes.size() || (count > 0 && (bytes.size() - offset < element ||
                                                    (bytes.size() - offset - element) / stride < count - 1)))
            throw std::runtime_error("is damaged: " + where + " has " + std::to_string(count) +
                                     " elements, more than its buffer view holds");
        return bytes.data() + offset;
    };
    std::vector<Value> result;
    const auto convert_all = [&](const std::uint8_t* from, Value* to) {
        for (std::size_t c = 0; c < per_element; ++c)
            to[c] = convert(component_at(from + c * width, source.componentType), source.normalized);
    };
    if (source.bufferView >= 0) {
        static_cast<void>(view(source.bufferView));  // is there, or throws
        const auto& declared = model_.bufferViews.at(static_cast<std::size_t>(source.bufferView));
        const std::size_t stride = declared.byteStride > 0 ? declared.byteStride : width * per_element;
        const std::uint8_t* from =
            values(source.bufferView, source.byteOffset, source.count, width * per_element, stride);
        result.resize(source.count * per_element);
        for (std::size_t i = 0; i < source.count; ++i)
            convert_all(from + i * stride, &result[i * per_element]);
    } else {
        constexpr std::size_t most_zeros = std::size_t{1} << 24;
        if (source.count > most_zeros)
            throw std::runtime_error("is damaged: " + where + " has " + std::to_string(source.count) +
                                     " elements, but no buffer view");
        result.assign(source.count * per_element, Value{0});
    }
    if (source.sparse.isSparse && source.sparse.count > 0) {
        const auto count = static_cast<std::size_t>(source.sparse.count);
        const std::size_t index_width = size_of_component(source.sparse.indices.componentType);
        const std::uint8_t* indices = values(source.sparse.indices.bufferView,
                                             static_cast<std::size_t>(source.sparse.indices.byteOffset),
                                             count, index_width, index_width);
        const std::uint8_t* replacements =
            values(source.sparse.values.bufferView, static_cast<std::size_t>(source.sparse.values.byteOffset),
                   count, width * per_element, width * per_element);
        for (std::size_t i = 0; i < count; ++i) {
            const double index =
                component_at(indices + i * index_width, source.sparse.indices.componentType).value;
            if (!(index >= 0.0 && index < static_cast<double>(source.count)))
                throw std::runtime_error("is damaged: a sparse index of " + where + " is out of range");
            convert_all(replacements + i * width * per_element,
                        &result[static_cast<std::size_t>(index) * per_element]);
        }
    }
    return result;
}

std::vector<float> GltfFile::floats(int number, int components) const {
    return read<float>(number, components, [](Component c, bool normalized) {
        const double value = normalized && c.largest > 0.0 ? (std::max)(c.value / c.largest, -1.0) : c.value;
        return static_cast<float>(value);
    });
}

std::vector<std::uint32_t> GltfFile::integers(int number, int components) const {
    return read<std::uint32_t>(number, components, [](Component c, bool) {
        return c.value >= 0.0 && c.largest > 0.0 ? static_cast<std::uint32_t>(c.value) : 0u;
    });
}

}  // namespace demo
