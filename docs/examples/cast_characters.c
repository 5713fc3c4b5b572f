/* Puts two characters of an asset on a ground and writes what they leave of the sky there, seen from above:
 *   cc -std=c99 cast_characters.c $(pkg-config --cflags --libs penumbra) -o cast_characters
 *   ./cast_characters character.pnb OUT.pgm [METRES APART]
 * The asset must be of a composed model. docs/c-api.md explains the calls. */
#include <penumbra.h>
#include <stdio.h>
#include <stdlib.h>

enum { SIDE = 256 };

static penumbra_error error;

static void check(penumbra_status status) {
    if (status == PENUMBRA_OK) return;
    fprintf(stderr, "cast_characters: %s: %s\n", penumbra_status_name(status), error.message);
    exit(1);
}

int main(int argc, char** argv) {
    if (argc < 3) return fprintf(stderr, "usage: cast_characters ASSET.pnb OUT.pgm [METRES]\n"), 1;
    const float apart = argc > 3 ? (float)atof(argv[3]) : 0.8f;
    penumbra_asset* asset;
    penumbra_character* characters[2];
    penumbra_scene* scene;
    check(penumbra_asset_open_file(argv[1], &asset, &error));
    const penumbra_asset* of_casters[2] = {asset, asset};
    check(penumbra_scene_create(of_casters, 2, &scene, &error));
    penumbra_asset_info info;
    check(penumbra_asset_get_info(asset, &info));
    float* coefficients = malloc(info.vertex_count * info.stride * sizeof *coefficients);
    float* ambient = malloc(info.vertex_count * sizeof *ambient);
    if (!coefficients || !ambient) return 4;
    const penumbra_vertices vertices = {NULL, NULL, NULL, coefficients, NULL, 0, info.vertex_count,
                                        NULL}; /* these calls need no more */

    /* Everyone takes a pose first, and then casts on the others. */
    const float places[2][12] = {{1, 0, 0, -apart / 2, 0, 1, 0, 0, 0, 0, 1, 0},
                                 {-1, 0, 0, apart / 2, 0, 1, 0, 0, 0, 0, -1, 0}};
    for (size_t i = 0; i < 2; ++i) {
        check(penumbra_character_create(asset, &characters[i], &error));
        if (info.frame_count > 0)
            check(penumbra_character_set_frame(characters[i], i * (info.frame_count / 2), &error));
        check(penumbra_scene_set_caster(scene, i, characters[i], places[i], &error));
    }
    for (size_t i = 0; i < 2; ++i) {
        double mean[2] = {0, 0};
        check(penumbra_character_evaluate(characters[i], 0, info.cluster_count, &vertices, &error));
        for (int with = 0; with < 2; ++with) {
            if (with) check(penumbra_scene_cast(scene, i, characters[i], places[i], &vertices, &error));
            check(penumbra_character_ambient(characters[i], &vertices, ambient, &error));
            for (size_t v = 0; v < info.vertex_count; ++v) mean[with] += ambient[v] / (double)info.vertex_count;
        }
        printf("character %zu: mean ambient %.4f alone, %.4f beside the other\n", i, mean[0], mean[1]);
    }

    /* The ground: 3 m wide, row by row, so that neighbours follow one another. */
    static float positions[SIDE * SIDE][3], normals[SIDE * SIDE][3], e[SIDE * SIDE];
    static unsigned char grey[SIDE * SIDE];
    for (int i = 0; i < SIDE * SIDE; ++i) {
        positions[i][0] = 3.0f * ((i % SIDE) / (SIDE - 1.0f) - 0.5f);
        positions[i][2] = 3.0f * ((i / SIDE) / (SIDE - 1.0f) - 0.5f);
        normals[i][1] = 1;
    }
    const penumbra_points ground = {positions[0], normals[0], SIDE * SIDE};
    check(penumbra_scene_ambient(scene, PENUMBRA_NONE, &ground, e, &error));
    for (int i = 0; i < SIDE * SIDE; ++i) grey[i] = (unsigned char)(255 * e[i] + 0.5f);
    FILE* out = fopen(argv[2], "wb");
    if (!out) return perror(argv[2]), 2;
    fprintf(out, "P5 %d %d 255\n", SIDE, SIDE), fwrite(grey, 1, sizeof grey, out);
    if (ferror(out) || fclose(out)) return perror(argv[2]), 2;
    free(coefficients), free(ambient);
    penumbra_scene_destroy(scene), penumbra_asset_close(asset);
    for (size_t i = 0; i < 2; ++i) penumbra_character_destroy(characters[i]);
    return 0;
}
