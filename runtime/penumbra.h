/* libpenumbra turns a pose into visibility and radiance at every vertex. It is C99; docs/c-api.md is a short guide.
 *
 * Memory. Handles are opaque. ..._open and ..._create make them, and ..._close and ..._destroy take them back (NULL is
 * allowed there) in any order: a character, a shading and a scene keep what they need of the asset. The caller owns all
 * result arrays. Pointers that a query returns point into the asset; they are valid until the asset, its characters and
 * its shadings are given back. Strings are UTF-8 and end with a zero.
 *
 * Errors. Functions that can fail return a penumbra_status. Unless it is PENUMBRA_OK, the function has changed and
 * written nothing, and `error`, unless NULL, holds one sentence. A NULL handle or array where none is allowed, an index
 * beyond the last, a count that does not fit and a number that is not finite are PENUMBRA_INVALID_ARGUMENT. The arrays
 * of penumbra_vertices are not searched for such numbers, since functions of the library write them: one in there
 * spoils the result at its vertex and no other. No C++ exception leaves the library, and it never prints or exits.
 *
 * Enums have a last value ..._WIDE that makes them as wide as an int, so that the library can refuse a wrong value.
 *
 * Threads. The library has no threads and no global state of its own. Different threads may use different handles at
 * the same time, even if these come from one asset. Calls that take a const handle may run at the same time on one
 * handle when they write different ranges, so that a frame can be split over threads by clusters and by vertices.
 *
 * Speed. After ..._create no function of the character, the shading or the scene allocates memory, unless it says so,
 * fails or has more than 2,000 body parts in reach of one point.
 *
 * Arrays. There are V vertices, J joints and C clusters. Arrays are row-major and float32. The model frame is
 * right-handed, with y up, in metres. Colours are linear Rec.709; light and result are radiance. SH are real and
 * orthonormal with the Condon-Shortley sign and the index l(l+1)+m; an "order" counts bands. Vertices are the welded
 * ones of the asset (penumbra_asset_info.source_vertex leads back to those of the source).
 */
#ifndef PENUMBRA_H
#define PENUMBRA_H

#include <stddef.h>
#include <stdint.h>

/* A program on Windows calls the functions of the DLL and of the static library alike. */
#if defined(_WIN32) && defined(PENUMBRA_EXPORTS)
#define PENUMBRA_API __declspec(dllexport)
#elif defined(__GNUC__) && !defined(_WIN32)
#define PENUMBRA_API __attribute__((visibility("default")))
#else
#define PENUMBRA_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* --- Errors and versions --- */

typedef enum penumbra_status {
    PENUMBRA_OK = 0,
    PENUMBRA_INVALID_ARGUMENT = 1, /* the call is wrong */
    PENUMBRA_IO_ERROR = 2,         /* the file cannot be read */
    PENUMBRA_INVALID_ASSET = 3,    /* the bytes are no sound asset of a version that we read */
    PENUMBRA_FAILED = 4,           /* a mistake of the library itself */
    PENUMBRA_UNSUPPORTED = 5,      /* the asset or the processor does not have what was asked for */
    PENUMBRA_OUT_OF_MEMORY = 6,
    PENUMBRA_STATUS_WIDE = 0x7fffffff
} penumbra_status;

typedef struct penumbra_error {
    penumbra_status status;
    char message[508]; /* one sentence, cut if need be; "" with PENUMBRA_OK */
} penumbra_error;

#define PENUMBRA_NONE ((size_t)-1) /* result of the ..._find_ functions for a name that does not exist */

PENUMBRA_API const char* penumbra_version(void);      /* "0.1.0" */
PENUMBRA_API int penumbra_asset_format_version(void); /* the one version of .pnb that this library reads */
PENUMBRA_API const char* penumbra_status_name(penumbra_status status); /* "PENUMBRA_OK", ... */

/* --- Assets --- */

typedef struct penumbra_asset penumbra_asset; /* a checked .pnb file; nothing in it changes any more */

typedef enum penumbra_ownership {
    PENUMBRA_BORROW = 0, /* read in place: the bytes begin at a multiple of 16 and outlive all that is made of them */
    PENUMBRA_COPY = 1,   /* the library keeps a copy */
    PENUMBRA_OWNERSHIP_WIDE = 0x7fffffff
} penumbra_ownership;

/* Opens a .pnb file (memory-mapped) or its bytes, and checks all of it. Fails with PENUMBRA_IO_ERROR,
 * PENUMBRA_INVALID_ASSET and PENUMBRA_OUT_OF_MEMORY. Nobody may change a mapped file while it is open; replacing it by
 * a rename is fine. */
PENUMBRA_API penumbra_status penumbra_asset_open_file(const char* path, penumbra_asset** asset, penumbra_error* error);
PENUMBRA_API penumbra_status penumbra_asset_open_memory(const void* bytes, size_t size, penumbra_ownership ownership,
                                                        penumbra_asset** asset, penumbra_error* error);
PENUMBRA_API void penumbra_asset_close(penumbra_asset* asset);

/* Tells what is in the file. Counts and pointers are 0 and NULL where it holds no such thing (a file may have only
 * materials or lights). */
typedef struct penumbra_asset_info {
    int has_model;          /* 1: a character can be made, of visibility or of transfer (convention "T6", ...) */
    const char* provenance; /* JSON: tool, version, options, hashes of the inputs */

    size_t vertex_count, source_vertex_count, triangle_count; /* V, R, T */
    const float* rest_positions;                              /* [V,3] */
    const float* rest_normals;                                /* [V,3] unit */
    const float* rest_tangents;                               /* [V,3] unit, orthogonal to the normal */
    const uint32_t* triangles;                                /* [T,3] */
    const uint32_t* source_vertex;                            /* [R] each source vertex' vertex in the asset */

    size_t influence_count;      /* K */
    const uint16_t* skin_joints; /* [V,K] */
    const float* skin_weights;   /* [V,K] rows sum to 1 */

    size_t slot_count;              /* named parts of the mesh, each with a material; 0: one part, no name */
    const uint16_t* slot_of_vertex; /* [V] */

    int deforming;    /* 1: vertices are given (penumbra_character_set_positions), not skinned by the caller's bones */
    int two_sided;    /* 1: a thin sheet; every vertex has a back, every triangle one from behind: cull back faces; */
                      /* 2: some triangles have one from behind, with vertices like any other: cull back faces */
    int has_playback; /* 1: a deforming mesh with the positions of its frames */
    size_t input_count; /* X: numbers of a pose that the mesh does not know (penumbra_asset_input_name) */

    size_t joint_count;           /* J; for a deforming mesh these are its rigid parts and its inputs */
    const int32_t* joint_parents; /* [J] -1 for roots */
    const float* rest_transforms; /* [J,3,4] rows, joint to parent joint (root: to the scene) at rest; or NULL */
    const float* inverse_bind;    /* [J,3,4] rows, rest positions to joint; or NULL */
    size_t clip_count, frame_count;
    size_t rotation_count; /* numbers of a pose in rotation vectors, 3J (of a rig with inputs 3 for each joint of its
                              own, then the inputs); 0 where the model reads matrices only */

    const char* convention;   /* "D5", "A4", ... (docs/formulas.md section 2); "T6": transfer */
    size_t coefficient_count; /* coefficients a vertex */
    size_t stride;            /* floats a vertex in their arrays: coefficient_count padded to a multiple of 4 */
    size_t cluster_count;     /* C */
    size_t score_count;       /* scores of all clusters together */
    float quantization_error; /* relative, measured when the asset was packed */

    size_t material_count, light_count;
} penumbra_asset_info;
PENUMBRA_API penumbra_status penumbra_asset_get_info(const penumbra_asset* asset, penumbra_asset_info* info);

