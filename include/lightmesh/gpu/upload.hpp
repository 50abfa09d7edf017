// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/surface_point.hpp>

#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace lightmesh {

/// Bytes of a storage buffer of a shader.
struct UploadBuffer {
    std::uint32_t binding = 0;         ///< counted from LIGHTMESH_BINDING
    std::span<const std::byte> bytes;  ///< all of it; valid until the upload changes
};

/// Bytes to be written to a storage buffer.
struct UploadRange {
    std::uint32_t binding = 0;         ///< counted from LIGHTMESH_BINDING
    std::size_t offset = 0;            ///< of the first byte in the buffer
    std::span<const std::byte> bytes;  ///< valid until the upload changes
};

/// The requests of shaders in a request buffer.
struct UploadRequests {
    std::vector<SurfacePoint> points;  ///< to be handed to `fill`
    bool overflowed = false;           ///< more was asked for than there was room for: ask again
};

namespace detail {

/// Position, normal, footprint.
inline constexpr std::size_t words_of_request = 7;

/// Throws std::invalid_argument unless a request buffer may have room for so many points.
inline void check_request_capacity(std::size_t capacity) {
    if (capacity == 0 || capacity > std::size_t{1} << 26)
        throw std::invalid_argument("lightmesh: a request buffer has room for 1 to 2^26 points, not for " +
                                    std::to_string(capacity));
}

[[noreturn]] inline void throw_no_request_buffer() {
    throw std::invalid_argument("lightmesh: these bytes are not those of a request buffer");
}

}  // namespace detail

/// Bytes of an empty request buffer with room for so many points: what is written to it before each run of a
/// shader. Throws std::invalid_argument for none, or more than 2^26.
inline std::vector<std::byte> empty_requests(std::size_t capacity) {
    detail::check_request_capacity(capacity);
    const auto points = static_cast<std::uint32_t>(capacity);
    const std::array<std::uint32_t, 4> head{0, 0, points, 2 * points};
    std::vector<std::byte> bytes((head.size() + (2 + detail::words_of_request) * capacity) *
                                 sizeof(std::uint32_t));
    std::memcpy(bytes.data(), head.data(), sizeof head);
    return bytes;
}

/// Reads what shaders have written to a request buffer. Throws std::invalid_argument if it is none.
inline UploadRequests read_requests(std::span<const std::byte> bytes) {
    std::array<std::uint32_t, 4> head{};
    if (bytes.size() >= sizeof head)
        std::memcpy(head.data(), bytes.data(), sizeof head);
    const auto [count, dropped, capacity, slots] = head;
    if (capacity == 0 || slots != 2 * capacity ||
        bytes.size() !=
            (head.size() + std::size_t{slots} + detail::words_of_request * std::size_t{capacity}) *
                sizeof(std::uint32_t))
        detail::throw_no_request_buffer();
    UploadRequests requests;
    requests.overflowed = dropped != 0 || count > capacity;
    requests.points.resize((std::min)(count, capacity));
    const std::byte* at = bytes.data() + sizeof head + std::size_t{slots} * sizeof(std::uint32_t);
    for (SurfacePoint& point : requests.points) {
        std::array<float, detail::words_of_request> record;
        std::memcpy(record.data(), at, sizeof record);
        at += sizeof record;
        point = {.position = {record[0], record[1], record[2]},
                 .normal = {record[3], record[4], record[5]},
                 .footprint = record[6]};
    }
    return requests;
}

namespace detail {

/// The words of a storage buffer, and which of them have changed since they were uploaded last.
class UploadWords {
public:
    std::size_t size() const { return words_.size(); }
    std::uint32_t operator[](std::size_t word) const { return words_[word]; }

    void set(std::size_t word, std::uint32_t value) {
        if (words_[word] == value)
            return;
        words_[word] = value;
        changed_[word / block] = true;
    }
    void set(std::size_t word, float value) { set(word, std::bit_cast<std::uint32_t>(value)); }
    /// Two words, the lower one first.
    void set(std::size_t word, std::uint64_t value) {
        set(word, static_cast<std::uint32_t>(value));
        set(word + 1, static_cast<std::uint32_t>(value >> 32));
    }
    void set(std::size_t word, double value) { set(word, std::bit_cast<std::uint64_t>(value)); }

    /// At least so many words; the new ones are 0. What grows gets room to spare, so that it seldom does.
    void grow(std::size_t size) {
        if (size <= words_.size())
            return;
        const std::size_t spare = words_.empty() ? 0 : size / 4;
        words_.resize((size + spare + block - 1) / block * block);
        changed_.assign(words_.size() / block, true);
    }

    std::span<const std::byte> bytes() const { return std::as_bytes(std::span(words_)); }

    /// Adds what has changed to `ranges`, and takes it as uploaded.
    void take_changes(std::uint32_t binding, std::vector<UploadRange>& ranges) {
        for (std::size_t first = 0; first < changed_.size(); ++first) {
            if (!changed_[first])
                continue;
            std::size_t last = first;
            while (last < changed_.size() && changed_[last])
                changed_[last++] = false;
            constexpr std::size_t block_bytes = block * sizeof(std::uint32_t);
            ranges.push_back({binding, first * block_bytes,
                              bytes().subspan(first * block_bytes, (last - first) * block_bytes)});
            first = last;
        }
    }

private:
    static constexpr std::size_t block = 64;

    std::vector<std::uint32_t> words_;
    std::vector<bool> changed_;
};

/// Places of pairs of words: in what was freed, or at the end.
class UploadPool {
public:
    /// The first of `size` places. Throws std::length_error where their numbers end.
    std::uint32_t take(std::uint32_t size, UploadWords& words) {
        std::vector<std::uint32_t>& free = free_[size];
        if (!free.empty()) {
            const std::uint32_t index = free.back();
            free.pop_back();
            return index;
        }
        constexpr std::uint64_t most = (std::uint64_t{1} << 31) - 2;
        if (most - end_ < size)
            throw std::length_error("lightmesh: a mesh or a cache is too large for a shader");
        const auto index = static_cast<std::uint32_t>(end_);
        end_ += size;
        words.grow(2 * static_cast<std::size_t>(end_));
        return index;
    }
    void give_back(std::uint32_t index, std::uint32_t size) { free_[size].push_back(index); }

private:
    std::uint64_t end_ = 0;
    std::map<std::uint32_t, std::vector<std::uint32_t>> free_;
};

}  // namespace detail

}  // namespace lightmesh
