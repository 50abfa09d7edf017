// SPDX-License-Identifier: MIT
#include "blender/core/light_mesh_core.h"

#include "blender/core/session.hpp"
#include "blender/core/texels.hpp"

#include <array>
#include <chrono>
#include <cmath>
#include <cstring>
#include <exception>
#include <limits>
#include <new>
#include <stdexcept>
#include <string>

struct LmSession {
    demo::Session session;
};

namespace {

thread_local std::string last_error;

demo::Session& checked(LmSession* session) {
    if (session == nullptr)
        throw std::invalid_argument("the session is NULL");
    return session->session;
}

template <class Value>
const Value& checked(const Value* value, const char* what) {
    if (value == nullptr)
        throw std::invalid_argument(std::string(what) + " is NULL");
    return *value;
}

/// The function's result, or -1 and the text of its exception.
template <class Function>
int or_error(Function&& function) {
    try {
        return function();
    } catch (const std::bad_alloc&) {
        last_error = "there is not enough memory";
    } catch (const std::exception& error) {
        last_error = error.what();
    } catch (...) {
        last_error = "an error without words";
    }
    return -1;
}

std::size_t texel_count(int32_t width, int32_t height) {
    if (width < 1 || height < 1)
        throw std::invalid_argument("an image of " + std::to_string(width) + " x " + std::to_string(height) +
                                    " texels");
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
}

}  // namespace

int lm_abi(void) {
    return LM_ABI;
}

const char* lm_error(void) {
    return last_error.c_str();
}

uint64_t lm_hash(uint64_t seed, const void* bytes, size_t size) {
    // Four multiplications at once, so that none waits for the last.
    constexpr uint64_t odd = 0x9fb21c651e98df25ULL;
    std::array<uint64_t, 4> lanes{seed, seed ^ 0x9e3779b97f4a7c15ULL, seed + 0xc2b2ae3d27d4eb4fULL, ~seed};
    const auto* at = static_cast<const unsigned char*>(bytes);
    const auto take = [&](const unsigned char* block) {
        for (std::size_t lane = 0; lane < lanes.size(); ++lane) {
            uint64_t value = 0;
            std::memcpy(&value, block + 8 * lane, sizeof value);
            lanes[lane] = (lanes[lane] ^ value) * odd;
            lanes[lane] ^= lanes[lane] >> 29;
        }
    };
    size_t left = size;
    for (; left >= 32; left -= 32, at += 32)
        take(at);
    std::array<unsigned char, 32> rest{};
    if (left > 0) {
        std::memcpy(rest.data(), at, left);
        take(rest.data());
    }
    uint64_t all = size;
    for (const uint64_t lane : lanes) {
        all = (all ^ lane) * odd;
        all ^= all >> 31;
    }
    return all;
}

LmSession* lm_new(uint64_t memory_budget) {
    LmSession* made = nullptr;
    or_error([&] {
        const std::size_t most = (std::numeric_limits<std::size_t>::max)();
        made =
            new LmSession{demo::Session(memory_budget == 0 ? most : static_cast<std::size_t>(memory_budget))};
        return 0;
    });
    return made;
}

void lm_free(LmSession* session) {
    delete session;
}

int lm_begin(LmSession* session) {
    return or_error([&] {
        checked(session).begin();
        return 0;
    });
}

int lm_find_image(LmSession* session, uint64_t key) {
    return or_error([&] { return checked(session).find_image(key); });
}

int lm_add_image(LmSession* session, uint64_t key, int32_t width, int32_t height, const uint8_t* rgba,
                 int32_t flags) {
    return or_error(
        [&] { return checked(session).add_image(key, width, height, &checked(rgba, "the image"), flags); });
}

int lm_add_material(LmSession* session, const LmMaterial* material) {
    return or_error([&] { return checked(session).add_material(checked(material, "the material")); });
}