PENUMBRA_API const char* penumbra_asset_joint_name(const penumbra_asset* asset,
                                                   size_t joint); /* NULL beyond the last */
PENUMBRA_API const char* penumbra_asset_slot_name(const penumbra_asset* asset, size_t slot);
PENUMBRA_API const char* penumbra_asset_input_name(const penumbra_asset* asset, size_t input);
PENUMBRA_API size_t penumbra_asset_find_input(const penumbra_asset* asset, const char* name);
PENUMBRA_API size_t penumbra_asset_find_joint(const penumbra_asset* asset, const char* name);
/* The look of a slot of an asset with textures (penumbra-pack asset --materials-of --textures), in linear Rec.709.
 * Three materials of the asset stand for it: shade with each of them (penumbra_shading_set_material), which gives D, A
 * and B. With the numbers below times their textures, a pixel then shows base (1 - metallic) D + mix(f0, base,
 * metallic) A + mix(f90, 1, metallic) B + emissive as penumbra_join_terms() of the GLSL text does. A and B exist at one
 * or more roughnesses, ascending; interpolate between two of them. */
#define PENUMBRA_MAX_ROUGHNESS_STEPS 3
typedef struct penumbra_slot_surface {
    float base[3], emissive[3], f0[3];
    float f90, metallic, roughness;
    float normal_scale, occlusion_strength; /* factors of its textures; suns and emission have no occlusion */
    float alpha, alpha_cutoff;              /* a pixel with less alpha than the cut-off is not there; 0: all are; -1: as
                                             * much of it is there as alpha says (alphaMode BLEND) */
    size_t diffuse;                         /* material of D */
    size_t steps;                           /* 0..PENUMBRA_MAX_ROUGHNESS_STEPS of the next three; 0: A and B are 0 */
    float step_roughness[PENUMBRA_MAX_ROUGHNESS_STEPS];
    size_t step_f0[PENUMBRA_MAX_ROUGHNESS_STEPS], step_f90[PENUMBRA_MAX_ROUGHNESS_STEPS]; /* materials of A and B */
} penumbra_slot_surface;
/* Returns 0 where the asset has no textures or no such slot; slot 0 is that of a mesh without slots. */
PENUMBRA_API int penumbra_asset_slot_surface(const penumbra_asset* asset, size_t slot, penumbra_slot_surface* surface);
PENUMBRA_API size_t penumbra_asset_find_slot(const penumbra_asset* asset, const char* name);
PENUMBRA_API size_t penumbra_asset_find_clip(const penumbra_asset* asset, const char* name);
PENUMBRA_API size_t penumbra_asset_find_material(const penumbra_asset* asset, const char* name);
PENUMBRA_API size_t penumbra_asset_find_light(const penumbra_asset* asset, const char* name);

/* The animation that the model was made from. Clips follow one another and cover all frames. */
typedef struct penumbra_clip {
    const char* name;
    size_t first_frame, frame_count;
    int held_out; /* 1: the model was not trained on it */
} penumbra_clip;
PENUMBRA_API penumbra_status penumbra_asset_get_clip(const penumbra_asset* asset, size_t clip, penumbra_clip* out);

typedef struct penumbra_frame {
    double seconds;         /* in its clip */
    const float* matrices;  /* [J,3,4] skinning matrices, PENUMBRA_ROWS_3X4; NULL for a deforming mesh */
    const float* rotations; /* [rotation_count], or NULL */
    const float* inputs;    /* [input_count], or NULL */
} penumbra_frame;
PENUMBRA_API penumbra_status penumbra_asset_get_frame(const penumbra_asset* asset, size_t frame, penumbra_frame* out);
/* Returns the last frame of `clip` that is not after `seconds`, or else its first frame. Returns PENUMBRA_NONE for a
 * clip that does not exist or has no frames, and where `seconds` is NaN. */
PENUMBRA_API size_t penumbra_asset_frame_at(const penumbra_asset* asset, size_t clip, double seconds);

/* Writes the vertex of the other side of each vertex of a two-sided mesh, [vertex_count]. Fails with
 * PENUMBRA_UNSUPPORTED for a one-sided mesh. Allocates. */
PENUMBRA_API penumbra_status penumbra_asset_get_other_sides(const penumbra_asset* asset, uint32_t* vertices,
                                                            penumbra_error* error);

typedef struct penumbra_material {
    const char* name;
    int slice_order, view_order, channels; /* channels: 1 or 3 */
    float color[3];                        /* factor on the result */
    const float* slices;                   /* [channels, slice_order^2, view_order (view_order + 1) / 2]; NULL: live */
    int operator_count;                    /* 0: no PENUMBRA_OPERATORS */
    size_t lobe_count;                     /* 1 to 4 */
} penumbra_material;
PENUMBRA_API penumbra_status penumbra_asset_get_material(const penumbra_asset* asset, size_t material,
                                                         penumbra_material* out);
/* The lobes of a material add up to its BRDF, for light from one direction. These are the numbers that
 * penumbra_brdf_lobe() and penumbra_mirror_reflectance() of penumbra_brdf_get_glsl() take. */
typedef struct penumbra_lobe {
    int model;
    float parameters[4];
    float color[3];
} penumbra_lobe;
PENUMBRA_API penumbra_status penumbra_asset_get_lobe(const penumbra_asset* asset, size_t material, size_t lobe,
                                                     penumbra_lobe* out);
/* Writes the radiance that the surface sends out by itself, [3], 0 for most materials. All shading adds it; lobes and
 * slices do not have it. */
PENUMBRA_API penumbra_status penumbra_asset_get_emission(const penumbra_asset* asset, size_t material, float* out);

typedef struct penumbra_light {
    const char* name;
    int order;
    const float* sh; /* [order^2, 3] */
    int lobe_count;  /* 0: no PENUMBRA_LOBES */
    int sun_count;   /* suns of penumbra_shading_set_suns */
} penumbra_light;
PENUMBRA_API penumbra_status penumbra_asset_get_light(const penumbra_asset* asset, size_t light, penumbra_light* out);

