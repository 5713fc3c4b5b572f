// The share of a sun that a point sees, from depth maps of the casters. It has the rules of SunMap
// (player/runtime/sun_map.h), whose source tells the method. player/draw/sun_map_painter.cpp defines MAX_SUNS, BIAS,
// SLOPE_BIAS, LEAST_COSINE, BOX, CELLS, SEARCH_CELLS, PASSES, BLOCK and LEVELS as SUN_... from its constants.
uniform sampler2DArray sun_depths;        // a layer a sun: depth / range; 1: nothing
uniform samplerBuffer sun_blocks;           // what sun_blocks.comp makes
uniform int sun_block_side, sun_block_count;  // blocks of texels a side; numbers of a sun in sun_blocks
uniform vec4 sun_frames[4 * SUN_MAX_SUNS];  // SunFrame: 3 rows, then (range, tangent of the radius, texel, size)

// Where cell `across` of a line tests its texel, from its start: the multiples of the golden section.
int sunCellTexel(int across, int stride) { return (((across * 40503) & 65535) * stride) >> 16; }

// A point of a surface as the map has it.
struct SunReceiver {
    vec3 place;    // less the bias in depth
    vec2 slope;    // of the depth of its plane
    float widest;  // side of the box that fits the nearest caster to the sun
};

// Software GL runs both sides of a branch, and the body of a loop once more for pixels that leave it at its head. So
// loops here end at their foot.

// The share of a box that blockers cover, and their mean distance. Lengths are in texels.
vec2 sunBlockers(int sun, SunReceiver receiver, float side, int cells) {
    int size = int(sun_frames[4 * sun + 3].w);
    float range = sun_frames[4 * sun + 3].x;
    int stride = max(1, int(ceil(side / float(cells))));
    vec3 place = receiver.place;
    vec2 low = place.xy - side / 2.0, high = place.xy + side / 2.0;
    ivec2 first = ivec2(floor(low / float(stride))), last = ivec2(floor(high / float(stride)));
    float total = 0.0, blocked = 0.0, sum = 0.0;
    int j = first.y;
    do {
        int i = first.x, texel_x = sunCellTexel(j, stride);
        float height = min(high.y, float((j + 1) * stride)) - max(low.y, float(j * stride));
        do {
            ivec2 texel = ivec2(i * stride + texel_x, j * stride + sunCellTexel(i, stride));
            bool inside = all(greaterThanEqual(texel, ivec2(0))) && all(lessThan(texel, ivec2(size)));
            float stored = texelFetch(sun_depths, ivec3(clamp(texel, ivec2(0), ivec2(size - 1)), sun), 0).x;
            float above = place.z + dot(receiver.slope, vec2(texel) + 0.5 - place.xy) - stored * range;
            float weight = height * (min(high.x, float((i + 1) * stride)) - max(low.x, float(i * stride)));
            total += weight;
            if (inside && stored < 1.0 && above > 0.0) {
                blocked += weight;
                sum += weight * above;
            }
        } while (++i <= last.x);
    } while (++j <= last.y);
    return blocked > 0.0 ? vec2(blocked / total, sum / blocked) : vec2(0.0);
}

// Gives the receiver of a sun that has a map. False where the surface faces away from the sun. `normal` is a unit
// vector.
bool sunReceiver(int sun, vec3 position, vec3 normal, out SunReceiver receiver) {
    vec4 numbers = sun_frames[4 * sun + 3];
    vec3 n, place;
    for (int i = 0; i < 3; ++i) {
        vec4 row = sun_frames[4 * sun + i];
        n[i] = dot(row.xyz, normal);
        place[i] = dot(row.xyz, position) / numbers.z + row.w;
    }
    float cosine = -n.z, limited = max(cosine, SUN_LEAST_COSINE);
    receiver.widest = max(2.0 * place.z * numbers.y, 1.0);
    place.z -= SUN_BIAS + SUN_SLOPE_BIAS * sqrt(max(1.0 - limited * limited, 0.0)) / limited;
    receiver.place = place;
    receiver.slope = n.xy / limited;
    return cosine > 0.0;
}

