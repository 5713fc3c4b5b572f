// The GLSL path computes what runtime computes on the CPU, from the asset's own arrays, once for each vertex
// of each character. player/draw/shader_source.cpp puts a preamble before this text, which defines CHANNEL,
// INFLUENCES, PENUMBRA_STRIDE4 and the places of evaluate_layout.h.
layout(local_size_x = WORK_GROUP) in;  // x: vertices, y: characters

layout(std430, binding = 0) readonly buffer Asset { uint asset[]; };
layout(std430, binding = 1) readonly buffer Pose { vec4 pose[]; };
layout(std430, binding = 1) readonly buffer PoseNumbers { float pose_numbers[]; };
layout(std430, binding = 2) writeonly buffer Evaluated { vec4 evaluated[]; };  // read by evaluated.vert
#if CHANNEL == CHANNEL_SHADED
uniform samplerBuffer materials;
#endif
layout(std430, binding = 3) readonly buffer Given { vec4 given_numbers[]; };  // PENUMBRA_STRIDE4 a vertex
#if CHANNEL == CHANNEL_ERROR
layout(std430, binding = 4) readonly buffer TrueAmbient { float true_ambient[]; };  // one a vertex
#endif
#ifdef COMPOSED
#ifdef FAR_ANCHORS
layout(std430, binding = 6) writeonly buffer Anchors { vec4 anchor_values[]; };  // ANCHOR_VALUES a character
#else
layout(std430, binding = 6) readonly buffer Anchors { vec4 anchor_values[]; };
#endif
#endif
#ifdef DEFORMING
// position and normal, 6 numbers a vertex
layout(std430, binding = 5) readonly buffer GivenVertices { float given_vertices[]; };
#endif

#ifdef RECEIVERS
layout(std430, binding = 7) writeonly buffer Receivers { vec4 receivers[]; };  // read by cast.comp
#endif
#ifdef CAST
layout(std430, binding = 7) readonly buffer Casts { vec4 casts[]; };  // CAST_SETS a vertex, as cast.comp writes them
#endif

uniform vec3 eye;  // in the scene
uniform uint vertex_count;

uint vertex, cluster;  // indices of this invocation
uint table_row;        // row in the cluster table: the model's cluster, or the residual's
uint pose_begin;       // begin of its character's pose
float cast_share = 1.0;  // share of a white sky that casters leave visible; light that bounces is scaled by it

uint clusterWord(uint i) { return asset[CLUSTERS + table_row * CLUSTER_WORDS + i]; }

vec4 quadOf(uint array, uint quad, uint stored_as);
#define PENUMBRA_MATERIAL(texel) texelFetch(materials, texel)
#define PENUMBRA_LIGHT(texel) pose[pose_begin + POSE_LIGHT + uint(texel)]
#define PENUMBRA_MEAN(quad) quadOf(mean_array, uint(quad), MEAN_PRECISION)
#define PENUMBRA_BASIS(quad) quadOf(basis_array, uint(quad), BASIS_PRECISION)
#define PENUMBRA_SCORE(k) pose_numbers[first_score + uint(k)]
uint mean_array, basis_array, first_score;
#ifdef COMPOSED
#define PENUMBRA_FIELD(word) asset[word]
#define PENUMBRA_PART(part, row) pose[pose_begin + POSE_PARTS + uint(7 * (part) + (row))]
#endif

// shader_source.cpp replaces the next line. runtime/glsl/shading_glsl.cpp writes penumbra_ambient(),
// penumbra_clamp_ambient() and penumbra_shade(), with the SH functions of runtime/glsl/sh_glsl.cpp; penumbra.glsl
// follows.
GENERATED_BY_SHADING_GLSL

// Returns numbers 4 quad .. 4 quad + 3 of an array of the model, i8 without its scale.
vec4 quadOf(uint array, uint quad, uint stored_as) {
    if (stored_as == 2u) return penumbra_unpack_i8(asset[array + quad]);
    if (stored_as == 1u) return penumbra_unpack_f16(uvec2(asset[array + 2u * quad], asset[array + 2u * quad + 1u]));
    uint at = array + 4u * quad;
    return uintBitsToFloat(uvec4(asset[at], asset[at + 1u], asset[at + 2u], asset[at + 3u]));
}