/* Gives a GPU what it needs to evaluate a cluster itself (penumbra.glsl): coefficients = mean + sum over k of score_k
 * scale_k basis_k, followed by a clamp of the ambient term. Clusters are contiguous ranges of vertices and cover all of
 * them but those that follow points. */
typedef enum penumbra_precision {
    PENUMBRA_F32 = 0,
    PENUMBRA_F16 = 1,
    PENUMBRA_I8 = 2,
    PENUMBRA_PRECISION_WIDE = 0x7fffffff
} penumbra_precision;
typedef struct penumbra_cluster {
    size_t joint, first_vertex, vertex_count;
    size_t component_count, first_score; /* K_c; where its scores are among those of all clusters */
    penumbra_precision mean_precision, basis_precision;
    const void* mean;         /* [vertex_count, stride], PENUMBRA_F32 or PENUMBRA_F16; 16-byte aligned */
    const void* basis;        /* [K_c, vertex_count, stride]; 16-byte aligned */
    const float* basis_scale; /* [K_c]; NULL unless PENUMBRA_I8: scale 1 */
} penumbra_cluster;
PENUMBRA_API penumbra_status penumbra_asset_get_cluster(const penumbra_asset* asset, size_t cluster,
                                                        penumbra_cluster* out);

/* The last `count` vertices of a dense character belong to no cluster: each follows three points, vertices of clusters,
 * whose coefficients it interpolates (penumbra_character_follow, penumbra.glsl). count 0: there are none. */
typedef struct penumbra_followers {
    size_t first, count;
    const uint32_t* corners; /* [count,3] the points */
    const float* weights;    /* [count,3] rows sum to 1 */
} penumbra_followers;
PENUMBRA_API penumbra_status penumbra_asset_get_followers(const penumbra_asset* asset, penumbra_followers* out);

/* --- Code for one kind of processor --- */

typedef enum penumbra_simd {
    PENUMBRA_SIMD_BEST = 0, /* all that the processor has; portable if the environment has PENUMBRA_NO_SIMD */
    PENUMBRA_SIMD_PORTABLE = 1,
    PENUMBRA_SIMD_AVX2 = 2, /* AVX2, FMA and F16C, but nothing newer */
    PENUMBRA_SIMD_WIDE = 0x7fffffff
} penumbra_simd;
PENUMBRA_API int penumbra_has_simd(penumbra_simd simd); /* 1 or 0 */

/* --- Characters: one pose of an asset's model --- */

typedef struct penumbra_character penumbra_character;

/* Makes a character in the rest pose. Fails with PENUMBRA_UNSUPPORTED for an asset without a model. The first character
 * of an asset decodes its model; the others share it. */
PENUMBRA_API penumbra_status penumbra_character_create(const penumbra_asset* asset, penumbra_character** character,
                                                       penumbra_error* error);
PENUMBRA_API void penumbra_character_destroy(penumbra_character* character);
/* Only for tests and comparisons, since PENUMBRA_SIMD_BEST is the default. Fails with PENUMBRA_UNSUPPORTED where
 * penumbra_has_simd() is 0. */
PENUMBRA_API penumbra_status penumbra_character_set_simd(penumbra_character* character, penumbra_simd simd,
                                                         penumbra_error* error);

/* The quality of a composed asset (one with fields of body parts). Other assets have one quality. */
typedef enum penumbra_quality {
    PENUMBRA_FULL = 0,
    PENUMBRA_FAST = 1, /* about half the time of an evaluation; for characters that are small in the picture */
    PENUMBRA_QUALITY_WIDE = 0x7fffffff
} penumbra_quality;
/* Takes effect in the next evaluation. Fails with PENUMBRA_INVALID_ARGUMENT for any other number. */
PENUMBRA_API penumbra_status penumbra_character_set_quality(penumbra_character* character, penumbra_quality quality,
                                                            penumbra_error* error);

typedef enum penumbra_matrix_layout {
    PENUMBRA_ROWS_3X4 = 0,    /* 12 floats a joint: rows of [A | t] with p' = A p + t */
    PENUMBRA_COLUMNS_4X4 = 1, /* 16 floats a joint: columns, as in OpenGL and glTF; the last row is not read */
    PENUMBRA_MATRIX_LAYOUT_WIDE = 0x7fffffff
} penumbra_matrix_layout;
/* Sets a pose by its bones. `matrices` are J skinning matrices in model space: joint global * inverse bind. Joints that
 * stand for inputs count too; their matrices are translations. `rotations` [rotation_count] are the log of each joint's
 * rotation relative to rest (penumbra_rotation_vector), in radians. Only models of joint angles need them; others
 * ignore them, and they may be NULL. Every number must be finite. Fails with PENUMBRA_UNSUPPORTED for a deforming mesh.
 */
PENUMBRA_API penumbra_status penumbra_character_set_pose(penumbra_character* character, penumbra_matrix_layout layout,
                                                         const float* matrices, size_t joint_count,
                                                         const float* rotations, size_t rotation_count,
                                                         penumbra_error* error);
/* A skinned mesh with inputs (input_count > 0) has joints that stand for them, which no engine knows. This function
 * writes their matrices into `matrices` [joint_count], for penumbra_character_set_pose, and leaves the others alone.
 * `inputs` [input_count] must be finite, in the order of penumbra_asset_input_name. Fails with PENUMBRA_UNSUPPORTED for
 * a deforming mesh. */
PENUMBRA_API penumbra_status penumbra_asset_input_matrices(const penumbra_asset* asset, penumbra_matrix_layout layout,
                                                           const float* inputs, size_t input_count, float* matrices,
                                                           size_t joint_count, penumbra_error* error);
/* Morph targets shape the rest pose before bones move it. Their weights are the last penumbra_asset_morph_count inputs,
 * so that penumbra_asset_find_input("smile") is a weight's place; `weights` [count], which may be NULL, receives those
 * at rest. The library shapes the mesh itself from what penumbra_character_set_pose gets. */
PENUMBRA_API size_t penumbra_asset_morph_count(const penumbra_asset* asset, float* weights);
/* Sets a pose by joint rotations alone. `rotations` [J,3] are those of penumbra_character_set_pose, with rotation_count
 * = 3 J. Each joint's global matrix is its parent joint's * its rest transform * its rotation, so that translations and
 * scales stay those of the rest pose (exact for uniform scales). `root` [3,4] has the rows of what moves the whole
 * character in the model frame; NULL moves nothing. Fails with PENUMBRA_UNSUPPORTED for a deforming mesh, for an asset
 * without rest transforms, and for one with joints that stand for inputs. */
PENUMBRA_API penumbra_status penumbra_character_set_rotations(penumbra_character* character, const float* root,
                                                              const float* rotations, size_t rotation_count,
                                                              penumbra_error* error);
