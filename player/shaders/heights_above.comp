// Writes what a height field leaves visible to vertices of characters, after what others do (cast.comp). heights.glsl
// and a preamble with WORK_GROUP and CAST_QUADS stand before this text.
layout(local_size_x = WORK_GROUP) in;

layout(std430, binding = 2) readonly buffer Receivers { vec4 receivers[]; };  // layout of cast.comp
layout(std430, binding = 3) writeonly buffer Casts { vec4 casts[]; };

uniform uint receiver_count;

void main() {
    uint r = gl_GlobalInvocationID.x + gl_GlobalInvocationID.y * gl_NumWorkGroups.x * WORK_GROUP;
    if (r >= receiver_count) return;
    vec3 place = receivers[3u * r].xyz - corner;
    vec3 at = vec3(place.z / cell.x, place.x / cell.y, place.y);
    at.z = max(at.z, heightAt(at.xy));
    float v[ORDER * ORDER], mirrored[21];
    heightVisibility(at, v);
    heightsMirror(v, fieldFromScene(receivers[3u * r + 1u].xyz), fieldFromScene(receivers[3u * r + 2u].xyz), mirrored);
    uint first = 2u * CAST_QUADS * r + CAST_QUADS;
    for (uint q = 0u; q < 5u; ++q)
        casts[first + q] = vec4(mirrored[4u * q], mirrored[4u * q + 1u], mirrored[4u * q + 2u], mirrored[4u * q + 3u]);
    casts[first + 5u] = vec4(mirrored[20], 1.0, 0.0, 0.0);
}
