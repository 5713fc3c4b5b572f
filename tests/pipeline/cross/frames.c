/* Writes what the library makes of an asset, so that builds for different processors and systems can be compared.
 *
 * usage: frames ASSET OUT [FILE...]
 * OUT gets the numbers of frames and vertices as uint32, for every frame the positions [V,3] and E [V], and at last E
 * [16,16] of a ground that the character stands on, where it casts. Prints the status with which each FILE opens. */
#include <penumbra.h>
#include <stdio.h>
#include <stdlib.h>

#define SIDE 16

static penumbra_error error;

static void check(penumbra_status status) {
    if (status == PENUMBRA_OK) return;
    fprintf(stderr, "%s\n", error.message);
    exit(1);
}

static float* floats(size_t count) {
    float* array = calloc(count, sizeof(float));
    if (array) return array;
    fprintf(stderr, "out of memory\n");
    exit(1);
}

/* The ground lies below the first vertex, as deep as the lowest one. */
static void write_ground(const penumbra_asset* asset, const penumbra_character* character,
                         const penumbra_vertices* vertices, FILE* out) {
    const float* p = vertices->positions;
    float low = p[1];
    for (size_t v = 0; v < vertices->count; ++v) low = p[3 * v + 1] < low ? p[3 * v + 1] : low;
    penumbra_scene* scene;
    float *positions = floats(3 * SIDE * SIDE), *normals = floats(3 * SIDE * SIDE), *ambient = floats(SIDE * SIDE);
    const penumbra_points points = {positions, normals, SIDE * SIDE};
    check(penumbra_scene_create(&asset, 1, &scene, &error));
    for (size_t i = 0; i < SIDE * SIDE; ++i) {
        positions[3 * i] = p[0] + ((float)(i % SIDE) - SIDE / 2) * 0.125f;
        positions[3 * i + 1] = low;
        positions[3 * i + 2] = p[2] + ((float)(i / SIDE) - SIDE / 2) * 0.125f;
        normals[3 * i + 1] = 1;
    }
    check(penumbra_scene_set_caster(scene, 0, character, NULL, &error));
    check(penumbra_scene_ambient(scene, PENUMBRA_NONE, &points, ambient, &error));
    fwrite(ambient, sizeof(float), SIDE * SIDE, out);
    penumbra_scene_destroy(scene);
    free(positions);
    free(normals);
    free(ambient);
}

static void write_frames(const penumbra_asset* asset, FILE* out) {
    penumbra_asset_info info;
    penumbra_character* character;
    check(penumbra_asset_get_info(asset, &info));
    check(penumbra_character_create(asset, &character, &error));
    const size_t n = info.vertex_count;
    penumbra_vertices vertices = {floats(3 * n), floats(3 * n), floats(3 * n), floats(info.stride * n), NULL, 0, n,
                                  NULL};
    float* ambient = floats(n);
    const uint32_t sizes[2] = {(uint32_t)info.frame_count, (uint32_t)n};
    fwrite(sizes, sizeof sizes, 1, out);
    for (size_t frame = 0; frame < info.frame_count; ++frame) {
        check(penumbra_character_set_frame(character, frame, &error));
        check(penumbra_character_evaluate(character, 0, info.cluster_count, &vertices, &error));
        check(penumbra_character_skin(character, &vertices, &error));
        check(penumbra_character_ambient(character, &vertices, ambient, &error));
        fwrite(vertices.positions, sizeof(float), 3 * n, out);
        fwrite(ambient, sizeof(float), n, out);
    }
    if (penumbra_asset_part_count(asset) > 0) write_ground(asset, character, &vertices, out);
    penumbra_character_destroy(character);
    free(vertices.positions);
    free(vertices.normals);
    free(vertices.tangents);
    free(vertices.coefficients);
    free(ambient);
}

int main(int argc, char** argv) {
    penumbra_asset* asset;
    FILE* out = argc < 3 ? NULL : fopen(argv[2], "wb");
    if (!out) return 2;
    check(penumbra_asset_open_file(argv[1], &asset, &error));
    write_frames(asset, out);
    penumbra_asset_close(asset);
    if (fclose(out) != 0) return 2;
    for (int i = 3; i < argc; ++i) {
        const penumbra_status status = penumbra_asset_open_file(argv[i], &asset, NULL);
        printf("%s\n", penumbra_status_name(status));
        if (status == PENUMBRA_OK) penumbra_asset_close(asset);
    }
    return 0;
}