typedef enum penumbra_vertex_order {
    PENUMBRA_SOURCE_VERTICES = 0, /* in the order of the source file: source_vertex_count */
    PENUMBRA_ASSET_VERTICES =
        1, /* in the order of rest_positions: vertex_count; the backs of a two-sided mesh are not read */
    PENUMBRA_VERTEX_ORDER_WIDE = 0x7fffffff
} penumbra_vertex_order;
/* Sets the vertices of a deforming mesh (penumbra_asset_info.deforming) in the model frame. The library computes the
 * motions of its parts and its normals from them. `positions` is [vertex_count,3]; of several source vertices that are
 * one vertex in the asset, the first counts. `inputs` [input_count] are in the order of penumbra_asset_input_name, and
 * may be NULL where there are none. Every number that is read must be finite. Fails with PENUMBRA_UNSUPPORTED for a
 * skinned mesh. */
PENUMBRA_API penumbra_status penumbra_character_set_positions(penumbra_character* character,
                                                              penumbra_vertex_order order, const float* positions,
                                                              size_t vertex_count, const float* inputs,
                                                              size_t input_count, penumbra_error* error);
/* Sets a sampled frame of the asset. Fails with PENUMBRA_UNSUPPORTED where the asset lacks the rotations that the model
 * needs, or the positions of a deforming mesh. */
PENUMBRA_API penumbra_status penumbra_character_set_frame(penumbra_character* character, size_t frame,
                                                          penumbra_error* error);
/* Computes the log of rest^-1 now, in radians. Both are unit quaternions x, y, z, w that turn a joint's frame into that
 * of its parent joint (for a root: into the scene). */
PENUMBRA_API void penumbra_rotation_vector(const float rest[4], const float now[4], float out[3]);

/* Tells how far this pose is from those that the model was trained on, in about radians; 0 is inside. The library
 * clamps the model's inputs to what it knows. So results stay sound, but for a large value they are those of another
 * pose. */
PENUMBRA_API double penumbra_character_out_of_range(const penumbra_character* character);

/* Vertices [first, first + count), and the caller's arrays of all V vertices of an asset, or of all points of a height
 * field. Functions read or write those arrays that they name. The others may be NULL. */
typedef struct penumbra_vertices {
    float *positions, *normals, *tangents; /* [V,3] unit normals and tangents */
    float* coefficients; /* [V,stride] SH of the visibility in each vertex' local frame; or transfer */
    float* bounced;      /* [V,PENUMBRA_BOUNCED_STRIDE] light that bounces; NULL: calls leave it out */
    size_t first, count;
    /* [V,3] irradiance that other things of the scene reflect onto the vertices: pi times `hidden` of
     * penumbra_ground_shadow times the ground's radiance, say. Shading adds it to what bounces, unless direct light
     * alone is shown; NULL: nothing */
    float* received;
} penumbra_vertices;
#define PENUMBRA_BOUNCED_STRIDE 12

/* How many bounces the asset has of light that reaches a vertex by reflection from the rest of the character, with the
 * albedo of the bake (penumbra-fit indirect). 0: it has no such light, and calls with `bounced` fail with
 * PENUMBRA_UNSUPPORTED. */
PENUMBRA_API int penumbra_asset_bounces(const penumbra_asset* asset);

/* Computes `coefficients`, and `bounced` unless it is NULL, of clusters [first_cluster, first_cluster + cluster_count),
 * whatever the range of `vertices` is. */
PENUMBRA_API penumbra_status penumbra_character_evaluate(const penumbra_character* character, size_t first_cluster,
                                                         size_t cluster_count, const penumbra_vertices* vertices,
                                                         penumbra_error* error);
/* Computes `coefficients` of those vertices of the range that follow points (penumbra_asset_get_followers), from those
 * of the points, of which all clusters must be evaluated, and from all `positions`, `normals` and `tangents` as
 * penumbra_character_skin has written them. Other vertices of the range stay as they are. Call it before
 * penumbra_scene_cast. */
PENUMBRA_API penumbra_status penumbra_character_follow(const penumbra_character* character,
                                                       const penumbra_vertices* vertices, penumbra_error* error);
/* Computes skinned (for a deforming mesh: given) `positions`, `normals` and `tangents`. */
PENUMBRA_API penumbra_status penumbra_character_skin(const penumbra_character* character,
                                                     const penumbra_vertices* vertices, penumbra_error* error);
/* Computes the ambient term [V] from `coefficients`: cosine-weighted visibility / pi, from 0 (dark) to 1 (open). With
 * `bounced` it has what reaches the vertices by reflection under a light of radiance 1 from everywhere, and is never
 * below the other by more than rounding where surfaces reflect. */
PENUMBRA_API penumbra_status penumbra_character_ambient(const penumbra_character* character,
                                                        const penumbra_vertices* vertices, float* ambient,
                                                        penumbra_error* error);
/* Computes the transfer [V,order^2] of order 1..5 from `coefficients`, `positions`, `normals` and `tangents`: the
 * integrals over the hemisphere of V cos y_i in the model frame. Its product with the SH of a light of so many bands is
 * the irradiance. */
PENUMBRA_API penumbra_status penumbra_character_transfer(const penumbra_character* character, int order,
                                                         const penumbra_vertices* vertices, float* transfer,
                                                         penumbra_error* error);

/* Gives a GPU the scores of all clusters [score_count] and the rotation of each [C,3,3] (rows). NULL: not wanted. */
PENUMBRA_API penumbra_status penumbra_character_get_scores(const penumbra_character* character, float* scores,
                                                           float* rotations);

/* --- Scenes: what characters hide from points that are not their own --- */

typedef struct penumbra_scene penumbra_scene;

/* Makes a scene of casters, of which caster i is a character of assets[i] that hides nothing yet. One asset may come
 * more than once. An asset casts by the fields of its composed model (penumbra-fit visibility --model composed), or
 * else by its spheres (penumbra-pack asset --blockers). Fails with PENUMBRA_UNSUPPORTED for one that has neither, and
 * where all casters together have more than 65,535 parts or spheres. Before penumbra_scene_destroy the characters may
 * be given back, and the assets. */
PENUMBRA_API penumbra_status penumbra_scene_create(const penumbra_asset* const* assets, size_t caster_count,
                                                   penumbra_scene** scene, penumbra_error* error);
PENUMBRA_API void penumbra_scene_destroy(penumbra_scene* scene);
/* Takes over the pose that a character of the caster's asset has now, and where it stands: `to_scene` [3,4] has the
 * rows of a rotation and a translation; NULL is the identity. A NULL character hides nothing from now on. Calls for
 * different casters may not run at the same time. */
PENUMBRA_API penumbra_status penumbra_scene_set_caster(penumbra_scene* scene, size_t caster,
                                                       const penumbra_character* character, const float* to_scene,
                                                       penumbra_error* error);