int lm_find_mesh(LmSession* session, uint64_t hash) {
    return or_error([&] { return checked(session).find_mesh(hash); });
}

int lm_add_mesh(LmSession* session, uint64_t hash, const LmMesh* mesh) {
    return or_error([&] { return checked(session).add_mesh(hash, checked(mesh, "the mesh")); });
}

int lm_add_object(LmSession* session, int32_t mesh, const double* matrix, const int32_t* materials,
                  int32_t material_count) {
    return or_error([&] {
        checked(session).add_object(mesh, &checked(matrix, "the matrix"),
                                    {materials, static_cast<std::size_t>(material_count)});
        return 0;
    });
}

int lm_add_light(LmSession* session, const LmLight* light) {
    return or_error([&] {
        checked(session).add_light(checked(light, "the light"));
        return 0;
    });
}

int lm_commit(LmSession* session) {
    return or_error([&] {
        checked(session).commit();
        return 0;
    });
}

int lm_render(LmSession* session, const LmView* view) {
    return or_error([&] {
        checked(session).render(checked(view, "the view"));
        return 0;
    });
}

int lm_poll(LmSession* session, double seconds, float* progress) {
    return or_error([&] {
        float done = 0.0f;
        const LmState state = checked(session).poll(std::chrono::duration<double>(seconds), done);
        if (progress != nullptr)
            *progress = done;
        return static_cast<int>(state);
    });
}

int lm_read(LmSession* session, float* rgba, size_t float_count) {
    return or_error([&] {
        checked(session).read({rgba, float_count});
        return 0;
    });
}

void lm_cancel(LmSession* session) {
    if (session != nullptr)
        session->session.cancel();
}

int lm_bake(LmSession* session, const LmPoints* points, float* visible, float* colours) {
    return or_error([&] {
        demo::Session& baking = checked(session);
        const LmPoints& told = checked(points, "what holds the points");
        const std::size_t count = told.count;
        if (count > 0) {
            checked(told.positions, "what holds the positions");
            checked(told.normals, "what holds the normals");
        }
        const std::size_t lights = baking.light_count();
        baking.bake(told, {visible, visible == nullptr ? 0 : lights * count},
                    {colours, colours == nullptr ? 0 : 3 * count});
        return 0;
    });
}

int lm_cover_texels(int32_t width, int32_t height, uint32_t triangle_count, const float* uvs,
                    int32_t* triangles, float* weights, int32_t* others) {
    return or_error([&] {
        const std::size_t texels = texel_count(width, height);
        if (triangle_count > 0)
            checked(uvs, "what holds the texture coordinates");
        if (triangle_count > static_cast<uint32_t>((std::numeric_limits<int32_t>::max)()))
            throw std::length_error(std::to_string(triangle_count) + " triangles, more than 2^31");
        checked(triangles, "what takes the triangles");
        checked(weights, "what takes the weights");
        checked(others, "what takes the other triangles");
        demo::cover_texels({uvs, 6 * std::size_t{triangle_count}},
                           {width, height, {triangles, texels}, {weights, 2 * texels}, {others, texels}});
        return 0;
    });
}

int lm_fill_margin(int32_t width, int32_t height, int32_t channels, float* values, uint8_t* filled,
                   int32_t margin) {
    return or_error([&] {
        const std::size_t texels = texel_count(width, height);
        if (channels < 1)
            throw std::invalid_argument("texels of " + std::to_string(channels) + " channels");
        checked(values, "what holds the texels");
        checked(filled, "what tells the filled texels");
        demo::fill_margin(width, height, channels, {values, texels * static_cast<std::size_t>(channels)},
                          {filled, texels}, margin);
        return 0;
    });
}

int lm_statistics(LmSession* session, LmStatistics* statistics) {
    return or_error([&] {
        if (statistics == nullptr)
            throw std::invalid_argument("the statistics are NULL");
        *statistics = checked(session).statistics();
        return 0;
    });
}
