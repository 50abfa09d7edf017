// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

/// Compute shaders on a Vulkan 1.1 device: buffers, pipelines, submissions. What fails throws
/// std::runtime_error with one sentence that names the device: no driver (and what to install), no device of
/// the wanted name (and those that there are), a device that cannot compute or lacks a feature, memory that
/// is exhausted, a device that was lost.

namespace demo {

/// Invocations of a work group, in all shaders here.
inline constexpr std::uint32_t group_size = 64;

/// Which device, and what to watch.
struct ComputeOptions {
    /// As `VulkanDepthOptions::device`.
    std::string device = {};
    /// Runs under VK_LAYER_KHRONOS_validation, which must be installed.
    bool validate = false;
    /// Called for each warning and error of the layers, where they report it.
    std::function<void(const std::string&)> on_message = {};
    /// Lets shaders ask ray queries; true where the device has none is an error. nullopt: lets them on a GPU
    /// that has them, not on a CPU that plays one, which traces rays faster by shaders alone.
    std::optional<bool> ray_queries = std::nullopt;
};

class ComputeBuffer;
class ComputeTriangles;
class ComputeKernel;
class ComputeCommands;

/// A device with one queue. Copies are the same device; calls wait for each other.
class ComputeDevice {
public:
    explicit ComputeDevice(const ComputeOptions& options = {});
    /// The same device opened anew, with or without ray queries, not validated.
    ComputeDevice opened_anew(bool ray_queries) const;

    std::string name() const;
    /// Its driver with the version, such as "llvmpipe Mesa 22.3.6 (LLVM 15.0.6)".
    std::string driver() const;
    /// True if shaders may ask ray queries.
    bool has_ray_queries() const;
    /// True if it is a CPU that plays a GPU.
    bool is_cpu() const;
    /// The most bytes of a buffer that a shader can see.
    std::size_t largest_buffer() const;

    /// Records commands by `record`, submits them once and waits until they are done. Returns the seconds
    /// that the device took, by its own clock if it has one.
    double run(const std::function<void(const ComputeCommands&)>& record) const;

    /// The least of the times that run() returns: it is called at least five times, and until a second is
    /// spent, since the clocks of GPUs rise with work, and slowly. On a CPU it is called once.
    double least_time(const std::function<double()>& run) const;

private:
    friend ComputeBuffer;
    friend ComputeTriangles;
    friend ComputeKernel;
    friend ComputeCommands;
    struct State;
    std::shared_ptr<State> state_;
};

/// Bytes to be written to a buffer, from a place on.
struct ComputeWrite {
    std::size_t offset;
    std::span<const std::byte> bytes;
};

/// Memory of the device that shaders see. Copies are the same memory.
class ComputeBuffer {
public:
    /// Of `size` bytes, all 0; of no bytes there are 16.
    ComputeBuffer(const ComputeDevice& device, std::size_t size);
    /// With a copy of `bytes`.
    ComputeBuffer(const ComputeDevice& device, std::span<const std::byte> bytes);

    std::size_t size() const;
    /// Overwrites a part. Throws std::out_of_range if it reaches beyond the end.
    void write(std::size_t offset, std::span<const std::byte> bytes) const;
    /// Overwrites many parts, by as few submissions as their bytes allow. Throws as above, and has then
    /// written nothing.
    void write(std::span<const ComputeWrite> parts) const;
    /// Copies a part to `bytes`. Throws std::out_of_range if it reaches beyond the end.
    void read(std::size_t offset, std::span<std::byte> bytes) const;

    /// All of it as values of a type.
    template <class T>
    std::vector<T> read_all() const {
        std::vector<T> values(size() / sizeof(T));
        read(0, std::as_writable_bytes(std::span(values)));
        return values;
    }

private:
    friend ComputeTriangles;
    friend ComputeKernel;
    friend ComputeCommands;
    struct State;
    std::shared_ptr<State> state_;
};

/// Triangles that ray queries of shaders meet. Copies are the same triangles.
class ComputeTriangles {
public:
    /// Each by the numbers of three vertices, whose positions are in `vertices`: three floats at the
    /// beginning of every `bytes_of_vertex` bytes, a multiple of 4. `opaque` ones are the first geometry,
    /// `others` the second one: of these shaders are asked, once a ray and triangle. Keeps `vertices`. Throws
    /// std::runtime_error if the device has no ray queries, or takes fewer triangles.
    ComputeTriangles(const ComputeDevice& device, const ComputeBuffer& vertices, std::size_t bytes_of_vertex,
                     std::span<const std::uint32_t> opaque, std::span<const std::uint32_t> others);

    /// After vertices have moved.
    void rebuild() const;

private:
    friend ComputeKernel;
    struct State;
    std::shared_ptr<State> state_;
};

/// The place where a shader sees a buffer, or triangles.
struct ComputeBinding {
    std::uint32_t set = 0;
    std::uint32_t binding = 0;
    std::variant<ComputeBuffer, ComputeTriangles> resource;
    bool is_uniform = false;

    /// Throws std::bad_variant_access if these are triangles.
    const ComputeBuffer& buffer() const { return std::get<ComputeBuffer>(resource); }
};

/// A compute shader and the buffers that it sees. Copies are the same kernel.
class ComputeKernel {
public:
    /// `spirv` as glslc writes it; main() is run. `push_bytes`: the size of its push constants, a multiple
    /// of 4, up to 128. The device keeps what its driver makes of these, for kernels of the same shader and
    /// bindings. Throws std::runtime_error if the device has fewer bindings for a shader than these.
    ComputeKernel(const ComputeDevice& device, std::span<const std::uint32_t> spirv,
                  std::span<const ComputeBinding> bindings, std::size_t push_bytes = 0);

    /// Another buffer in the place of one. Must not be called while it runs. Throws std::out_of_range if
    /// there is no such place.
    void bind(const ComputeBinding& binding) const;

private:
    friend ComputeCommands;
    struct State;
    std::shared_ptr<State> state_;
};

/// The commands that `ComputeDevice::run` records. Each command sees what those before it have written.
class ComputeCommands {
public:
    /// Runs a kernel over x * y * z workgroups with these push constants. Throws std::runtime_error if that
    /// is more than the device can count.
    void dispatch(const ComputeKernel& kernel, std::uint32_t x, std::uint32_t y = 1, std::uint32_t z = 1,
                  std::span<const std::byte> push = {}) const;
    /// The same with the three numbers from a buffer, 12 bytes from `offset` on.
    void dispatch_indirect(const ComputeKernel& kernel, const ComputeBuffer& counts, std::size_t offset = 0,
                           std::span<const std::byte> push = {}) const;
    /// Sets words of a buffer; offset and size in bytes are multiples of 4.
    void fill(const ComputeBuffer& buffer, std::size_t offset, std::size_t size, std::uint32_t word) const;

private:
    friend ComputeDevice;
    struct Recording;
    explicit ComputeCommands(const Recording& recording) : recording_(recording) {}
    const Recording& recording_;
};

}  // namespace demo