PENUMBRA_API size_t penumbra_scene_caster_count(const penumbra_scene* scene); /* 0 for NULL */

/* Multiplies `coefficients` of the range, of a character that stands where `to_scene` says, by what a level ground
 * below it leaves visible: directions with y > 0 in the scene. The ground has no end, so that its height does not
 * matter. `hidden` [V] gets what it takes of a white sky, from 0 to 1, which is (1 - n.y) / 2 where nothing else hides;
 * NULL: not wanted. Call it after penumbra_scene_cast. Light that bounces stays as it is. */
PENUMBRA_API penumbra_status penumbra_ground_shadow(const penumbra_character* character, const float* to_scene,
                                                    const penumbra_vertices* vertices, float* hidden,
                                                    penumbra_error* error);

typedef enum penumbra_caster_kind {
    PENUMBRA_CASTS_FIELDS = 0,
    PENUMBRA_CASTS_SPHERES = 1,
    PENUMBRA_CASTER_KIND_WIDE = 0x7fffffff
} penumbra_caster_kind;
typedef struct penumbra_caster {
    penumbra_caster_kind kind;
    int hidden;         /* 1: it hides nothing, since it has no character */
    float to_scene[12]; /* [3,4] as it was set last; the identity before that */
} penumbra_caster;
/* Tells what a caster is and where it stands. */
PENUMBRA_API penumbra_status penumbra_scene_get_caster(const penumbra_scene* scene, size_t caster, penumbra_caster* out,
                                                       penumbra_error* error);
/* Points of the engine's own meshes, in the scene. Neighbouring ones should follow one another: 64 at a time look for
 * the casters in reach. */
typedef struct penumbra_points {
    const float *positions, *normals; /* [count,3] unit normals */
    size_t count;
} penumbra_points;
/* These compute what all casters but `except` (PENUMBRA_NONE: all) leave visible at points, each for a caller who needs
 * no more than that. The ambient term [count] is the cosine-weighted visibility / pi, 1 where nothing is hidden. The
 * irradiance [count,3] is that of a light `sh` [order^2,3], order 1..5, in the scene. The transfer [count,25] has the
 * integrals over the hemisphere of V cos y_i, order 5, in the scene, whose product with a light is the irradiance. */
PENUMBRA_API penumbra_status penumbra_scene_ambient(const penumbra_scene* scene, size_t except,
                                                    const penumbra_points* points, float* ambient,
                                                    penumbra_error* error);
PENUMBRA_API penumbra_status penumbra_scene_irradiance(const penumbra_scene* scene, size_t except,
                                                       const penumbra_points* points, int order, const float* sh,
                                                       float* irradiance, penumbra_error* error);
PENUMBRA_API penumbra_status penumbra_scene_transfer(const penumbra_scene* scene, size_t except,
                                                     const penumbra_points* points, float* transfer,
                                                     penumbra_error* error);
/* Multiplies `coefficients` of a character's vertices, which penumbra_character_evaluate has written, by what all
 * casters but `except` leave visible: its own caster, unless that is PENUMBRA_NONE. `bounced`, unless it is NULL, is
 * multiplied by the share of a white sky that they leave. The character may be of any asset. The arrays stay bit for
 * bit the same where no caster is in reach. Casters that are not near are looked up at anchors, which all vertices of a
 * cluster share, so that large ranges cost less a vertex than small ones. Allocates for the first range of a thread,
 * for a larger one, and for the first call on an asset. */
PENUMBRA_API penumbra_status penumbra_scene_cast(const penumbra_scene* scene, size_t except,
                                                 const penumbra_character* character, const float* to_scene,
                                                 const penumbra_vertices* vertices, penumbra_error* error);

/* How many spheres characters of the asset cast by (penumbra-pack asset --blockers); 0: none. */
PENUMBRA_API size_t penumbra_asset_sphere_count(const penumbra_asset* asset);
/* Writes the spheres of a character as it is posed now, [sphere_count,4]: the center in the scene, and the radius.
 * Shaders read them as PENUMBRA_SPHERE (penumbra_cast_get_glsl). `to_scene` is that of penumbra_scene_set_caster. No
 * scene is needed, and an asset with fields has its spheres here, too. Allocates nothing. */
PENUMBRA_API penumbra_status penumbra_character_get_spheres(const penumbra_character* character, const float* to_scene,
                                                            float* spheres, penumbra_error* error);

/* How many parts with fields characters of the asset cast by (penumbra-fit visibility --model composed); 0: none. */
PENUMBRA_API size_t penumbra_asset_part_count(const penumbra_asset* asset);
/* How many 32-bit words the fields take, a multiple of 4; 0 without. */
PENUMBRA_API size_t penumbra_asset_field_words(const penumbra_asset* asset);
/* Writes the fields [field_words] for PENUMBRA_FIELD (penumbra_cast_get_glsl). One call for each asset is enough, since
 * the words are the same in all poses. `first_word` tells where in the engine's buffer they begin, so that a buffer may
 * hold several assets: a multiple of 4, and the words end below 2^26. Allocates. */
PENUMBRA_API penumbra_status penumbra_asset_get_fields(const penumbra_asset* asset, size_t first_word, uint32_t* words,
                                                       penumbra_error* error);
/* Writes the parts of a character as it is posed now for PENUMBRA_PART, [part_count,7,4]. `first_word` is that of its
 * asset's fields, `to_scene` that of penumbra_scene_set_caster. No scene is needed. Allocates nothing. */
PENUMBRA_API penumbra_status penumbra_character_get_parts(const penumbra_character* character, const float* to_scene,
                                                          size_t first_word, float* rows, penumbra_error* error);

/* Composed models on a GPU: what it needs besides clusters, fields and parts to compute what the library computes
 * (docs/c-api.md). 0 words: the asset is no composed one, or has a floor or a convention of more than 6 bands. The
 * words begin with how many anchors there are, how many vectors of 4 floats their values take, how many near parts a
 * part has, and where these arrays begin among the words:
 * - the far parts of each part: [part_count + 1] where they begin among those that follow, then all of them;
 * - the anchors, [anchors,2]: a vertex, and the vector at which its values begin;
 * - the receivers, [V,8]: the first vectors of 4 anchors (0xffffffff: none), and as floats their weights;
 * - the part of each vertex [V];
 * - the near parts of each part, [part_count,near]: 65535 where it has fewer;
 * - the gains of each vertex that is of a cluster, [vertices,near], in units of 1/128.
 * Getting them allocates. */
PENUMBRA_API size_t penumbra_asset_far_words(const penumbra_asset* asset);
PENUMBRA_API penumbra_status penumbra_asset_get_far(const penumbra_asset* asset, uint32_t* words,
                                                    penumbra_error* error);
/* Does what penumbra_asset_get_cluster does for the residual of a composed model: its coefficients are added to the
 * product, before the ambient term is clamped. Scores are those of penumbra_character_get_residual_scores. `scores`
 * has room for component_count of all clusters of the residual together, in their order. Fails with
 * PENUMBRA_INVALID_ARGUMENT where there is no residual. */
