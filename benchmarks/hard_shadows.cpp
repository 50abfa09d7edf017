// SPDX-License-Identifier: MIT
#include "contestant.hpp"
#include "embree_rays.hpp"
#include "surface_end.hpp"

#include <algorithm>
#include <array>
#include <functional>
#include <stdexcept>

namespace bench {

namespace {

/// The points of a tile that face a light.
struct Facing {
    std::array<std::uint16_t, ShadingPoints::most_in_tile> points;
    std::size_t size = 0;
};

class HardShadows : public Contestant {
public:
    explicit HardShadows(const Workload& workload) : workload_(workload) {}

    std::uint64_t rays(const Points& points) const override {
        std::uint64_t count = 0;
        for (std::size_t i = 0; i < points.size(); ++i)
            for (std::size_t l = 0; l < workload_.lights.size(); ++l)
                count += workload_.faces(l, points.positions[i], points.normals[i]) ? 1 : 0;
        return count;
    }

protected:
    const Workload& workload() const { return workload_; }
    RTCScene scene() const { return workload_.scene.handle(); }

private:
    const Workload& workload_;
};

class SingleRays final : public HardShadows {
public:
    using HardShadows::HardShadows;

    void find(const Points& points, std::span<float> lit) const override {
        Occlusion occlusion(scene(), false);
        const std::vector<glm::vec3>& lights = workload().lights;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const glm::vec3 origin = surface_end(points.positions[i], points.normals[i]);
            for (std::size_t l = 0; l < lights.size(); ++l) {
                float& value = lit[i * lights.size() + l];
                value = 0.0f;
                if (!workload().faces(l, points.positions[i], points.normals[i]))
                    continue;
                RTCRay ray = make_ray(origin, lights[l]);
                occlusion.trace(ray);
                value = ray.tfar < 0.0f ? 0.0f : 1.0f;
            }
        }
    }
};

/// Light by light, the points that face it gathered, so that no place of a packet stays empty but in the last
/// one.
class GatheredRays : public HardShadows {
public:
    GatheredRays(const Workload& workload, bool coherent) : HardShadows(workload), coherent_(coherent) {}

    void find(const Points& points, std::span<float> lit) const override {
        Occlusion occlusion(scene(), coherent_);
        std::array<glm::vec3, ShadingPoints::most_in_tile> origins;
        for (std::size_t i = 0; i < points.size(); ++i)
            origins[i] = surface_end(points.positions[i], points.normals[i]);
        std::ranges::fill(lit, 0.0f);
        const std::size_t stride = workload().lights.size();
        for (std::size_t l = 0; l < stride; ++l) {
            Facing facing;
            for (std::size_t i = 0; i < points.size(); ++i) {
                facing.points[facing.size] = static_cast<std::uint16_t>(i);
                facing.size += workload().faces(l, points.positions[i], points.normals[i]) ? 1 : 0;
            }
            trace(occlusion, workload().lights[l], origins.data(), facing, lit.data() + l, stride);
        }
    }

protected:
    /// `lit` is that of the light: the one of point i at lit[i * stride].
    virtual void trace(Occlusion& occlusion, const glm::vec3& light, const glm::vec3* origins,
                       const Facing& facing, float* lit, std::size_t stride) const = 0;

private:
    bool coherent_;
};

template <class Packet, std::size_t width>
class Packets final : public GatheredRays {
public:
    using GatheredRays::GatheredRays;

protected:
    void trace(Occlusion& occlusion, const glm::vec3& light, const glm::vec3* origins, const Facing& facing,
               float* lit, std::size_t stride) const override {
        alignas(64) Packet rays;
        alignas(64) std::array<int, width> valid;
        for (std::size_t first = 0; first < facing.size; first += width) {
            const std::size_t count = (std::min)(width, facing.size - first);
            for (std::size_t k = 0; k < width; ++k) {
                valid[k] = k < count ? -1 : 0;
                // A place that is not valid gets the last ray again: Embree must find numbers there.
                set_ray(rays, k, origins[facing.points[first + (std::min)(k, count - 1)]], light);
            }
            occlusion.trace(valid.data(), rays);
            for (std::size_t k = 0; k < count; ++k)
                lit[facing.points[first + k] * stride] = rays.tfar[k] < 0.0f ? 0.0f : 1.0f;
        }
    }
};

#if RTC_VERSION_MAJOR < 4
class Streams final : public GatheredRays {
public:
    using GatheredRays::GatheredRays;

protected:
    void trace(Occlusion& occlusion, const glm::vec3& light, const glm::vec3* origins, const Facing& facing,
               float* lit, std::size_t stride) const override {
        std::array<RTCRay, ShadingPoints::most_in_tile> rays;
        for (std::size_t k = 0; k < facing.size; ++k)
            rays[k] = make_ray(origins[facing.points[k]], light);
        occlusion.trace_stream(rays.data(), facing.size);
        for (std::size_t k = 0; k < facing.size; ++k)
            lit[facing.points[k] * stride] = rays[k].tfar < 0.0f ? 0.0f : 1.0f;
    }
};
#endif

struct Form {
    std::string name;
    std::function<std::unique_ptr<Contestant>(const Workload&)> make;
};

template <class Rays>
Form gathered(const std::string& name, bool coherent) {
    return {name, [coherent](const Workload& workload) {
                return std::make_unique<Rays>(workload, coherent);
            }};
}

const std::vector<Form>& forms() {
    static const std::vector<Form> all {
        {"single",
         [](const Workload& workload) {
             return std::make_unique<SingleRays>(workload);
         }},
            gathered<Packets<RTCRay8, 8>>("packet8", false),
            gathered<Packets<RTCRay8, 8>>("packet8-coherent", true),
            gathered<Packets<RTCRay16, 16>>("packet16", false),
            gathered<Packets<RTCRay16, 16>>("packet16-coherent", true),
#if RTC_VERSION_MAJOR < 4
            gathered<Streams>("stream", false), gathered<Streams>("stream-coherent", true),
#endif
    };
    return all;
}

}  // namespace

const std::vector<std::string>& hard_forms() {
    static const std::vector<std::string> names = [] {
        std::vector<std::string> list;
        for (const Form& form : forms())
            list.push_back(form.name);
        return list;
    }();
    return names;
}

std::unique_ptr<Contestant> make_hard_shadows(const Workload& workload, const std::string& form) {
    for (const Form& candidate : forms())
        if (candidate.name == form)
            return candidate.make(workload);
    throw std::invalid_argument("there is no form '" + form + "' of hard shadow rays");
}

}  // namespace bench