vec3 restVector(uint array) {
    uint at = array + 3u * vertex;
    return uintBitsToFloat(uvec3(asset[at], asset[at + 1u], asset[at + 2u]));
}

// The first rows of a character's pose have its place in the scene.
vec3 inScene(vec4 p) {
    return vec3(dot(pose[pose_begin], p), dot(pose[pose_begin + 1u], p), dot(pose[pose_begin + 2u], p));
}
vec3 eyeInModel() {
    vec4 row0 = pose[pose_begin], row1 = pose[pose_begin + 1u], row2 = pose[pose_begin + 2u];
    vec3 way = eye - vec3(row0.w, row1.w, row2.w);
    return way.x * row0.xyz + way.y * row1.xyz + way.z * row2.xyz;
}
bool hasGivenNumbers() { return pose[pose_begin + 3u].x > 0.0; }

uint halfWord(uint array, uint i) { return bitfieldExtract(asset[array + i / 2u], int(16u * (i % 2u)), 16); }

#ifdef DEFORMING
PenumbraSurface surfaceOf(uint character) {
    uint at = 6u * (character * vertex_count + vertex), turn = pose_begin + POSE_ROTATIONS + 3u * cluster;
    vec3 position = vec3(given_vertices[at], given_vertices[at + 1u], given_vertices[at + 2u]);
    vec3 normal = vec3(given_vertices[at + 3u], given_vertices[at + 4u], given_vertices[at + 5u]);
    return penumbra_surface(vec4(1, 0, 0, 0), vec4(0, 1, 0, 0), vec4(0, 0, 1, 0), position, normal, restVector(TANGENTS),
                            pose[turn].xyz, pose[turn + 1u].xyz, pose[turn + 2u].xyz);
}
#else
PenumbraSurface surfaceOf(uint character) {
    vec4 row0 = vec4(0.0), row1 = vec4(0.0), row2 = vec4(0.0);
    for (uint i = vertex * INFLUENCES; i < (vertex + 1u) * INFLUENCES; ++i) {
        uint bone = pose_begin + POSE_BONES + 3u * halfWord(SKIN_JOINTS, i);
        float weight = uintBitsToFloat(asset[SKIN_WEIGHTS + i]);
        row0 += weight * pose[bone];
        row1 += weight * pose[bone + 1u];
        row2 += weight * pose[bone + 2u];
    }
    uint turn = pose_begin + POSE_ROTATIONS + 3u * cluster;
    return penumbra_surface(row0, row1, row2, restVector(POSITIONS), restVector(NORMALS), restVector(TANGENTS),
                            pose[turn].xyz, pose[turn + 1u].xyz, pose[turn + 2u].xyz);
}
#endif

#if CHANNEL != CHANNEL_NORMALS && CHANNEL != CHANNEL_CLUSTERS && CHANNEL != CHANNEL_PARTS
void modelCoefficients(uint row, out vec4 coefficients[PENUMBRA_STRIDE4]) {
    table_row = row;
    first_score = 4u * (pose_begin + POSE_SCORES) + clusterWord(3u);
    mean_array = clusterWord(4u);
    basis_array = clusterWord(5u);
    penumbra_coefficients(int(vertex - clusterWord(0u)), int(clusterWord(1u)), int(clusterWord(2u)), coefficients);
}

// Computes the numbers of a vertex that is of a cluster.
void clusterCoefficients(PenumbraSurface s, uint character, out vec4 coefficients[PENUMBRA_STRIDE4]) {
    modelCoefficients(cluster, coefficients);
#if defined(COMPOSED) && !defined(FAR_ANCHORS)
    farCompose(s, halfWord(PART_OF_VERTEX, vertex), character * ANCHOR_VALUES, coefficients);
#ifdef HAS_RESIDUAL
    vec4 residual[PENUMBRA_STRIDE4];
    modelCoefficients(cluster + CLUSTER_COUNT, residual);
    for (uint q = 0u; q < PENUMBRA_STRIDE4; ++q) coefficients[q] += residual[q];
#endif
#endif
    penumbra_clamp_ambient(coefficients);
}

