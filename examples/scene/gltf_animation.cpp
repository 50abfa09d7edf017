// SPDX-License-Identifier: MIT
#include "gltf_animation.hpp"

#include "by_name.hpp"

#include <glm/gtc/quaternion.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <vector>

namespace demo {
namespace {

/// The two keys around a time, and how far it is from the first to the second.
struct Place {
    std::size_t first;
    std::size_t second;
    double share;
    double seconds;  ///< between the keys
};

Place place_of(const std::vector<float>& keys, double time) {
    if (!(time > static_cast<double>(keys.front())))
        return {0, 0, 0.0, 0.0};
    const auto after = std::upper_bound(keys.begin(), keys.end(), time, [](double wanted, float key) {
        return wanted < static_cast<double>(key);
    });
    const auto second = static_cast<std::size_t>(after - keys.begin());
    if (second == keys.size())
        return {second - 1, second - 1, 0.0, 0.0};
    const auto start = static_cast<double>(keys[second - 1]);
    const double seconds = static_cast<double>(keys[second]) - start;
    return {second - 1, second, seconds > 0.0 ? (time - start) / seconds : 0.0, seconds};
}

/// The values of one channel of an animation: `width` numbers for each key.
class Channel {
public:
    Channel(const GltfFile& file, const tinygltf::AnimationSampler& sampler, int components,
            const std::string& where)
        : keys_(file.floats(sampler.input, 1)), values_(file.floats(sampler.output, components)),
          interpolation_(sampler.interpolation) {
        const std::size_t parts = is_cubic() ? 3 : 1;  // tangents before and behind each value
        if (keys_.empty() || values_.size() % (parts * keys_.size()) != 0 || values_.empty())
            throw std::runtime_error("is damaged: " + where + " has " + std::to_string(values_.size()) +
                                     " values for " + std::to_string(keys_.size()) + " keys");
        if (!std::ranges::is_sorted(keys_) || std::isnan(keys_.front()) || std::isnan(keys_.back()))
            throw std::runtime_error("is damaged: the keys of " + where + " are not in order");
        width_ = values_.size() / (parts * keys_.size());
    }

    std::size_t width() const { return width_; }
    double last_key() const { return static_cast<double>(keys_.back()); }

    std::vector<double> at(double time, bool is_rotation) const {
        const Place place = place_of(keys_, time);
        if (is_cubic())
            return spline(place);
        if (interpolation_ == "STEP" || place.first == place.second)
            return value(place.first);
        return is_rotation ? turned(place) : between(place);
    }

private:
    bool is_cubic() const { return interpolation_ == "CUBICSPLINE"; }

    std::vector<double> numbers(std::size_t first) const {
        const auto start = values_.begin() + static_cast<std::ptrdiff_t>(first);
        return {start, start + static_cast<std::ptrdiff_t>(width_)};
    }
    std::vector<double> value(std::size_t key) const {
        return numbers(is_cubic() ? (3 * key + 1) * width_ : key * width_);
    }

    std::vector<double> between(const Place& place) const {
        std::vector<double> from = value(place.first);
        const std::vector<double> to = value(place.second);
        for (std::size_t i = 0; i < width_; ++i)
            from[i] += place.share * (to[i] - from[i]);
        return from;
    }

    /// Along the shorter arc.
    std::vector<double> turned(const Place& place) const {
        const auto quaternion = [](const std::vector<double>& v) {
            return glm::normalize(glm::dquat(v[3], v[0], v[1], v[2]));
        };
        const glm::dquat q =
            glm::slerp(quaternion(value(place.first)), quaternion(value(place.second)), place.share);
        return {q.x, q.y, q.z, q.w};
    }

    /// Hermite's cubic, of appendix C of glTF's specification.
    std::vector<double> spline(const Place& place) const {
        std::vector<double> result = value(place.first);
        if (place.first == place.second)
            return result;
        const double t = place.share;
        const std::vector<double> leaving = numbers((3 * place.first + 2) * width_);
        const std::vector<double> to = value(place.second);
        const std::vector<double> arriving = numbers(3 * place.second * width_);
        for (std::size_t i = 0; i < width_; ++i)
            result[i] = (2 * t * t * t - 3 * t * t + 1) * result[i] +
                        place.seconds * (t * t * t - 2 * t * t + t) * leaving[i] +
                        (-2 * t * t * t + 3 * t * t) * to[i] +
                        place.seconds * (t * t * t - t * t) * arriving[i];
        return result;
    }

    std::vector<float> keys_;
    std::vector<float> values_;
    std::string interpolation_;
    std::size_t width_ = 0;
};

int components_of(const std::string& path) {
    if (path == "weights")
        return 1;
    return path == "rotation" ? 4 : 3;
}

void set(tinygltf::Node& node, const std::string& path, std::vector<double> value) {
    // A node that moves must not have a matrix: its parts count.
    node.matrix.clear();
    if (path == "translation")
        node.translation = std::move(value);
    else if (path == "rotation")
        node.rotation = std::move(value);
    else if (path == "scale")
        node.scale = std::move(value);
    else
        node.weights = std::move(value);
}

std::string seconds_text(double time) {
    char text[32];
    std::snprintf(text, sizeof text, "%.6g", time);
    return text;
}

}  // namespace

double pose_at(GltfFile& file, double time, const std::string& wanted) {
    const std::vector<tinygltf::Animation>& animations = file.model().animations;
    std::vector<std::string> names;
    for (const tinygltf::Animation& animation : animations)
        names.push_back(animation.name);
    const std::size_t chosen = number_by_name(names, wanted, "animation");
    if (animations.empty()) {
        file.add_note("the file has no animations: it is the same at all times");
        return 0.0;
    }
    const tinygltf::Animation& animation = animations[chosen];
    double last_key = 0.0;
    for (std::size_t i = 0; i < animation.channels.size(); ++i) {
        const tinygltf::AnimationChannel& channel = animation.channels[i];
        const std::string where = "channel " + std::to_string(i) + " of animation " + std::to_string(chosen) +
                                  " '" + animation.name + "'";
        const std::string& path = channel.target_path;
        if (channel.target_node < 0 ||
            (path != "translation" && path != "rotation" && path != "scale" && path != "weights"))
            continue;  // of an extension
        if (static_cast<std::size_t>(channel.target_node) >= file.nodes().size() || channel.sampler < 0 ||
            static_cast<std::size_t>(channel.sampler) >= animation.samplers.size())
            throw std::runtime_error("is damaged: " + where + " has no node or no sampler");
        const Channel values(file, animation.samplers[static_cast<std::size_t>(channel.sampler)],
                             components_of(path), where);
        if (path != "weights" && values.width() != static_cast<std::size_t>(components_of(path)))
            throw std::runtime_error("is damaged: " + where + " has " + std::to_string(values.width()) +
                                     " numbers a key");
        last_key = (std::max)(last_key, values.last_key());
        set(file.nodes()[static_cast<std::size_t>(channel.target_node)], path,
            values.at(time, path == "rotation"));
    }
    file.add_note("animation " + std::to_string(chosen) + " '" + animation.name + "' is drawn at " +
                  seconds_text(time) + " s" +
                  (animations.size() > 1 && wanted.empty()
                       ? "; the file has " + std::to_string(animations.size()) +
                             ": --animation takes another by its name or number"
                       : ""));
    return last_key;
}

}  // namespace demo
