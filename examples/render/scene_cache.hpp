// SPDX-License-Identifier: MIT
#pragma once

#include "render/embree_scene.hpp"
#include "render/lamps.hpp"
#include "render/visibility.hpp"

#include <lightmesh/visibility_cache.hpp>

namespace demo {

/// A visibility cache of a scene's lamps.
using SceneCache = lightmesh::VisibilityCache<EmbreeIntersector>;

/// One that knows nothing yet. The scene must outlive it. Throws what `VisibilityCache` throws.
inline SceneCache cache_of(const EmbreeScene& scene, const VisibilityOptions& options) {
    return {scene.intersector(), lamps_of(scene, options), cache_settings_of(options)};
}

/// One that begins with `VisibilityOptions::known`. Throws also what `merge` throws, and std::runtime_error
/// that tells the sizes if that was found for lamps of other ones.
SceneCache begun_cache_of(const EmbreeScene& scene, const VisibilityOptions& options);

}  // namespace demo