#ifdef FIRST_FOLLOWER
// Computes the numbers of a vertex that follows three points.
void followedNumbers(PenumbraSurface s, uint character, out vec4 coefficients[PENUMBRA_STRIDE4]) {
    uint own_vertex = vertex, own_cluster = cluster, row = 3u * (vertex - FIRST_FOLLOWER);
    for (uint q = 0u; q < PENUMBRA_STRIDE4; ++q) coefficients[q] = vec4(0.0);
    for (uint i = row; i < row + 3u; ++i) {
        float weight = uintBitsToFloat(asset[POINT_WEIGHTS + i]);
        if (weight == 0.0) continue;
        vertex = asset[POINT_CORNERS + i];
        cluster = asset[CLUSTER_OF_VERTEX + vertex];
        PenumbraSurface point = surfaceOf(character);
        vec4 of_point[PENUMBRA_STRIDE4];
        clusterCoefficients(point, character, of_point);
        penumbra_add_point(of_point, penumbra_turn(point, s), weight, coefficients);
    }
    vertex = own_vertex;
    cluster = own_cluster;
}
#endif

void ownCoefficients(PenumbraSurface s, uint character, out vec4 coefficients[PENUMBRA_STRIDE4]) {
    if (hasGivenNumbers()) {
        uint first = (character * vertex_count + vertex) * PENUMBRA_STRIDE4;
        for (uint q = 0u; q < PENUMBRA_STRIDE4; ++q) coefficients[q] = given_numbers[first + q];
        return;
    }
#ifdef FIRST_FOLLOWER
    if (vertex >= FIRST_FOLLOWER) {
        followedNumbers(s, character, coefficients);
        return;
    }
#endif
    clusterCoefficients(s, character, coefficients);
}

#ifdef BOUNCES
// Computes the light that bounces to the vertex: 12 numbers, in three vec4.
void indirectNumbers(out vec4 n[3]) {
    table_row = FIRST_INDIRECT + cluster;
    uint at = 3u * (vertex - clusterWord(0u)), row = 3u * clusterWord(1u), score = 4u * (pose_begin + POSE_SCORES);
    for (uint q = 0u; q < 3u; ++q) n[q] = quadOf(clusterWord(4u), at + q, clusterWord(6u));
    for (uint k = 0u; k < clusterWord(2u); ++k)
        for (uint q = 0u; q < 3u; ++q)
            n[q] += pose_numbers[score + clusterWord(3u) + k] * quadOf(clusterWord(5u), k * row + at + q, clusterWord(7u));
    for (uint q = 0u; q < 3u; ++q) n[q] *= cast_share;
}
#endif

void coefficientsOf(PenumbraSurface s, uint character, out vec4 coefficients[PENUMBRA_STRIDE4]) {
    ownCoefficients(s, character, coefficients);
#ifdef CAST
    cast_share = 1.0;
    for (uint of = 0u; of < CAST_SETS; ++of) {  // casts of characters first, then of a height field
        uint first = CAST_QUADS * (CAST_SETS * (character * vertex_count + vertex) + of);
        if (casts[first + 5u].y == 0.0) continue;
        float mirrored[21];
        for (uint i = 0u; i < 21u; ++i) mirrored[i] = casts[first + i / 4u][i % 4u];
        penumbra_cast_coefficients(coefficients, mirrored);
        cast_share *= penumbra_cast_ambient(mirrored);
    }
#endif
}
#endif

uint slotOfVertex() {
#ifdef HAS_SLOTS
    return halfWord(SLOTS, vertex);
#else
    return 0u;
#endif
}

#ifdef SUNLIT
float surface_sight = 0.0;  // V at the mirrored direction, of mirrors
#endif

