// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/lights.hpp>
#include <lightmesh/mesh/snapshot_format.hpp>
#include <lightmesh/support/huge_pages.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

/// The form that snapshots of meshes and of caches have in common: a header, and sections at multiples of 64
/// bytes. A `Header` has the members magic, version, byte_order, size, checksum and sections, and says what
/// is right for the first three.

namespace lightmesh::detail {

[[noreturn]] inline void refuse_snapshot(const std::string& why) {
    throw std::invalid_argument("lightmesh: not a snapshot that can be read: " + why);
}
inline void require_right(bool right, const char* why) {
    if (!right)
        refuse_snapshot(why);
}

inline std::vector<LightRecord> records_of(std::span<const Light> lights) {
    std::vector<LightRecord> records;
    records.reserve(lights.size());
    for (const Light& light : lights)
        records.push_back(record_of(light));
    return records;
}

/// The inverse of `records_of`. Throws std::invalid_argument for kinds of lights that there are not.
inline std::vector<Light> lights_of(std::span<const LightRecord> records) {
    std::vector<Light> lights;
    lights.reserve(records.size());
    for (const LightRecord& record : records) {
        require_right(record.kind < std::variant_size_v<Light>, "there is no such kind of light");
        lights.push_back(light_of(record));
    }
    return lights;
}

/// A block while it is written: its sections grow side by side, each with room of its own.
template <class Header, class... Structs>
class BlockWriter {
public:
    static constexpr std::size_t section_count = sizeof...(Structs);
    template <std::size_t section>
    using Struct = std::tuple_element_t<section, std::tuple<Structs...>>;
    /// A number for each section.
    using Counts = std::array<std::size_t, section_count>;

    /// With room for so many structs; more of them come at the cost of a copy of all. Throws std::bad_alloc.
    explicit BlockWriter(const Counts& room) : room_(room) {
        static_assert(section_count == std::tuple_size_v<decltype(Header::sections)>);
        place_sections();
        bytes_.reserve(begin_.back());
        prefer_huge_pages(bytes_.data(), begin_.back());
        bytes_.resize(begin_.back());
    }

    const Counts& counts() const { return counts_; }

    /// The structs of a section so far. Valid until it grows.
    template <std::size_t section>
    Struct<section>* all() {
        return reinterpret_cast<Struct<section>*>(bytes_.data() + begin_[section]);
    }

    /// Adds structs of which all bytes are 0, and returns the first. Throws std::bad_alloc.
    template <std::size_t section>
    Struct<section>* extend(std::size_t count) {
        const std::size_t first = counts_[section];
        if (count > room_[section] - first)
            make_room(section, first + count);
        counts_[section] += count;
        return all<section>() + first;
    }
    template <std::size_t section>
    void add(const Struct<section>& added) {
        *extend<section>(1) = added;
    }

    /// The block, with nothing left between its sections. Of `header` all must be set but what follows from
    /// them. Ends the writer's use.
    std::vector<std::byte> finish(Header header) {
        header.magic = Header::right_magic;
        header.version = Header::right_version;
        header.byte_order = Header::right_byte_order;
        header.size = whole_lines(sizeof header);
        for (std::size_t section = 0; section < section_count; ++section) {
            header.sections[section] = {header.size, counts_[section]};
            const std::size_t size = counts_[section] * struct_bytes[section];
            std::byte* const to = bytes_.data() + header.size;
            if (header.size != begin_[section])
                std::memmove(to, bytes_.data() + begin_[section], size);
            std::memset(to + size, 0, whole_lines(size) - size);
            header.size += whole_lines(size);
        }
        bytes_.resize(header.size);
        if (bytes_.capacity() - bytes_.size() > bytes_.size() / 8)
            bytes_.shrink_to_fit();
        header.checksum = checksum_of(header, bytes_);
        std::memcpy(bytes_.data(), &header, sizeof header);
        return std::move(bytes_);
    }

private:
    static constexpr Counts struct_bytes{sizeof(Structs)...};

    static constexpr std::size_t whole_lines(std::size_t bytes) { return (bytes + 63) / 64 * 64; }

    void place_sections() {
        begin_[0] = whole_lines(sizeof(Header));
        for (std::size_t section = 0; section < section_count; ++section)
            begin_[section + 1] = begin_[section] + whole_lines(room_[section] * struct_bytes[section]);
    }

    void make_room(std::size_t section, std::size_t count) {
        Counts room = room_;
        room[section] = (std::max)(2 * room[section], count);
        BlockWriter larger(room);
        for (std::size_t s = 0; s < section_count; ++s)
            std::memcpy(larger.bytes_.data() + larger.begin_[s], bytes_.data() + begin_[s],
                        counts_[s] * struct_bytes[s]);
        larger.counts_ = counts_;
        *this = std::move(larger);
    }

    Counts room_;
    Counts counts_{};
    std::array<std::size_t, section_count + 1> begin_{};  ///< and where the last one's room ends
    std::vector<std::byte> bytes_;
};

/// The block of sections that are there already.
template <class Header, class... Structs>
std::vector<std::byte> write_block(const Header& header, const std::vector<Structs>&... sections) {
    BlockWriter<Header, Structs...> block({sections.size()...});
    [&]<std::size_t... section>(std::index_sequence<section...>) {
        (std::ranges::copy(sections, block.template extend<section>(sections.size())), ...);
    }
    (std::index_sequence_for<Structs...>());
    return block.finish(header);
}

/// A block whose header is right: what its sections hold is yet to be checked.
template <class Header>
class SnapshotBlock {
public:
    /// Throws std::invalid_argument that says in one sentence what is wrong with the bytes.
    explicit SnapshotBlock(std::span<const std::byte> bytes) : bytes_(bytes) {
        require_right(reinterpret_cast<std::uintptr_t>(bytes_.data()) % 16 == 0,
                      "its bytes must begin at a multiple of 16");
        require_right(bytes_.size() >= sizeof header_, "it is shorter than a header");
        std::memcpy(&header_, bytes_.data(), sizeof header_);
        if (header_.magic != Header::right_magic)
            refuse_snapshot("it does not begin with \"" +
                            std::string(Header::right_magic.data(), Header::right_magic.size()) + "\"");
        require_right(header_.byte_order == Header::right_byte_order,
                      "it was written on a machine of the other byte order");
        if (header_.version != Header::right_version)
            refuse_snapshot("its version is " + std::to_string(header_.version) + ", and only version " +
                            std::to_string(Header::right_version) + " is known");
        if (header_.size != bytes_.size())
            refuse_snapshot("it has " + std::to_string(bytes_.size()) + " bytes where its header says " +
                            std::to_string(header_.size));
        require_right(header_.checksum == checksum_of(header_, bytes_), "its checksum is wrong");
    }

    const Header& header() const { return header_; }

    /// The structs of a section, which lies within the bytes.
    template <class T>
    std::span<const T> section(std::size_t name) const {
        const SnapshotSection& at = header_.sections[name];
        require_right(at.offset % 64 == 0 && at.offset <= bytes_.size() &&
                          at.count <= (bytes_.size() - at.offset) / sizeof(T),
                      "a section reaches beyond its end");
        return {reinterpret_cast<const T*>(bytes_.data() + at.offset), at.count};
    }

private:
    std::span<const std::byte> bytes_;
    Header header_{};
};

}  // namespace lightmesh::detail
