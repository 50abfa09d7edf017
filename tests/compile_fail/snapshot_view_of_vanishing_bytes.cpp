// SPDX-License-Identifier: MIT
// must call what is deleted: SnapshotView
#include "wrong.hpp"

const lightmesh::SnapshotView view(std::vector<std::byte>(1024));