#if CHANNEL == CHANNEL_SHADED
// Shades a side of the surface, the one that `vertex` is on.
vec3 shadeSide(vec4 coefficients[PENUMBRA_STRIDE4], vec3 to_eye, mat3 local_from_model, int material) {
#ifdef BOUNCES
    vec4 n[3];
    indirectNumbers(n);
    return penumbra_shade_bounced(coefficients, n, to_eye, local_from_model, material);
#else
    return penumbra_shade(coefficients, to_eye, local_from_model, material);
#endif
}

#ifdef HAS_MEMBRANES
// Shades the other side, seen from straight above it.
vec3 shadeOtherSide(uint character, int material) {
    uint own_vertex = vertex, own_cluster = cluster;
    vertex = asset[OTHER_SIDE + vertex];
    cluster = asset[CLUSTER_OF_VERTEX + vertex];
    PenumbraSurface s = surfaceOf(character);
    vec4 coefficients[PENUMBRA_STRIDE4];
    coefficientsOf(s, character, coefficients);
    penumbra_other_side(material, coefficients);
    vec3 radiance = shadeSide(coefficients, vec3(0.0, 0.0, 1.0), penumbra_local_from_model(s), material);
    vertex = own_vertex;
    cluster = own_cluster;
    return radiance;
}
#endif
#endif

#ifdef TEXTURED
// Shades the terms of a vertex that shows pictures (shaders/surface.glsl), which follow the first; its slot's rows of
// the pose have 1 where it shows them, then the material of each pass: slopes along two axes, and A and B at each
// roughness. Returns whether it does. The passes take turns in one loop, whose body is long to compile.
uint evaluated_row;  // row of the vertex
float shows_pictures = 0.0;

vec3 shadeTerms(PenumbraSurface s, vec4 coefficients[PENUMBRA_STRIDE4], vec3 to_eye, mat3 local_from_model, int material) {
    uint row = 4u * (pose_begin + POSE_TERMS) + (1u + PASSES) * slotOfVertex();
    shows_pictures = pose_numbers[row];
    uint passes = shows_pictures > 0.0 ? PASSES : 0u;
    vec3 value = vec3(0.0), slope_x = vec3(0.0);
    for (uint pass = 0u; pass <= passes; ++pass) {
        int of_pass = pass == 0u ? material : int(pose_numbers[row + pass]);
        vec3 radiance = of_pass < 0 ? vec3(0.0) : shadeSide(coefficients, to_eye, local_from_model, of_pass);
        if (pass == 0u) {
            value = radiance;
            continue;
        }
#if SLOPES > 0
        if (pass == 1u) {
            slope_x = radiance;
            continue;
        }
        if (pass == 2u) {
            vec3 tangent = inScene(vec4(s.tangent, 0.0)), bitangent = inScene(vec4(cross(s.normal, s.tangent), 0.0));
            for (uint c = 0u; c < 3u; ++c)
                evaluated[evaluated_row + TERM_QUAD + c] = vec4(slope_x[c] * tangent + radiance[c] * bitangent, 0.0);
            continue;
        }
        evaluated[evaluated_row + TERM_QUAD + pass] = vec4(max(radiance, 0.0), 0.0);  // three terms of two passes
#else
        evaluated[evaluated_row + TERM_QUAD + pass - 1u] = vec4(max(radiance, 0.0), 0.0);
#endif
    }
    return value;
}
#endif

