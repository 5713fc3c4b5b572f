// The least and the largest depth of blocks of a sun's map: of SUN_BLOCK texels a side, then level after level of twice
// the side. Of each level but the first it also writes those of the blocks together with half a block all around them.
// With them sun.glsl sees that nothing, or everything, hides a point. player/draw/sun_map_painter.cpp defines SUN_BLOCK
// and, for blocks of texels, SUN_FROM_TEXELS.
layout(local_size_x = 8, local_size_y = 8) in;

layout(std430, binding = 0) buffer Blocks { vec2 blocks[]; };
uniform sampler2DArray sun_depths;
uniform int layer;
uniform int read_first, read_side;     // the square that is read: its first place in `blocks`, its side
uniform int own_first, reached_first;  // first places of the squares that are written
uniform int write_side;

const vec2 NOTHING = vec2(1.0, 1.0);  // outside of the map

void include(inout vec2 both, vec2 one) { both = vec2(min(both.x, one.x), max(both.y, one.y)); }

void main() {
    ivec2 block = ivec2(gl_GlobalInvocationID.xy);
    if (max(block.x, block.y) >= write_side) return;
    vec2 own = vec2(1.0, 0.0);
    int at = block.y * write_side + block.x;
#ifdef SUN_FROM_TEXELS
    ivec2 first = SUN_BLOCK * block, last = min(first + SUN_BLOCK, ivec2(read_side));
    if (last != first + SUN_BLOCK) include(own, NOTHING);
    // Four texels at a time; beyond the last ones they come again.
    for (int y = first.y; y < last.y; y += 2)
        for (int x = first.x; x < last.x; x += 2) {
            vec4 four = textureGather(sun_depths, vec3(vec2(x + 1, y + 1) / float(read_side), layer));
            vec2 low = min(four.xy, four.zw), high = max(four.xy, four.zw);
            include(own, vec2(min(low.x, low.y), max(high.x, high.y)));
        }
#else
    vec2 reached = vec2(1.0, 0.0);
    for (int y = -1; y < 3; ++y)
        for (int x = -1; x < 3; ++x) {
            ivec2 child = 2 * block + ivec2(x, y);
            bool inside = min(child.x, child.y) >= 0 && max(child.x, child.y) < read_side;
            vec2 one = inside ? blocks[read_first + child.y * read_side + child.x] : NOTHING;
            include(reached, one);
            if (x == clamp(x, 0, 1) && y == clamp(y, 0, 1)) include(own, one);
        }
    blocks[reached_first + at] = reached;
#endif
    blocks[own_first + at] = own;
}
