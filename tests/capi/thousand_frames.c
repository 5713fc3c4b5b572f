/* Opens an asset, plays FRAMES frames with everything that changes from frame to frame, and gives all back: for tools
 * that watch memory. usage: thousand_frames ASSET.pnb FRAMES portable|avx2 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "runtime/penumbra.h"

static penumbra_error error;

static void check(penumbra_status status) {
    if (status == PENUMBRA_OK) return;
    fprintf(stderr, "%s: %s\n", penumbra_status_name(status), error.message);
    exit(1);
}

/* Allocated, not zeroed: a tool sees what is read before it is written. */
static float* floats(size_t count) { return malloc(count * sizeof(float)); }

static size_t frames;
static penumbra_simd simd;

static double play(const penumbra_asset* asset) {
    static const float eye[3] = {0, 1, 3}, turn[9] = {0, 0, 1, 0, 1, 0, -1, 0, 0};
    penumbra_asset_info info;
    penumbra_light light;
    penumbra_character* character;
    penumbra_shading* shading;
    const penumbra_shading_options options = {PENUMBRA_SLICES, PENUMBRA_ROTATION, 4};
    check(penumbra_asset_get_info(asset, &info));
    check(penumbra_asset_get_light(asset, 0, &light));
    check(penumbra_character_create(asset, &character, &error));
    check(penumbra_shading_create(asset, &asset, 1, &options, &shading, &error));
    check(penumbra_character_set_simd(character, simd, &error));
    check(penumbra_shading_set_simd(shading, simd, &error));
    const size_t n = info.vertex_count;
    float *positions = floats(3 * n), *normals = floats(3 * n), *tangents = floats(3 * n), *radiance = floats(3 * n);
    float *coefficients = floats(n * info.stride), *ambient = floats(n);
    const penumbra_vertices vertices = {positions, normals, tangents, coefficients, NULL, 0, n, NULL};
    const size_t materials = penumbra_shading_material_count(shading);
    double sum = 0;
    for (size_t frame = 0; frame < frames; ++frame) {
        check(penumbra_character_set_frame(character, frame % info.frame_count, &error));
        check(penumbra_character_evaluate(character, 0, info.cluster_count, &vertices, &error));
        check(penumbra_character_skin(character, &vertices, &error));
        check(penumbra_character_ambient(character, &vertices, ambient, &error));
        if (frame % 2) check(penumbra_shading_set_sh_light(shading, light.order, light.sh, 0, &error));
        check(penumbra_shading_set_light_rotation(shading, turn, &error));
        for (size_t slot = 0; slot < penumbra_shading_slot_count(shading); ++slot)
            check(penumbra_shading_set_material(shading, slot, (frame + slot) % materials, &error));
        check(penumbra_shading_shade(shading, eye, &vertices, radiance, &error));
        for (size_t v = 0; v < n; ++v) sum += ambient[v] + radiance[3 * v];
        if (frame % 2 == 0) check(penumbra_shading_set_light(shading, frame % 4 / 2, &error));
    }
    penumbra_character_destroy(character);
    penumbra_shading_destroy(shading);
    free(positions), free(normals), free(tangents), free(radiance), free(coefficients), free(ambient);
    return sum;
}

int main(int argc, char** argv) {
    penumbra_asset* asset;
    if (argc != 4) return 1;
    frames = (size_t)atol(argv[2]);
    simd = strcmp(argv[3], "avx2") ? PENUMBRA_SIMD_PORTABLE : PENUMBRA_SIMD_AVX2;
    if (!penumbra_has_simd(simd)) return printf("this processor has no %s\n", argv[3]), 0;
    check(penumbra_asset_open_file(argv[1], &asset, &error));
    printf("%.6g after %zu frames\n", play(asset), frames);
    penumbra_asset_close(asset);
    return 0;
}