vec3 valueOf(PenumbraSurface s, uint character) {
#if CHANNEL == CHANNEL_NORMALS
    return s.normal;
#elif CHANNEL == CHANNEL_CLUSTERS
    return vec3(float(cluster));
#elif CHANNEL == CHANNEL_PARTS
    return vec3(float(halfWord(PART_OF_VERTEX, vertex)));
#else
    vec4 coefficients[PENUMBRA_STRIDE4];
    coefficientsOf(s, character, coefficients);
#if CHANNEL == CHANNEL_AO
    return vec3(penumbra_ambient(coefficients));
#elif CHANNEL == CHANNEL_BOUNCED_AO
    vec4 n[3];
    indirectNumbers(n);
    return vec3(clamp(penumbra_ambient(coefficients) + dot(BOUNCED_AMBIENT, vec3(n[0].x, n[2].yz)), 0.0, 1.0));
#elif CHANNEL == CHANNEL_ERROR
    return vec3(abs(penumbra_ambient(coefficients) - true_ambient[character * vertex_count + vertex]));
#else
    mat3 local_from_model = penumbra_local_from_model(s);
    int material = int(pose_numbers[4u * (pose_begin + POSE_MATERIALS) + slotOfVertex()]);
    vec3 to_eye = penumbra_to_eye(s, eyeInModel(), local_from_model);
#ifdef SUNLIT
    // Fragments reflect the light's picture in mirrors, which SH blur.
    if (pose[pose_begin + POSE_LOBES + slotOfVertex()].z > 0.0) {
        surface_sight = clamp(penumbra_sight(coefficients, vec3(-to_eye.xy, to_eye.z)), 0.0, 1.0);
        return vec3(0.0);
    }
#endif
#ifdef TEXTURED
    vec3 radiance = shadeTerms(s, coefficients, to_eye, local_from_model, material);
#else
    vec3 radiance = shadeSide(coefficients, to_eye, local_from_model, material);
#endif
#ifdef HAS_MEMBRANES
    if (penumbra_is_membrane(material))
        radiance = penumbra_join_sides(material, radiance, shadeOtherSide(character, material));
#endif
    return max(radiance, 0.0);
#endif
#endif
}

#ifdef FAR_ANCHORS
void main() {
    uint anchor = gl_GlobalInvocationID.x;
    if (anchor >= ANCHOR_COUNT) return;
    uint character = gl_GlobalInvocationID.y;
    pose_begin = character * POSE_SIZE;
    if (hasGivenNumbers()) return;
    vertex = asset[FAR_ANCHOR_TABLE + 2u * anchor];
    cluster = asset[CLUSTER_OF_VERTEX + vertex];
    farAnchor(surfaceOf(character), halfWord(PART_OF_VERTEX, vertex),
              character * ANCHOR_VALUES + asset[FAR_ANCHOR_TABLE + 2u * anchor + 1u]);
}
#else
void main() {
    vertex = gl_GlobalInvocationID.x;
    if (vertex >= vertex_count) return;
    uint character = gl_GlobalInvocationID.y;
    pose_begin = character * POSE_SIZE;
    cluster = asset[CLUSTER_OF_VERTEX + vertex];
    PenumbraSurface s = surfaceOf(character);
    uint at = character * vertex_count + vertex;
    vec3 position = inScene(vec4(s.position, 1.0));
#ifdef RECEIVERS
    receivers[3u * at] = vec4(position, pose[pose_begin + 3u].y);
    receivers[3u * at + 1u] = vec4(inScene(vec4(s.normal, 0.0)), 0.0);
    receivers[3u * at + 2u] = vec4(inScene(vec4(s.tangent, 0.0)), 0.0);
#else
    float pictures = 1.0;
#ifdef TEXTURED
    evaluated_row = EVALUATED_QUADS * at;
#endif
    vec4 value = vec4(valueOf(s, character), 0.0);
#ifdef TEXTURED
    pictures = shows_pictures;
#if SLOPES > 0 && !defined(SUNLIT)
    evaluated[evaluated_row + 2u] = vec4(inScene(vec4(s.normal, 0.0)), 0.0);
#endif
#endif
#ifdef SUNLIT
    value.w = surface_sight;
    vec4 lobes = pose[pose_begin + POSE_LOBES + slotOfVertex()];
    evaluated[EVALUATED_QUADS * at + 2u] = vec4(inScene(vec4(s.normal, 0.0)), lobes.x);
    evaluated[EVALUATED_QUADS * at + 3u] = vec4(inScene(vec4(s.tangent, 0.0)), lobes.y);
#endif
    evaluated[EVALUATED_QUADS * at] = vec4(position, pictures);
    evaluated[EVALUATED_QUADS * at + 1u] = value;
#endif
}
#endif