PENUMBRA_API penumbra_status penumbra_asset_get_residual(const penumbra_asset* asset, size_t cluster,
                                                         penumbra_cluster* out);
PENUMBRA_API penumbra_status penumbra_character_get_residual_scores(const penumbra_character* character, float* scores);
/* Writes the GLSL functions that far parts need, as penumbra_cast_get_glsl hands out text. */
PENUMBRA_API penumbra_status penumbra_far_get_glsl(char* text, size_t capacity, size_t* length, penumbra_error* error);

/* --- Shading: the materials and the light that are on. Any number of characters of one asset share it. --- */

typedef struct penumbra_shading penumbra_shading;

typedef enum penumbra_reflectance {
    PENUMBRA_SLICES = 0,    /* exact product of visibility and reflectance */
    PENUMBRA_OPERATORS = 1, /* Nowrouzezahrai 2009 eq 11 */
    PENUMBRA_REFLECTANCE_WIDE = 0x7fffffff
} penumbra_reflectance;
typedef enum penumbra_light_form {
    PENUMBRA_ROTATION = 0,    /* exact SH rotation into every vertex' frame */
    PENUMBRA_FIXED_LOBES = 1, /* zonal lobes on fixed axes, exact */
    PENUMBRA_LOBES = 2,       /* the asset's fitted lobes: as exact as the fit, fewer */
    PENUMBRA_LIGHT_FORM_WIDE = 0x7fffffff
} penumbra_light_form;
typedef struct penumbra_shading_options { /* all zeros are the defaults */
    penumbra_reflectance reflectance;
    penumbra_light_form light_form;
    int caller_light_order; /* 1..8: keep room for penumbra_shading_set_sh_light(); PENUMBRA_ROTATION only. 0: none */
} penumbra_shading_options;

/* Makes a shading. `asset` has the model. The materials and lights are its own, then those of each of `more` (may be
 * NULL with 0), then the caller's light, if any. At first the asset's own choice of materials and light 0 are on. Where
 * one of these lacks what `options` ask for, the first that has it is on instead. Fails with PENUMBRA_UNSUPPORTED
 * without a model, or without such a material or light. `options` may be NULL. */
PENUMBRA_API penumbra_status penumbra_shading_create(const penumbra_asset* asset, const penumbra_asset* const* more,
                                                     size_t more_count, const penumbra_shading_options* options,
                                                     penumbra_shading** shading, penumbra_error* error);
PENUMBRA_API void penumbra_shading_destroy(penumbra_shading* shading);
PENUMBRA_API penumbra_status penumbra_shading_set_simd(penumbra_shading* shading, penumbra_simd simd,
                                                       penumbra_error* error);

#define PENUMBRA_ALL_SLOTS ((size_t)-1)
PENUMBRA_API size_t penumbra_shading_slot_count(const penumbra_shading* shading); /* 1 for a mesh without slots */
PENUMBRA_API size_t penumbra_shading_material_count(const penumbra_shading* shading);
PENUMBRA_API size_t penumbra_shading_light_count(const penumbra_shading* shading);
PENUMBRA_API size_t penumbra_shading_material_of(const penumbra_shading* shading, size_t slot); /* or PENUMBRA_NONE */
PENUMBRA_API size_t penumbra_shading_light(const penumbra_shading* shading);                    /* the one that is on */
/* These fail with PENUMBRA_UNSUPPORTED for a material or light that lacks what the options ask for. */
PENUMBRA_API penumbra_status penumbra_shading_set_material(penumbra_shading* shading, size_t slot, size_t material,
                                                           penumbra_error* error);
PENUMBRA_API penumbra_status penumbra_shading_set_light(penumbra_shading* shading, size_t light, penumbra_error* error);
/* Changes the parameter of a live material, "exponent" of phong-live or "alpha" of ggx-live, or of a material with
 * steps (penumbra-fit brdf --analytic ggx:alpha=0.1..0.6), whose slices are interpolated, from the next frame on. On
 * the CPU nothing else is to do; a GPU gets it with penumbra_shading_get_gpu_light. Fails with PENUMBRA_UNSUPPORTED for
 * a material that stays as it is, and for a name that does not exist. A value out of the parameter's range changes
 * nothing. Allocates nothing. */
PENUMBRA_API penumbra_status penumbra_shading_set_material_parameter(penumbra_shading* shading, size_t material,
                                                                     const char* name, double value,
                                                                     penumbra_error* error);
typedef struct penumbra_parameter {
    const char* name;
    double value, least, most;
} penumbra_parameter;
/* Tells the parameter of such a material. Fails with PENUMBRA_UNSUPPORTED for another. */
PENUMBRA_API penumbra_status penumbra_shading_get_material_parameter(const penumbra_shading* shading, size_t material,
                                                                     penumbra_parameter* out, penumbra_error* error);
/* Sets the caller's own light and switches it on. `sh` is [order^2, 3] and finite, order 1..caller_light_order.
 * `seconds` (finite, 0 or more) have gone by since the last light, for its suns (penumbra_shading_find_suns). Over 0
 * seconds these stay where they are; the first light's are taken as they are. */
PENUMBRA_API penumbra_status penumbra_shading_set_sh_light(penumbra_shading* shading, int order, const float* sh,
                                                           double seconds, penumbra_error* error);
/* Turns the light, and those that are switched on later, in the model frame: L'(s) = L(rotation^T s). It always turns
 * the light as it came. `rotation` has [3,3] rows, orthonormal within 1e-3. */
PENUMBRA_API penumbra_status penumbra_shading_set_light_rotation(penumbra_shading* shading, const float rotation[9],
                                                                 penumbra_error* error);

/* --- Suns: the part of a light that comes from single directions, and casts shadows with edges --- */

#define PENUMBRA_MAX_SUNS 8
typedef struct penumbra_sun {
    float direction[3];  /* unit, towards the sun */
    float irradiance[3]; /* at normal incidence, linear Rec.709 */
    float radius;        /* radians from the center of the disc to its rim; 0: a point */
} penumbra_sun;

/* Suns are off at first, and the light is shaded as it is. While they are on (`on` is not 0), penumbra_shading_shade
 * and the GPU's light are the light without its suns, and penumbra_shading_add_suns adds those. Lights without suns
 * stay as they are. Fails with PENUMBRA_UNSUPPORTED unless the light form is PENUMBRA_ROTATION. */
