// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/lights.hpp>
#include <lightmesh/mesh/snapshot_format.hpp>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string>
#include <tuple>
#include <variant>
#include <vector>

/// What snapshots of meshes and of caches have in common: a header, and sections at multiples of 64 bytes. A
/// `Header` has the members magic, version, byte_order, size, checksum and sections, and says what is right
/// for the first three.

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

/// One block of the sections' structs, in their order. Of `header` all must be set but what follows from
/// them.
template <class Header, class... Sections>
std::vector<std::byte> write_block(Header header, const Sections&... of_section) {
    static_assert(sizeof...(of_section) == std::tuple_size_v<decltype(header.sections)>);
    header.magic = Header::right_magic;
    header.version = Header::right_version;
    header.byte_order = Header::right_byte_order;
    header.size = (sizeof header + 63) / 64 * 64;
    std::size_t section = 0;
    const auto place = [&](const auto& from) {
        header.sections[section++] = {header.size, from.size()};
        header.size += (from.size() * sizeof from[0] + 63) / 64 * 64;
    };
    (place(of_section), ...);

    std::vector<std::byte> block(header.size);
    section = 0;
    const auto copy = [&](const auto& from) {
        const SnapshotSection& at = header.sections[section++];
        if (!from.empty())
            std::memcpy(block.data() + at.offset, from.data(), from.size() * sizeof from[0]);
    };
    (copy(of_section), ...);
    header.checksum = checksum_of(header, block);
    std::memcpy(block.data(), &header, sizeof header);
    return block;
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
