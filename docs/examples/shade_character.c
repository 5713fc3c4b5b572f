/* Plays a clip of an asset on the CPU and writes its last frame as a picture:
 *   cc -std=c99 shade_character.c $(pkg-config --cflags --libs penumbra) -lm -o shade_character
 *   ./shade_character character.pnb OUT.ppm [CLIP]
 * docs/c-api.md explains the calls. */
#include <math.h>
#include <penumbra.h>
#include <stdio.h>
#include <stdlib.h>

enum { SIZE = 256 };

static penumbra_error error;

static void check(penumbra_status status) {
    if (status == PENUMBRA_OK) return;
    fprintf(stderr, "shade_character: %s: %s\n", penumbra_status_name(status), error.message);
    exit(1);
}

static float* floats(size_t count) {
    float* p = calloc(count, sizeof *p);
    if (!p) exit(4);
    return p;
}

/* Seen along -z, `size` metres high around `center`: barycentric coordinates, depth test, gamma 2.2. */
static void draw(const float* p, const float* color, const uint32_t* t, size_t triangles, const float* center,
                 float size, unsigned char* rgb, float* depth) {
    for (; triangles > 0; --triangles, t += 3) {
        float x[3], y[3];
        for (int i = 0; i < 3; ++i) {
            x[i] = (p[3 * t[i]] - center[0]) / size * SIZE + SIZE / 2;
            y[i] = (center[1] - p[3 * t[i] + 1]) / size * SIZE + SIZE / 2;
        }
        const float area = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]);
        if (!(area < 0)) continue; /* seen from behind */
        const int left = (int)fmaxf(0, fminf(x[0], fminf(x[1], x[2])));
        const int right = (int)fminf(SIZE - 1, fmaxf(x[0], fmaxf(x[1], x[2])));
        const int top = (int)fmaxf(0, fminf(y[0], fminf(y[1], y[2])));
        const int bottom = (int)fminf(SIZE - 1, fmaxf(y[0], fmaxf(y[1], y[2])));
        for (int row = top; row <= bottom; ++row)
            for (int column = left; column <= right; ++column) {
                const float w1 = ((column - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (row - y[0])) / area;
                const float w2 = ((x[1] - x[0]) * (row - y[0]) - (column - x[0]) * (y[1] - y[0])) / area;
                const float w0 = 1 - w1 - w2, z = w0 * p[3 * t[0] + 2] + w1 * p[3 * t[1] + 2] + w2 * p[3 * t[2] + 2];
                const size_t at = (size_t)row * SIZE + (size_t)column;
                if (w0 < 0 || w1 < 0 || w2 < 0 || z <= depth[at]) continue;
                depth[at] = z;
                for (int c = 0; c < 3; ++c) {
                    const float v = w0 * color[3 * t[0] + c] + w1 * color[3 * t[1] + c] + w2 * color[3 * t[2] + c];
                    rgb[3 * at + (size_t)c] = (unsigned char)(255 * powf(fminf(fmaxf(v, 0), 1), 1 / 2.2f) + 0.5f);
                }
            }
    }
}

int main(int argc, char** argv) {
    if (argc < 3) return fprintf(stderr, "usage: shade_character ASSET.pnb OUT.ppm [CLIP]\n"), 1;
    penumbra_asset* asset;
    penumbra_character* character;
    penumbra_shading* shading;
    check(penumbra_asset_open_file(argv[1], &asset, &error));
    check(penumbra_character_create(asset, &character, &error));
    check(penumbra_shading_create(asset, NULL, 0, NULL, &shading, &error));

    penumbra_asset_info info;
    penumbra_clip clip;
    check(penumbra_asset_get_info(asset, &info));
    if (penumbra_asset_get_clip(asset, argc > 3 ? penumbra_asset_find_clip(asset, argv[3]) : 0, &clip) != PENUMBRA_OK)
        return fprintf(stderr, "shade_character: %s has no clip %s\n", argv[1], argc > 3 ? argv[3] : "at all"), 1;
    FILE* out = fopen(argv[2], "wb");
    if (!out) return perror(argv[2]), 2;
    const size_t n = info.vertex_count;
    float *positions = floats(3 * n), *normals = floats(3 * n), *tangents = floats(3 * n), *radiance = floats(3 * n);
    float *coefficients = floats(n * info.stride), *ambient = floats(n), center[3] = {0, 0, 0};
    const float eye[3] = {0, 1, 1000}; /* far away, as the picture has no perspective */
    const penumbra_vertices vertices = {positions, normals, tangents, coefficients, NULL, 0, n, NULL};
    for (size_t frame = clip.first_frame; frame < clip.first_frame + clip.frame_count; ++frame) {
        check(penumbra_character_set_frame(character, frame, &error));
        check(penumbra_character_evaluate(character, 0, info.cluster_count, &vertices, &error));
        check(penumbra_character_skin(character, &vertices, &error));
        check(penumbra_character_ambient(character, &vertices, ambient, &error));
        check(penumbra_shading_shade(shading, eye, &vertices, radiance, &error));
        double mean = 0;
        for (size_t v = 0; v < n; ++v) mean += ambient[v] / (double)n;
        printf("frame %zu: mean ambient %.4f, out of range %.3f\n", frame, mean,
               penumbra_character_out_of_range(character));
    }
    for (size_t i = 0; i < 3 * n; ++i) center[i % 3] += positions[i] / (float)n;
    static unsigned char rgb[3 * SIZE * SIZE];
    static float depth[SIZE * SIZE];
    for (size_t i = 0; i < SIZE * SIZE; ++i) depth[i] = -1e30f;
    draw(positions, radiance, info.triangles, info.triangle_count, center, 2.2f, rgb, depth);
    fprintf(out, "P6 %d %d 255\n", SIZE, SIZE), fwrite(rgb, SIZE * SIZE, 3, out);
    if (ferror(out) || fclose(out)) return perror(argv[2]), 2;
    free(positions), free(normals), free(tangents), free(radiance), free(coefficients), free(ambient);
    penumbra_shading_destroy(shading), penumbra_character_destroy(character), penumbra_asset_close(asset);
    return 0;
}
