/* SPDX-License-Identifier: MIT */
#ifndef LIGHT_MESH_CORE_H
#define LIGHT_MESH_CORE_H

/*
 * The renderer as a shared library with a C interface, for programs in other languages: the Blender add-on
 * calls it by Python's ctypes.
 *
 * A session holds a scene, and what was found of its shadows. Each frame is told as a whole, between lm_begin
 * and lm_commit; what is the same as before is kept, and what moved is found anew. Then lm_render starts a
 * picture on threads of its own, lm_poll waits for it, lm_read copies what there is of it.
 *
 * Units: metres and radians; strengths of light as at LmLight. All vectors and matrices are of world space.
 * Functions that return an int or a number give -1 for an error,
 * whose text lm_error has. A session is for one thread at a time; different sessions, and lm_cancel, may be
 * used at once.
 */

#include <stddef.h>
#include <stdint.h>

#if defined(__GNUC__)
#define LM_API __attribute__((visibility("default")))
#else
#define LM_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/** Of this file: programs that were made for another one must not go on. */
#define LM_ABI 3

typedef struct LmSession LmSession;

/** Principled, as far as the renderer carries it. */
typedef struct LmMaterial {
    float base[3];
    float roughness;
    float metallic;
    float specular;
    float transmission;
    float refraction_index;
    float alpha;
    float emission[3];   /**< visible; lights nothing */
    int32_t base_image;  /**< multiplies the base colour; -1: none */
    int32_t image_alpha; /**< whether its alpha multiplies `alpha` */
    int32_t is_matt;     /**< whether there is no highlight, and no mirror */
} LmMaterial;

enum LmImageFlags { LM_IMAGE_LINEAR = 1 /**< not sRGB */, LM_IMAGE_CLAMP = 2 /**< does not repeat */ };

/** Triangles with what they have at their corners. */
typedef struct LmMesh {
    const char* name;            /**< for messages */
    const float* positions;      /**< 3 a vertex */
    const int32_t* corners;      /**< numbers of vertices, 3 a triangle */
    const int32_t* slots;        /**< of the object's materials, 1 a triangle */
    const float* normals;        /**< 9 a triangle, of any length; NULL: those of the vertices */
    const int32_t* smoothing;    /**< with `normals`, 3 a triangle: corners of a vertex with the same number
                                      have the same normal, however the mesh bends; NULL: no two have */
    const float* vertex_normals; /**< 3 a vertex, of any length; NULL: flat, where there are no `normals` */
    const float* uvs;            /**< 6 a triangle; NULL: none */
    uint32_t vertex_count;
    uint32_t triangle_count;
} LmMesh;

enum LmLightKind { LM_POINT = 0, LM_SUN = 1, LM_SPOT = 2, LM_AREA = 3 };

enum LmShadow {
    LM_REAL_LAMP = 0, /**< penumbrae of the lamp's own size, by a visibility cache */
    LM_MESH = 1,      /**< a light mesh */
    LM_MESH_ATK = 2,  /**< a light mesh that asks shadow maps what its points see */
    LM_HARD_RAYS = 3,
    LM_NO_SHADOW = 4
};

typedef struct LmLight {
    const char* name; /**< for messages */
    uint64_t id;      /**< the same in all frames: what was found of the light is kept, whatever others do */
    int32_t kind;
    int32_t shadow;
    float position[3];
    float axis[3];   /**< the way the light goes; of point lights without meaning */
    float half_u[3]; /**< of an area: from its middle to a side; it shines along cross(half_u, half_v) */
    float half_v[3];
    float strength[3]; /**< what a white surface that faces it sends back, at a distance of 1; sun: at any */
    float cone;        /**< half of a spot's angle, radians */
    float blend;       /**< share of the spot that is soft, in [0, 1] */
    float size;        /**< radius of a point or spot light; of the sun half its angle, radians */
    float spacing;     /**< of a visibility cache, metres */
    int32_t detail;    /**< how often it is halved along penumbrae */
    float radius;      /**< of a light mesh, metres: the width of its blur */
    float quality;     /**< light points to each radius, in [1, 16] */
    int32_t express;   /**< whether a light mesh does without short tests */
    int32_t map_size;  /**< texels to a side of shadow maps */
} LmLight;

/** A picture; all cameras that map straight lines to straight lines. */
typedef struct LmView {
    float eye[3];
    float ahead[3]; /**< unit length, as the next */
    float up[3];
    float
        edges[4]; /**< left, right, lower, upper edge: metres beside the middle; perspective: at distance 1 */
    float z_near;
    float z_far;
    int32_t is_orthographic;
    int32_t width;
    int32_t height;
    int32_t samples;
    int32_t bounces;
    int32_t threads;        /**< 0: all cores */
    int32_t is_transparent; /**< whether the background is left out */
    int32_t ambient_rays;   /**< to find which share of the ambient light arrives; 0: all */
    float ambient_distance; /**< metres beyond which nothing hides it */
    float background[3];
    float ambient[3];
} LmView;