// Whether the extremes of blocks show that nothing hides the receiver (1) or that everything does (0); -1 where texels
// must tell. It changes no result.
float sunFromBlocks(int sun, SunReceiver receiver) {
    vec4 numbers = sun_frames[4 * sun + 3];
    // The cells of a wide box reach beyond it.
    float reach = receiver.widest / 2.0 + ceil(receiver.widest / float(SUN_SEARCH_CELLS));
    vec2 place = receiver.place.xy;
    bool outside = any(lessThan(place, vec2(-reach))) || any(greaterThan(place, vec2(numbers.w + reach)));
    if (outside) return 1.0;
    // A block of level k, with SUN_BLOCK 2^k texels a side, tells of all boxes around it that reach half its side.
    int level = max(1, findMSB(int(ceil(min(reach, 1e6))) - 1) + 2 - findMSB(SUN_BLOCK));
    bool known = level <= SUN_LEVELS;
    level = min(level, SUN_LEVELS);
    int widest_side = sun_block_side, side = widest_side >> level, before = widest_side >> (level - 1);
    int first = sun * sun_block_count + (widest_side * widest_side - before * before) / 3;
    ivec2 block = ivec2(clamp(place, vec2(0.0), vec2(numbers.w - 1.0))) >> (level + findMSB(SUN_BLOCK));
    vec2 both = texelFetch(sun_blocks, first + block.y * side + block.x).xy;
    float change = reach * (abs(receiver.slope.x) + abs(receiver.slope.y));
    if (!known) return -1.0;
    if (both.x >= 1.0 || receiver.place.z + change <= both.x * numbers.x) return 1.0;
    return both.y < 1.0 && receiver.place.z - change > both.y * numbers.x ? 0.0 : -1.0;
}

// Share of the sun that reaches the receiver, from texels.
float sunFromTexels(int sun, SunReceiver receiver) {
    float tan_radius = sun_frames[4 * sun + 3].y, side = receiver.widest;
    vec2 blockers;
    int pass = 1;
    do {
        blockers = sunBlockers(sun, receiver, side, pass < SUN_PASSES ? SUN_SEARCH_CELLS : SUN_CELLS);
        float next = clamp(SUN_BOX * blockers.y * tan_radius, 1.0, receiver.widest);
        if (blockers.x == 0.0 || blockers.x == 1.0 || max(side, next) == 1.0) break;
        side = next;
    } while (++pass <= SUN_PASSES);
    return 1.0 - blockers.x;
}

// Share of the sun that reaches the point, 0 to 1, where blocks tell it; -1 elsewhere. 0 where the surface faces away.
float sunAtOnce(int sun, vec3 position, vec3 normal) {
    if (sun_frames[4 * sun + 3].w == 0.0) return 1.0;
    SunReceiver receiver;
    return sunReceiver(sun, position, normal, receiver) ? sunFromBlocks(sun, receiver) : 0.0;
}

// The same everywhere, without a look at blocks.
float sunSearched(int sun, vec3 position, vec3 normal) {
    if (sun_frames[4 * sun + 3].w == 0.0) return 1.0;
    SunReceiver receiver;
    return sunReceiver(sun, position, normal, receiver) ? sunFromTexels(sun, receiver) : 0.0;
}

// The same everywhere.
float sunVisibility(int sun, vec3 position, vec3 normal) {
    float at_once = sunAtOnce(sun, position, normal);
    return at_once >= 0.0 ? at_once : sunSearched(sun, position, normal);
}

// The unit normal of the triangle that the fragment lies on, on the side of the unit `normal` that is interpolated. The
// two differ by some degrees on a coarse mesh. A depth map knows triangles alone, so by its vertices' normals a mesh
// would shadow itself in specks. Only for fragment shaders; `position` is interpolated.
vec3 sunFacing(vec3 position, vec3 normal) {
    vec3 face = cross(dFdx(position), dFdy(position));
    float size = length(face);
    return size > 0.0 ? face * (sign(dot(face, normal)) / size) : normal;
}
