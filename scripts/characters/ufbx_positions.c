// Where ufbx puts the vertices of an FBX file: ufbx_positions FILE REQUEST OUT
//
// Compiled by references.py with ufbx.c. REQUEST has a line "clip seconds" a frame; clip numbers the animation stacks,
// -1 is the file as it stands. OUT gets frames x points x 3 doubles: metres, y up, the corners of visible polygons.
// Prints {"clips": [[name, seconds], ...], "points", "rate"}; rate: frames a second.
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ufbx.h"

static int shown(const ufbx_node* node) {
    for (; node; node = node->parent)
        if (!node->visible) return 0;
    return 1;
}

// Writes the points of one mesh as one of its nodes shows them, each vertex of a polygon once. Returns their number.
static size_t writeMesh(const ufbx_mesh* mesh, const ufbx_node* node, FILE* out) {
    char* used = calloc(mesh->num_vertices + 1, 1);
    size_t count = 0;
    for (size_t f = 0; f < mesh->faces.count; ++f) {
        const ufbx_face face = mesh->faces.data[f];
        if (face.num_indices < 3) continue;
        for (uint32_t k = face.index_begin; k < face.index_begin + face.num_indices; ++k)
            used[mesh->vertex_indices.data[k]] = 1;
    }
    for (size_t v = 0; v < mesh->num_vertices; ++v) {
        if (!used[v]) continue;
        ufbx_vec3 p =
            mesh->skinned_position.values.data[mesh->skinned_position.indices.data[mesh->vertex_first_index.data[v]]];
        if (mesh->skinned_is_local) p = ufbx_transform_position(&node->geometry_to_world, p);
        const double xyz[3] = {p.x, p.y, p.z};
        if (out) fwrite(xyz, sizeof(double), 3, out);
        ++count;
    }
    free(used);
    return count;
}

// Writes the nodes that are visible in `filed`, the scene without a clip.
static size_t writeScene(const ufbx_scene* scene, const ufbx_scene* filed, FILE* out) {
    size_t count = 0;
    for (size_t m = 0; m < scene->meshes.count; ++m) {
        const ufbx_mesh* mesh = scene->meshes.data[m];
        for (size_t i = 0; i < mesh->instances.count; ++i) {
            const ufbx_node* node = mesh->instances.data[i];
            if (shown(filed->nodes.data[node->typed_id])) count += writeMesh(mesh, node, out);
        }
    }
    return count;
}

static void printClips(const ufbx_scene* scene, size_t points) {
    printf("{\"clips\": [");
    for (size_t s = 0; s < scene->anim_stacks.count; ++s) {
        const ufbx_anim_stack* stack = scene->anim_stacks.data[s];
        printf("%s[\"", s ? ", " : "");
        for (const char* c = stack->name.data; *c; ++c) printf(*c == '"' || *c == '\\' ? "\\%c" : "%c", *c);
        printf("\", %.9g]", stack->time_end - stack->time_begin);
    }
    printf("], \"points\": %zu, \"rate\": %.9g}\n", points, scene->settings.frames_per_second);
}

int main(int argc, char** argv) {
    if (argc != 4) return 1;
    ufbx_load_opts options = {0};
    options.target_axes = ufbx_axes_right_handed_y_up;
    options.target_unit_meters = 1;
    options.evaluate_skinning = true;
    ufbx_error error;
    ufbx_scene* scene = ufbx_load_file(argv[1], &options, &error);
    if (!scene) return fprintf(stderr, "Error: %s\n", error.description.data), 3;
    FILE* request = fopen(argv[2], "r");
    FILE* out = fopen(argv[3], "wb");
    if (!request || !out) return 2;
    int clip;
    double seconds;
    while (fscanf(request, "%d %lf", &clip, &seconds) == 2) {
        const ufbx_anim_stack* stack = clip >= 0 ? scene->anim_stacks.data[clip] : NULL;
        ufbx_evaluate_opts evaluate = {0};
        evaluate.evaluate_skinning = true;
        ufbx_scene* posed =
            stack ? ufbx_evaluate_scene(scene, stack->anim, stack->time_begin + seconds, &evaluate, &error) : NULL;
        if (stack && !posed) return fprintf(stderr, "Error: %s\n", error.description.data), 3;
        writeScene(posed ? posed : scene, scene, out);
        ufbx_free_scene(posed);
    }
    fclose(out);
    printClips(scene, writeScene(scene, scene, NULL));
    return 0;
}
