// Looks for the horizons of those receivers of a height field that are awake. heights.glsl and a preamble with
// WORK_GROUP, LINES, SPACING and ROW_QUADS stand before this text.
layout(local_size_x = WORK_GROUP) in;

const ivec2 lines = LINES;  // rows and columns of receivers, SPACING points apart

// ROW_QUADS a receiver: V in the frame of the field, then the normal.
layout(std430, binding = 2) writeonly buffer Rows { vec4 rows[]; };
layout(std430, binding = 3) readonly buffer Awake { uint awake[]; };

uniform uint awake_count;

void main() {
    uint r = gl_GlobalInvocationID.x + gl_GlobalInvocationID.y * gl_NumWorkGroups.x * WORK_GROUP;
    if (r >= awake_count) return;
    uint receiver = awake[r];
    ivec2 at = min(SPACING * ivec2(receiver / uint(lines.y), receiver % uint(lines.y)), side - 1);
    float v[ORDER * ORDER];
    heightVisibility(vec3(at, heights[at.x * side.y + at.y]), v);
    vec3 normal = heightNormal(at);
    float row[4 * ROW_QUADS];
    for (int i = 0; i < 4 * ROW_QUADS; ++i)
        row[i] = i < ORDER * ORDER ? v[min(i, ORDER * ORDER - 1)] : i < ORDER * ORDER + 3 ? normal[min(i - ORDER * ORDER, 2)] : 0.0;
    for (uint q = 0u; q < ROW_QUADS; ++q)
        rows[ROW_QUADS * receiver + q] = vec4(row[4u * q], row[4u * q + 1u], row[4u * q + 2u], row[4u * q + 3u]);
}