typedef struct LmStatistics {
    double seconds_building; /**< the BVH */
    double seconds_rendering;
    double seconds_visibility; /**< in shadows, summed over threads */
    int64_t points;            /**< that were shaded */
    int64_t shadow_rays;       /**< of the picture; not those of caches and meshes */
    int64_t bytes;             /**< of caches and meshes */
    int64_t light_points;      /**< of meshes */
    int64_t records;           /**< of caches */
    int64_t kept_rays;         /**< that the caches and meshes there are have traced for what they keep */
    int64_t triangles;         /**< that are drawn, those of instances each time */
    int64_t stored_triangles;  /**< of these, how many are in memory */
    int32_t groups;            /**< caches and meshes: one for each distinct setting */
    int32_t groups_kept;  /**< of these, how many the last commit kept, but for what moved, came or went */
    int32_t is_new_scene; /**< whether the last commit kept nothing: it was the first one, or the one before it
                               failed */
    int32_t moved_boxes;  /**< where the last commit found triangles that came, went, moved, or let other light
                               through */
} LmStatistics;

LM_API int lm_abi(void);
/** Of the last function of this thread that failed. */
LM_API const char* lm_error(void);
/** Of a block of bytes, for lm_find_mesh: the same everywhere. */
LM_API uint64_t lm_hash(uint64_t seed, const void* bytes, size_t size);

/** NULL if there is no memory. `memory_budget`: bytes for each cache and mesh, 0: no limit. What is over it
 * and went unused is forgotten when the next picture, or the next points to bake, begin; no value depends on
 * it. */
LM_API LmSession* lm_new(uint64_t memory_budget);
/** Ends a picture that is being rendered. NULL is allowed. */
LM_API void lm_free(LmSession* session);

/** Begins to tell a frame; ends a picture that is being rendered. */
LM_API int lm_begin(LmSession* session);
/** The image of this frame, or of the last commit, that was added with this key; -1 if there is none. */
LM_API int lm_find_image(LmSession* session, uint64_t key);
/** Copies an image: RGBA of 8 bits, rows from the bottom up. Gives its number. */
LM_API int lm_add_image(LmSession* session, uint64_t key, int32_t width, int32_t height, const uint8_t* rgba,
                        int32_t flags);
LM_API int lm_add_material(LmSession* session, const LmMaterial* material);
/** A mesh of an earlier frame that was added with this hash; -1 if there is none. */
LM_API int lm_find_mesh(LmSession* session, uint64_t hash);
/** Copies a mesh. Fails for values that are not finite and for numbers out of range. */
LM_API int lm_add_mesh(LmSession* session, uint64_t hash, const LmMesh* mesh);
/** Places a mesh: `matrix` is row-major, 3 rows of 4. `materials` are those of its slots. Large meshes that
 * are placed several times with the same materials are kept once. */
LM_API int lm_add_object(LmSession* session, int32_t mesh, const double* matrix, const int32_t* materials,
                         int32_t material_count);
LM_API int lm_add_light(LmSession* session, const LmLight* light);
/** Makes the scene that was told the session's. Meshes that no object has are forgotten. */
LM_API int lm_commit(LmSession* session);

/** Starts a picture, and comes back at once. */
LM_API int lm_render(LmSession* session, const LmView* view);
enum LmState { LM_RUNNING = 0, LM_FINISHED = 1, LM_CANCELLED = 2 };
/** Waits at most so long for the picture to end, and gives an LmState; -1 if it failed. */
LM_API int lm_poll(LmSession* session, double seconds, float* progress);
/** What there is of the picture, rows from the bottom up, RGBA with associated alpha; 0 where there is
 * nothing. */
LM_API int lm_read(LmSession* session, float* rgba, size_t float_count);
/** The picture ends soon; from any thread. */
LM_API void lm_cancel(LmSession* session);
/** Points of surfaces; 3 values a point. */
typedef struct LmPoints {
    const float* positions;
    const float* normals;         /**< of the surface itself: unit length, on the shaded side, as the next */
    const float* shading_normals; /**< of smooth shading; NULL: `normals` */
    uint32_t count;
} LmPoints;
/**
 * What points of surfaces get from the lights: for baking. `visible` takes the share of each light that is
 * seen from a point, point by point and in the order of lm_add_light; `colours` what a white matt surface
 * sends back there, RGB. Both may be NULL. Comes back when it is done; ends a picture that is being rendered.
 */
LM_API int lm_bake(LmSession* session, const LmPoints* points, float* visible, float* colours);
/**
 * Which triangle each texel of an image shows, and where: by the texture coordinates of the corners, 6 values
 * a triangle; (0, 0) is the image's lower left corner, (1, 1) its upper right one. Texels whose middle lies
 * in a triangle show it there, the first one of several; others that triangles touch show about the
 * place on them that is nearest to their middle. `triangles` takes a number a texel, rows from the bottom up,
 * -1 where there is none; `weights` those of its 2nd and 3rd corner; `others` the number of another triangle
 * that has the texel's middle as well, or -1.
 */
LM_API int lm_cover_texels(int32_t width, int32_t height, uint32_t triangle_count, const float* uvs,
                           int32_t* triangles, float* weights, int32_t* others);
/**
 * Gives texels that are not filled, up to `margin` steps away from those that are, the mean of their
 * neighbours. `values` has `channels` of them a texel; `filled` is 1 or 0, and becomes 1 there.
 */
LM_API int lm_fill_margin(int32_t width, int32_t height, int32_t channels, float* values, uint8_t* filled,
                          int32_t margin);
LM_API int lm_statistics(LmSession* session, LmStatistics* statistics);

#ifdef __cplusplus
}
#endif

#endif
