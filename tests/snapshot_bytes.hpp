// SPDX-License-Identifier: MIT
#pragma once

#include <lightmesh/mesh/snapshot_format.hpp>

#include <cstddef>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

namespace test {

using Bytes = std::vector<std::byte>;

/// What a message says, or "" if nothing is thrown.
template <class Action>
std::string error_of(Action&& action) {
    try {
        action();
    } catch (const std::invalid_argument& error) {
        return error.what();
    }
    return "";
}

/// Gives a snapshot the right checksum.
template <class Header>
void sign(Bytes& bytes) {
    Header header;
    std::memcpy(&header, bytes.data(), sizeof header);
    header.checksum = lightmesh::detail::checksum_of(header, bytes);
    std::memcpy(bytes.data(), &header, sizeof header);
}

}  // namespace test
