// Computes the radiance of the ground as weighted sums of the visibility from cast.comp. player/draw/shader_source.cpp
// puts a preamble before this text, with WORK_GROUP and CAST_QUADS.
layout(local_size_x = WORK_GROUP) in;

layout(std430, binding = 3) readonly buffer Receivers { vec4 receivers[]; };  // layout of cast.comp
layout(std430, binding = 4) readonly buffer Casts { vec4 casts[]; };
layout(std430, binding = 5) writeonly buffer Evaluated { vec4 evaluated[]; };  // read by evaluated.vert

uniform uint receiver_count;
uniform vec4 weights[21];  // radiance by each number, and 0
#ifdef SUNLIT
uniform vec3 lobes;  // for all vertices: the first lobe, and the number of lobes; 0
#endif

void main() {
    uint r = gl_GlobalInvocationID.x;
    if (r >= receiver_count) return;
    vec4 value = vec4(0.0);
    for (uint i = 0u; i < 21u; ++i) value += weights[i] * casts[CAST_QUADS * r + i / 4u][i % 4u];
    evaluated[EVALUATED_QUADS * r] = vec4(receivers[3u * r].xyz, 1.0);
    evaluated[EVALUATED_QUADS * r + 1u] = max(value, 0.0);
#ifdef SUNLIT
    evaluated[EVALUATED_QUADS * r + 2u] = vec4(receivers[3u * r + 1u].xyz, lobes.x);
    evaluated[EVALUATED_QUADS * r + 3u] = vec4(receivers[3u * r + 2u].xyz, lobes.y);
#endif
}
