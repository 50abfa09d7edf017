// SPDX-License-Identifier: MIT
#pragma once

#include "gpu/compute.hpp"
#include "gpu/device_fill.hpp"
#include "gpu/device_shadows.hpp"
#include "gpu/uploaded.hpp"

#include <lightmesh/surface_point.hpp>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

namespace demo {

/// Shadows by a light mesh or a visibility cache, which a host keeps and a device has a copy of. The host
/// finds what shaders ask for in a request buffer. A `Host` has update, begin_frame, merge, snapshot and
/// spent as `DeviceShadows`, and
///
///     void fill(points, cancel);               // finds what shaders lack at points
///     void bind(const Uploaded<Upload>&);      // optional: before each `fill`, the copy as it is
///
/// After an update or a frame's begin it knows what its snapshots know: they have the lights in the order of
/// a new mesh, and know them by whole groups. Where it knew more, it would find nothing to fill for a point
/// that lacks something in a shader.
template <class Host, class Upload>
class KeptShadows : public DeviceShadows {
public:
    std::vector<ComputeBinding> bindings() const override {
        std::vector<ComputeBinding> made = uploaded_.bindings(set);
        made.push_back({.set = set, .binding = Upload::requests_binding, .resource = requests_});
        return made;
    }

    void update(const EmbreeScene& scene, const SceneChange& change) override {
        if (!change.changes_shadows())
            return;
        has_changed_ = true;
        host_.update(scene, change);
    }

    void begin_frame() override {
        if (budget_ == no_budget)
            return;
        has_changed_ = true;
        host_.begin_frame();
        notes_use_ = bytes() > budget_ / 2;
    }

    void merge(std::span<const std::byte> known) override {
        has_changed_ = true;
        host_.merge(known);
    }

    std::vector<std::byte> snapshot() const override { return host_.snapshot(); }
    DeviceFill spent() const override { return host_.spent(); }

protected:
    template <class... OfHost>
    KeptShadows(const ComputeDevice& device, std::size_t budget, std::vector<std::byte> no_requests,
                OfHost&&... of_host)
        : host_(std::forward<OfHost>(of_host)...), uploaded_(device, host_.snapshot()), budget_(budget),
          no_requests_(std::move(no_requests)), requests_(device, no_requests_) {}

    const Host& host() const { return host_; }

    /// Lets a kernel see what the host knows, also of what has changed between pictures, and empties the
    /// request buffer.
    void bind(const ComputeKernel& kernel) {
        if (has_changed_)
            upload();
        for (const ComputeBinding& binding : bindings())
            kernel.bind(binding);
        requests_.write(0, no_requests_);
    }

    std::vector<std::byte> requests() const { return requests_.read_all<std::byte>(); }

    /// Finds what shaders lack at points. Returns how many bytes of it were new to the device.
    std::size_t fill(std::span<const lightmesh::SurfacePoint> points, const std::atomic<bool>* cancel) {
        find(points, cancel);
        return upload();
    }

    /// Tells the host what shaders have used in a round, if something may soon be forgotten: where half of
    /// the budget was taken when the frame began.
    void note_use(const Round& round, const std::atomic<bool>* cancel) {
        if (notes_use_)
            find(round.points(pixels_of_use).points, cancel);
    }

private:
    /// One in so many points tells: a brick, or a record, is seen from many. They are the same pixels in each
    /// frame: what only others see is forgotten, and found again. Each round all paths and points are read
    /// for it, 80 bytes a pixel.
    static constexpr std::uint32_t pixels_of_use = 7;
    static constexpr std::size_t no_budget = (std::numeric_limits<std::size_t>::max)();

    std::size_t upload() {
        const std::size_t written = uploaded_.update(host_.snapshot());
        has_changed_ = false;
        return written;
    }

    void find(std::span<const lightmesh::SurfacePoint> points, const std::atomic<bool>* cancel) {
        if constexpr (requires { host_.bind(uploaded_); })
            host_.bind(uploaded_);
        host_.fill(points, cancel);
    }

    Host host_;
    Uploaded<Upload> uploaded_;
    std::size_t budget_;
    bool notes_use_ = false;
    bool has_changed_ = false;  ///< between pictures, since the last upload
    std::vector<std::byte> no_requests_;
    ComputeBuffer requests_;
};

}  // namespace demo
