// The GLSL path: what player/runtime computes on the CPU, from the asset's own arrays. The preamble, made by
// shader_source.cpp, defines CHANNEL, INFLUENCES, PENUMBRA_STRIDE4 and the MEAN_/BASIS_ switches and has penumbra.glsl;
// penumbra_ambient(), penumbra_clamp_ambient() and penumbra_shade() are generated at the line GENERATED.
layout(location = 0) in vec3 rest_position;
layout(location = 1) in vec3 rest_normal;
layout(location = 2) in vec3 rest_tangent;
layout(location = 3) in uint cluster;
layout(location = 4) in float true_ambient;  // channel error only

uniform mat4 clip_from_model;
uniform vec3 eye;  // model frame

uniform samplerBuffer bones;              // 3 texels a joint: the rows of its 3x4 skinning matrix
uniform usamplerBuffer skin_joints;       // INFLUENCES a vertex
uniform samplerBuffer skin_weights;       // INFLUENCES a vertex
uniform samplerBuffer cluster_rotations;  // 3 texels a cluster: rows, the fourth number unused

INTERPOLATION out vec3 value;

PenumbraSurface skin() {
    vec4 row0 = vec4(0.0), row1 = vec4(0.0), row2 = vec4(0.0);
    for (int k = 0; k < INFLUENCES; ++k) {
        int joint = 3 * int(texelFetch(skin_joints, gl_VertexID * INFLUENCES + k).x);
        float weight = texelFetch(skin_weights, gl_VertexID * INFLUENCES + k).x;
        row0 += weight * texelFetch(bones, joint);
        row1 += weight * texelFetch(bones, joint + 1);
        row2 += weight * texelFetch(bones, joint + 2);
    }
    int c = 3 * int(cluster);
    return penumbra_surface(row0, row1, row2, rest_position, rest_normal, rest_tangent,
                            texelFetch(cluster_rotations, c).xyz, texelFetch(cluster_rotations, c + 1).xyz,
                            texelFetch(cluster_rotations, c + 2).xyz);
}

#ifdef NUMBERS_GIVEN
uniform samplerBuffer given_numbers;  // PENUMBRA_STRIDE4 texels a vertex

void numbersOf(out vec4 numbers[PENUMBRA_STRIDE4]) {
    for (int q = 0; q < PENUMBRA_STRIDE4; ++q) numbers[q] = texelFetch(given_numbers, gl_VertexID * PENUMBRA_STRIDE4 + q);
}
#else
uniform usamplerBuffer clusters;  // 3 texels: first vertex, vertices, components, first score; first texel of the mean
                                  // and of the basis, first scale of each; numbers that share a scale in each
uniform samplerBuffer scores;

#ifdef MEAN_I8
uniform isamplerBuffer mean_numbers;
uniform samplerBuffer mean_scales;
vec4 meanTexel(int texel, int scale) { return texelFetch(mean_scales, scale).x * vec4(texelFetch(mean_numbers, texel)); }
#else
uniform samplerBuffer mean_numbers;
vec4 meanTexel(int texel, int scale) { return texelFetch(mean_numbers, texel); }
#endif

#ifdef BASIS_I8
uniform isamplerBuffer basis_numbers;
uniform samplerBuffer basis_scales;
vec4 basisTexel(int texel, int scale) {
    return texelFetch(basis_scales, scale).x * vec4(texelFetch(basis_numbers, texel));
}
#else
uniform samplerBuffer basis_numbers;
vec4 basisTexel(int texel, int scale) { return texelFetch(basis_numbers, texel); }
#endif

// v = mean + sum over k of y_k basis_k. Texel t of an array holds its numbers 4t .. 4t+3.
void numbersOf(out vec4 numbers[PENUMBRA_STRIDE4]) {
    ivec4 range = ivec4(texelFetch(clusters, 3 * int(cluster)));
    ivec4 start = ivec4(texelFetch(clusters, 3 * int(cluster) + 1));
    ivec2 shared_scale = ivec2(texelFetch(clusters, 3 * int(cluster) + 2).xy);
    int texel = (gl_VertexID - range.x) * PENUMBRA_STRIDE4;
    for (int q = 0; q < PENUMBRA_STRIDE4; ++q)
        numbers[q] = meanTexel(start.x + texel + q, start.z + 4 * (texel + q) / shared_scale.x);
    for (int k = 0; k < range.z; ++k) {
        float score = texelFetch(scores, range.w + k).x;
        for (int q = 0; q < PENUMBRA_STRIDE4; ++q)
            numbers[q] += score * basisTexel(start.y + texel + q, start.w + 4 * (texel + q) / shared_scale.y);
        texel += range.y * PENUMBRA_STRIDE4;
    }
}
#endif

GENERATED

void main() {
    PenumbraSurface s = skin();
    gl_Position = clip_from_model * vec4(s.position, 1.0);
#if CHANNEL == CHANNEL_NORMALS
    value = s.normal;
#elif CHANNEL == CHANNEL_CLUSTERS
    value = vec3(float(cluster));
#else
    vec4 numbers[PENUMBRA_STRIDE4];
    numbersOf(numbers);
#ifndef NUMBERS_GIVEN
    penumbra_clamp_ambient(numbers);
#endif
#if CHANNEL == CHANNEL_AO
    value = vec3(penumbra_ambient(numbers));
#elif CHANNEL == CHANNEL_ERROR
    value = vec3(abs(penumbra_ambient(numbers) - true_ambient));
#else
    mat3 local_from_model = penumbra_local_from_model(s);
    int material = int(texelFetch(material_of_slot, slot_base + int(slot)).x);
    value = max(penumbra_shade(numbers, penumbra_to_eye(s, eye, local_from_model), local_from_model, material), 0.0);
#endif
#endif
}
