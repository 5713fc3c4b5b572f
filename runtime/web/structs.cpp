// Where the fields of the C interface's structs lie in WebAssembly: src/core.ts reads and writes them by these numbers.
#include <cstddef>

#include "runtime/penumbra.h"

namespace {

#define PENUMBRA_AT(type, field, offset) static_assert(offsetof(type, field) == (offset))

static_assert(sizeof(penumbra_error) == 512);
PENUMBRA_AT(penumbra_error, message, 4);

static_assert(sizeof(penumbra_asset_info) == 136);
PENUMBRA_AT(penumbra_asset_info, has_model, 0);
PENUMBRA_AT(penumbra_asset_info, provenance, 4);
PENUMBRA_AT(penumbra_asset_info, vertex_count, 8);
PENUMBRA_AT(penumbra_asset_info, source_vertex_count, 12);
PENUMBRA_AT(penumbra_asset_info, triangle_count, 16);
PENUMBRA_AT(penumbra_asset_info, rest_positions, 20);
PENUMBRA_AT(penumbra_asset_info, rest_normals, 24);
PENUMBRA_AT(penumbra_asset_info, triangles, 32);
PENUMBRA_AT(penumbra_asset_info, source_vertex, 36);
PENUMBRA_AT(penumbra_asset_info, slot_count, 52);
PENUMBRA_AT(penumbra_asset_info, deforming, 60);
PENUMBRA_AT(penumbra_asset_info, two_sided, 64);
PENUMBRA_AT(penumbra_asset_info, input_count, 72);
PENUMBRA_AT(penumbra_asset_info, joint_count, 76);
PENUMBRA_AT(penumbra_asset_info, inverse_bind, 88);
PENUMBRA_AT(penumbra_asset_info, clip_count, 92);
PENUMBRA_AT(penumbra_asset_info, frame_count, 96);
PENUMBRA_AT(penumbra_asset_info, rotation_count, 100);
PENUMBRA_AT(penumbra_asset_info, convention, 104);
PENUMBRA_AT(penumbra_asset_info, coefficient_count, 108);
PENUMBRA_AT(penumbra_asset_info, stride, 112);
PENUMBRA_AT(penumbra_asset_info, cluster_count, 116);
PENUMBRA_AT(penumbra_asset_info, score_count, 120);
PENUMBRA_AT(penumbra_asset_info, material_count, 128);
PENUMBRA_AT(penumbra_asset_info, light_count, 132);

static_assert(sizeof(penumbra_clip) == 16);
PENUMBRA_AT(penumbra_clip, held_out, 12);

static_assert(sizeof(penumbra_cluster) == 40);
PENUMBRA_AT(penumbra_cluster, mean_precision, 20);
PENUMBRA_AT(penumbra_cluster, mean, 28);
PENUMBRA_AT(penumbra_cluster, basis_scale, 36);

static_assert(sizeof(penumbra_frame) == 24);
PENUMBRA_AT(penumbra_frame, matrices, 8);

PENUMBRA_AT(penumbra_light, sh, 8);
PENUMBRA_AT(penumbra_light, sun_count, 16);

static_assert(sizeof(penumbra_vertices) == 32);
PENUMBRA_AT(penumbra_vertices, coefficients, 12);
PENUMBRA_AT(penumbra_vertices, bounced, 16);
PENUMBRA_AT(penumbra_vertices, first, 20);

static_assert(sizeof(penumbra_points) == 12);
static_assert(sizeof(penumbra_shading_options) == 12);
PENUMBRA_AT(penumbra_shading_options, caller_light_order, 8);

}  // namespace
