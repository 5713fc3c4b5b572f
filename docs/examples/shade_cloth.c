/* Moves a deforming asset (cloth) by itself, as an engine's simulation would, and says what a frame costs:
 *   cc -std=c99 shade_cloth.c $(pkg-config --cflags --libs penumbra) -lm -o shade_cloth
 *   ./shade_cloth cloth.pnb [FRAMES]
 * docs/c-api.md explains the calls. */
#define _POSIX_C_SOURCE 199309L
#include <math.h>
#include <penumbra.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

static penumbra_error error;

static void check(penumbra_status status) {
    if (status == PENUMBRA_OK) return;
    fprintf(stderr, "shade_cloth: %s: %s\n", penumbra_status_name(status), error.message);
    exit(1);
}

static float* floats(size_t count) {
    float* p = calloc(count ? count : 1, sizeof *p);
    if (!p) exit(4);
    return p;
}

static double milliseconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return 1e3 * (double)now.tv_sec + 1e-6 * (double)now.tv_nsec;
}

int main(int argc, char** argv) {
    if (argc < 2) return fprintf(stderr, "usage: shade_cloth CLOTH.pnb [FRAMES]\n"), 1;
    penumbra_asset* asset;
    penumbra_character* character;
    penumbra_asset_info info;
    check(penumbra_asset_open_file(argv[1], &asset, &error));
    check(penumbra_character_create(asset, &character, &error));
    check(penumbra_asset_get_info(asset, &info));
    const size_t n = info.vertex_count;
    float *moved = floats(3 * n), *inputs = floats(info.input_count), *coefficients = floats(n * info.stride);
    float *positions = floats(3 * n), *normals = floats(3 * n), *tangents = floats(3 * n), *ambient = floats(n);
    const penumbra_vertices vertices = {positions, normals, tangents, coefficients, NULL, 0, n, NULL};
    penumbra_frame first; /* an engine knows its inputs; here they are those of the first frame */
    const int known = penumbra_asset_get_frame(asset, 0, &first) == PENUMBRA_OK;
    for (size_t i = 0; i < info.input_count; ++i) {
        if (known) inputs[i] = first.inputs[i];
        printf("input %s: %g\n", penumbra_asset_input_name(asset, i), (double)inputs[i]);
    }

    double mean = 0, pose = 0, evaluate = 0, place = 0;
    const int frames = argc > 2 ? atoi(argv[2]) : 100;
    for (int frame = 0; frame < frames; ++frame) {
        for (size_t v = 0; v < n; ++v) { /* the simulation: a wave through the rest positions */
            const float* rest = info.rest_positions + 3 * v;
            const float wave = 0.05f * sinf(6 * rest[0] + 4 * rest[1] + 0.1f * (float)frame);
            for (int i = 0; i < 3; ++i) moved[3 * v + (size_t)i] = rest[i] + (i == 2 ? wave : 0);
        }
        const double start = milliseconds();
        check(penumbra_character_set_positions(character, PENUMBRA_ASSET_VERTICES, moved, n, inputs, info.input_count,
                                               &error));
        const double posed = milliseconds();
        check(penumbra_character_evaluate(character, 0, info.cluster_count, &vertices, &error));
        const double evaluated = milliseconds();
        check(penumbra_character_skin(character, &vertices, &error));
        pose += posed - start, evaluate += evaluated - posed, place += milliseconds() - evaluated;
        check(penumbra_character_ambient(character, &vertices, ambient, &error));
    }
    for (size_t v = 0; v < n; ++v) mean += ambient[v] / (double)n;
    printf("%zu vertices: set_positions %.3f ms, evaluate %.3f ms, skin %.3f ms a frame; mean ambient %.4f\n", n,
           pose / frames, evaluate / frames, place / frames, mean);
    free(moved), free(inputs), free(coefficients), free(positions), free(normals), free(tangents), free(ambient);
    penumbra_character_destroy(character), penumbra_asset_close(asset);
    return 0;
}