PENUMBRA_API penumbra_status penumbra_shading_set_suns(penumbra_shading* shading, int on, penumbra_error* error);
/* The suns of the light that is on, as it is turned, in the model frame. 0 while suns are off. */
PENUMBRA_API size_t penumbra_shading_sun_count(const penumbra_shading* shading);
PENUMBRA_API penumbra_status penumbra_shading_get_sun(const penumbra_shading* shading, size_t sun, penumbra_sun* out);
/* Finds up to `most` suns (0..PENUMBRA_MAX_SUNS; 0: none any more) in every light of the caller from now on. They are
 * smoothed over time: after `time_constant` seconds (finite, 0: not at all), 1/e of a difference is left. Suns move
 * with a light that moves, and fade where it jumps. Whatever the suns are, they and what is shaded without them are the
 * whole light. Fails with PENUMBRA_UNSUPPORTED without room for a light of the caller. Allocates. */
PENUMBRA_API penumbra_status penumbra_shading_find_suns(penumbra_shading* shading, int most, double time_constant,
                                                        penumbra_error* error);

/* Computes the radiance towards `eye` (model frame), [V,3], from all arrays of `vertices`. It is not clamped: where SH
 * ring, values may be slightly negative. With several slots the vertices are the ones at [first, first + count) of a
 * list that has the vertices of one slot together. So only calls that cover [0, V) together shade every vertex. A
 * vertex seen from behind its normal gets the radiance of the mirrored view direction. Light that bounces is that of
 * the whole light, while suns are on too. */
PENUMBRA_API penumbra_status penumbra_shading_shade(const penumbra_shading* shading, const float eye[3],
                                                    const penumbra_vertices* vertices, float* radiance,
                                                    penumbra_error* error);
/* Which light the radiance contains: all light, that of the environment alone, or that which bounces alone. */
typedef enum penumbra_bounces {
    PENUMBRA_ALL_LIGHT = 0,
    PENUMBRA_DIRECT_LIGHT = 1,
    PENUMBRA_BOUNCED_LIGHT = 2,
    PENUMBRA_BOUNCES_WIDE = 0x7fffffff
} penumbra_bounces;
/* Chooses it; all light at first. Takes no time. */
PENUMBRA_API penumbra_status penumbra_shading_set_bounces(penumbra_shading* shading, penumbra_bounces bounces,
                                                          penumbra_error* error);
/* Adds to the radiance what the suns that are on send to `eye`: the sum of visibility, irradiance, BRDF and cosine.
 * `visible` is [sun_count, V], the share of each sun, from 0 to 1, that reaches a vertex past everything, the character
 * itself included: from the engine's shadow maps, or from a penumbra_sun_map. Vertices are those of
 * penumbra_shading_shade, but `coefficients` and `bounced` are not read. */
PENUMBRA_API penumbra_status penumbra_shading_add_suns(const penumbra_shading* shading,
                                                       const penumbra_vertices* vertices, const float eye[3],
                                                       const float* visible, float* radiance, penumbra_error* error);

/* A shadow map on the CPU, for tools, tests and engines without a GPU. docs/c-api.md tells when to use it. */
typedef struct penumbra_sun_map penumbra_sun_map;
typedef struct penumbra_sun_caster { /* both sides of the triangles cast */
    const float* positions;          /* [vertex_count,3]; triangles with a vertex that is not finite cast nothing */
    size_t vertex_count;
    const uint32_t* triangles; /* [triangle_count,3] */
    size_t triangle_count;
} penumbra_sun_caster;
/* Makes a map of `size` texels a side (8..8192, 0: 1024) that nothing casts on. */
PENUMBRA_API penumbra_status penumbra_sun_map_create(int size, penumbra_sun_map** map, penumbra_error* error);
PENUMBRA_API void penumbra_sun_map_destroy(penumbra_sun_map* map);
/* Draws the casters as the sun sees them, instead of those before. The sun and all casters have one frame of
 * coordinates, and the map fits them. Only the direction and the radius of the sun are read. Nothing of the arrays is
 * read later. `ground`, unless NULL, is a wide ground with heights that casts as well: where the casters would be small
 * in one map, `map` is several then, fine ones around them inside of coarser ones. Allocates the first time, and where
 * there are more casters than before or a ground. */
PENUMBRA_API penumbra_status penumbra_sun_map_set_casters(penumbra_sun_map* map, const penumbra_sun* sun,
                                                          const penumbra_sun_caster* casters, size_t count,
                                                          const penumbra_sun_caster* ground, penumbra_error* error);
/* Computes the share of the sun, from 0 to 1, that reaches points past all casters, in the casters' frame. `positions`
 * and unit `normals` are [count,3], `visible` is [count]. It is 0 where a surface faces away from the sun, and where a
 * position or a normal is not finite; 1 everywhere while nothing casts. */
PENUMBRA_API penumbra_status penumbra_sun_map_visibility(const penumbra_sun_map* map, const float* positions,
                                                         const float* normals, size_t count, float* visible,
                                                         penumbra_error* error);

/* --- Height fields: ground that moves, shadows itself and characters, and is shaded as characters are --- */

/* A field of rows x columns points, in a frame of a scene with y up: columns go along x, rows along z, heights are
 * metres along y. Light sees it bilinear between points. Feet stand on the two triangles of each square, whose common
 * side goes from (row + 1, column) to (row, column + 1). What its points see has coefficients of convention D and of
 * the field's order, PENUMBRA_HEIGHTS_STRIDE to a point, in the frame of the point's normal and tangent. */
typedef struct penumbra_heights penumbra_heights;
#define PENUMBRA_HEIGHTS_STRIDE 16
typedef enum penumbra_height_border {
    PENUMBRA_BORDER_CLAMPED = 0,  /* beyond the edge its heights go on for ever */
    PENUMBRA_BORDER_PERIODIC = 1, /* beyond the edge the field begins again */
    PENUMBRA_BORDER_OPEN = 2,     /* beyond the edge is nothing, and light comes from below the horizontal */
    PENUMBRA_BORDER_WIDE = 0x7fffffff
} penumbra_height_border;
typedef struct penumbra_heights_options {
    size_t rows, columns; /* points, 1..65536 each, at most 2^26 together */
    float cell_x, cell_z; /* metres from column to column, from row to row, 1e-4..1e5 */
    float corner[3];      /* where height 0 of row 0 and column 0 stands */
    penumbra_height_border border;
    int order; /* order of the visibility, 4 or 5; 0: 5 */
    int step;  /* points from one place that looks for its horizon to the next: 1, 2, 4 or 8; 0: 4 */
} penumbra_heights_options;

/* Makes a field of `heights` [rows,columns], which are finite and at most 1e7. */
PENUMBRA_API penumbra_status penumbra_heights_create(const penumbra_heights_options* options, const float* heights,
                                                     penumbra_heights** field, penumbra_error* error);
PENUMBRA_API void penumbra_heights_destroy(penumbra_heights* field);
/* Lets more places look for their horizons wherever the error of visibility between those of a step, which the field
 * estimates, is above `tolerance` (rms): 0.025 is a good one, and 0, as a new field has it, turns it off. Call
 * _update and _get_points anew after it. */
