// The least and the largest depth of each block of a sun's map, kSunBlock texels a side, and of each block of such
// blocks. With them sun.glsl sees that nothing, or everything, hides a point. player/draw/sun_map_painter.cpp defines
// SUN_BLOCK and, for blocks of texels, SUN_FROM_TEXELS.
layout(local_size_x = 8, local_size_y = 8) in;

layout(std430, binding = 0) buffer Blocks { vec2 blocks[]; };
uniform sampler2DArray sun_depths;
uniform int sun;
uniform int read_first, read_side;    // of the square that is read: its first place in `blocks`, its side
uniform int write_first, write_side;  // of the square that is written

vec2 extremes(ivec2 at) {
#ifdef SUN_FROM_TEXELS
    return texelFetch(sun_depths, ivec3(at, sun), 0).xx;
#else
    return blocks[read_first + at.y * read_side + at.x];
#endif
}

void main() {
    ivec2 block = ivec2(gl_GlobalInvocationID.xy);
    if (max(block.x, block.y) >= write_side) return;
    ivec2 last = min(SUN_BLOCK * block + SUN_BLOCK, ivec2(read_side));
    vec2 both = vec2(1.0, 0.0);
    for (int y = SUN_BLOCK * block.y; y < last.y; ++y)
        for (int x = SUN_BLOCK * block.x; x < last.x; ++x) {
            vec2 one = extremes(ivec2(x, y));
            both = vec2(min(both.x, one.x), max(both.y, one.y));
        }
    blocks[write_first + block.y * write_side + block.x] = both;
}