PENUMBRA_API penumbra_status penumbra_heights_set_tolerance(penumbra_heights* field, float tolerance,
                                                            penumbra_error* error);
/* Replaces the heights of a box, [row_count,column_count]: all of them for an animation, few for an edit. */
PENUMBRA_API penumbra_status penumbra_heights_set(penumbra_heights* field, size_t first_row, size_t row_count,
                                                  size_t first_column, size_t column_count, const float* heights,
                                                  penumbra_error* error);
/* Looks for the horizons of rows [first, first + count) of all penumbra_heights_update_rows() that see something that
 * _set changed. Call it for all rows before _get_points. Calls for different rows may run at the same time. */
PENUMBRA_API size_t penumbra_heights_update_rows(const penumbra_heights* field);
PENUMBRA_API penumbra_status penumbra_heights_update(penumbra_heights* field, size_t first, size_t count,
                                                     penumbra_error* error);
/* Computes rows [first_row, first_row + row_count) of the points, whatever the range of `points`. `coefficients` are
 * [rows*columns,PENUMBRA_HEIGHTS_STRIDE], and `bounced` is not written. Any array may be NULL. Penumbra scenes then
 * multiply the coefficients by what characters leave visible with penumbra_heights_cast. With a tolerance, calls are
 * cheapest for whole runs of `step` rows that begin at a multiple of it. */
PENUMBRA_API penumbra_status penumbra_heights_get_points(const penumbra_heights* field, size_t first_row,
                                                         size_t row_count, const penumbra_vertices* points,
                                                         penumbra_error* error);
/* Multiplies `coefficients` of points, as _get_points has them, by what the casters of a scene leave visible. */
PENUMBRA_API penumbra_status penumbra_heights_cast(const penumbra_heights* field, const penumbra_scene* scene,
                                                   const penumbra_vertices* points, penumbra_error* error);
/* Multiplies `coefficients` and `bounced` of a character's vertices by what the field leaves visible there, as
 * penumbra_scene_cast does for casters, and with the same arguments. */
PENUMBRA_API penumbra_status penumbra_heights_shadow(const penumbra_heights* field, const penumbra_character* character,
                                                     const float* to_scene, const penumbra_vertices* vertices,
                                                     penumbra_error* error);
/* Writes y of the ground at each place (x, z), [count,2], on the triangles that feet stand on. */
PENUMBRA_API penumbra_status penumbra_heights_query(const penumbra_heights* field, const float* places, size_t count,
                                                    float* heights, penumbra_error* error);
/* Writes y of the ground under a pose, whose points `positions` [count,3] are in a frame of their own, as
 * penumbra_character_skin() gives them; `to_scene` brings them to the scene. It is the mean under the lowest points,
 * and changes without a jump while feet leave the ground and land. A scene's "on_ground" adds it to the y of
 * `to_scene`. */
PENUMBRA_API penumbra_status penumbra_heights_under(const penumbra_heights* field, const float* positions, size_t count,
                                                    const float* to_scene, float* height, penumbra_error* error);
/* Gives the field a look: material `material` of the asset, or with PENUMBRA_NONE a Lambertian one of `albedo` [3], in
 * light `light` of the asset, turned by `rotation` [9] (NULL: not). The field keeps what it needs of the asset.
 * Allocates. */
PENUMBRA_API penumbra_status penumbra_heights_set_look(penumbra_heights* field, const penumbra_asset* asset,
                                                       size_t material, const float* albedo, size_t light,
                                                       const float* rotation, penumbra_error* error);
/* Writes the radiance of points, as _get_points has them, towards `eye`, [rows*columns,3]. Fails before _set_look. */
PENUMBRA_API penumbra_status penumbra_heights_shade(const penumbra_heights* field, const float eye[3],
                                                    const penumbra_vertices* points, float* radiance,
                                                    penumbra_error* error);

/* --- For engines that shade on the GPU. penumbra.glsl tells how these come together. --- */

/* Writes the GLSL functions penumbra_ambient(), penumbra_clamp_ambient() and penumbra_shade() for all materials and
 * lights of the shading. Switching and turning then changes only numbers in buffers. `*length` becomes the length
 * without the final zero. `text` may be NULL to ask for the length; otherwise it has room for `capacity` characters.
 * Allocates. */
PENUMBRA_API penumbra_status penumbra_shading_get_glsl(const penumbra_shading* shading, char* text, size_t capacity,
                                                       size_t* length, penumbra_error* error);
PENUMBRA_API size_t penumbra_shading_gpu_material_texels(const penumbra_shading* shading); /* texels of one material */
PENUMBRA_API size_t penumbra_shading_gpu_light_texels(const penumbra_shading* shading);
/* Writes [material_count, gpu_material_texels, 4] for PENUMBRA_MATERIAL. One call is enough. Allocates. */
PENUMBRA_API penumbra_status penumbra_shading_get_gpu_materials(const penumbra_shading* shading, float* texels,
                                                                penumbra_error* error);
/* Writes [gpu_light_texels, 4] for PENUMBRA_LIGHT: the light that is on, as it is turned, and what materials with
 * a parameter are now. Call it after every change of either. */
PENUMBRA_API penumbra_status penumbra_shading_get_gpu_light(const penumbra_shading* shading, float* texels,
                                                            penumbra_error* error);

/* Writes the GLSL functions penumbra_brdf_lobe() and penumbra_mirror_reflectance(), which evaluate a penumbra_lobe for
 * two directions. They are the same for all assets. docs/gpu.md has the light of a sun with them, a pixel at a time.
 * `text`, `capacity` and `length` are as there. Allocates. */
PENUMBRA_API penumbra_status penumbra_brdf_get_glsl(char* text, size_t capacity, size_t* length, penumbra_error* error);

/* Writes the GLSL functions penumbra_cast_visibility() and penumbra_cast_mirror() for casters that are spheres,
 * penumbra_cast_fields() and penumbra_cast_combine() for parts with fields, and penumbra_cast_ambient() for both: what
 * casters leave visible at any point. With an asset the text also has penumbra_cast_coefficients(), which
 * multiplies the coefficients of that asset's vertices by it; it then stands behind the text of
 * penumbra_shading_get_glsl. docs/gpu.md tells how they come together. `asset` may be NULL; `text`, `capacity` and
 * `length` are as there. Allocates. */
PENUMBRA_API penumbra_status penumbra_cast_get_glsl(const penumbra_asset* asset, char* text, size_t capacity,
                                                    size_t* length, penumbra_error* error);
/* Writes [PENUMBRA_CAP_LOG_TEXELS,4] for PENUMBRA_CAP_LOG, the same table for all casters. One call is enough.
 * Allocates. */
#define PENUMBRA_CAP_LOG_TEXELS 1024
PENUMBRA_API penumbra_status penumbra_get_cap_logs(float* texels, penumbra_error* error);

#ifdef __cplusplus
}
#endif

#endif
