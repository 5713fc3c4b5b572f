// The share of a sun that a point sees, from depth maps of the casters. It has the rules of SunMaps
// (runtime/sun/sun_map.h), whose source tells the method; sun_nest.cpp tells why a sun has several maps. It looks at
// first as wide as the nearest caster around a point wants, while SunMaps takes the nearest one of the whole map.
// player/draw/sun_map_painter.cpp defines MAX_SUNS, MAX_MAPS, BIAS, SLOPE_BIAS, MIN_COSINE, BOX, CELLS,
// FRAMES_BINDING, SEARCH_CELLS, PASSES, BLOCK and LEVELS as SUN_... from its constants.
uniform sampler2DArray sun_depths;            // a layer a map: depth / range; 1: nothing
uniform samplerBuffer sun_blocks;             // written by sun_blocks.comp
uniform int sun_block_side, sun_block_count;  // blocks of texels a side; numbers of a map in sun_blocks
uniform ivec2 sun_maps[SUN_MAX_SUNS];         // the first map of a sun, and the one after its last
// NestedSunMap: 3 rows, (range, tangent of the radius, texel, size), (origin, border)
layout(std140, binding = SUN_FRAMES_BINDING) uniform SunFrames { vec4 sun_frames[5 * SUN_MAX_MAPS]; };

// Where cell `across` of a line tests its texel, from its start: the multiples of the golden section.
int sunCellTexel(int across, int stride) { return (((across * 40503) & 65535) * stride) >> 16; }

// A point of a surface as the map has it.
struct SunReceiver {
    vec3 place;    // less the bias in depth
    vec2 slope;    // slope of the depth of its plane
    float widest;  // side of the box that fits the nearest caster to the sun that is known
};

// Software GL runs both sides of a branch, and the body of a loop once more for pixels that leave it at its head. So
// loops here end at their foot.

// The share of a box that blockers cover, and their mean distance. Lengths are in texels.
vec2 sunBlockers(int map, SunReceiver receiver, float side, bool searches) {
    int size = int(sun_frames[5 * map + 3].w);
    float range = sun_frames[5 * map + 3].x;
    int stride = max(1, int(ceil(side / float(searches ? SUN_SEARCH_CELLS : SUN_CELLS))));
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
            float stored = texelFetch(sun_depths, ivec3(clamp(texel, ivec2(0), ivec2(size - 1)), map), 0).x;
            vec2 away = vec2(texel) + 0.5 - place.xy;
            float ahead = place.z - stored * range, above = ahead + dot(receiver.slope, away);
            float weight = height * (min(high.x, float((i + 1) * stride)) - max(low.x, float(i * stride)));
            total += weight;
            if (inside && stored < 1.0 && above > 0.0) {
                // In a search only what stands before the sun's disc counts: beforeSun() of sun_map.cpp.
                float reach = 0.5 * SUN_BOX * sun_frames[5 * map + 3].y * ahead;
                float before = clamp((reach - max(abs(away.x), abs(away.y))) / float(stride) + 2.0, 0.0, 1.0);
                weight *= searches ? before : 1.0;
                blocked += weight;
                sum += weight * above;
            }
        } while (++i <= last.x);
    } while (++j <= last.y);
    return blocked > 0.0 ? vec2(blocked / total, sum / blocked) : vec2(0.0);
}

// Where the map has a point; all lengths there are in texels.
vec3 sunPlace(int map, vec3 position) {
    vec3 place, from_origin = position - sun_frames[5 * map + 4].xyz;
    for (int i = 0; i < 3; ++i) {
        vec4 row = sun_frames[5 * map + i];
        place[i] = dot(row.xyz, from_origin) / sun_frames[5 * map + 3].z + row.w;
    }
    return place;
}

// The side of the box that fits the nearest caster to the sun, and how far its cells reach from its middle, which is
// beyond the box.
float sunWidest(int map, vec3 place) { return max(2.0 * place.z * sun_frames[5 * map + 3].y, 1.0); }
float sunReach(float widest) { return widest / 2.0 + ceil(widest / float(SUN_SEARCH_CELLS)); }

// How much of the light of a point this map tells; the maps after it tell the rest.
float sunWeight(int map, vec3 place) {
    float border = sun_frames[5 * map + 4].w, size = sun_frames[5 * map + 3].w;
    vec2 inside = min(place.xy, size - place.xy) - sunReach(sunWidest(map, place));
    return border == 0.0 ? 1.0 : smoothstep(0.0, border, min(inside.x, inside.y));
}

// Gives the receiver in a map. False where the surface faces away from the sun. `normal` is a unit vector.
bool sunReceiver(int map, vec3 place, vec3 normal, out SunReceiver receiver) {
    vec3 n;
    for (int i = 0; i < 3; ++i) n[i] = dot(sun_frames[5 * map + i].xyz, normal);
    float cosine = -n.z, limited = max(cosine, SUN_MIN_COSINE);
    receiver.widest = sunWidest(map, place);
    place.z -= SUN_BIAS + SUN_SLOPE_BIAS * sqrt(max(1.0 - limited * limited, 0.0)) / limited;
    receiver.place = place;
    receiver.slope = n.xy / limited;
    return cosine > 0.0;
}

// Whether the extremes of blocks show that nothing hides the receiver (1) or that everything does (0); -1 where texels
// must tell. Their least depth is that of the nearest caster around, so that what is left to look through is narrower
// than by the nearest one of the whole map: on a lit body that is next to nothing.
float sunFromBlocks(int map, inout SunReceiver receiver) {
    vec4 numbers = sun_frames[5 * map + 3];
    float reach = sunReach(receiver.widest);
    vec2 place = receiver.place.xy;
    bool outside = any(lessThan(place, vec2(-reach))) || any(greaterThan(place, vec2(numbers.w + reach)));
    if (outside) return 1.0;
    // A block of level k, with SUN_BLOCK 2^k texels a side, tells of all boxes around it that reach half its side.
    int level = max(1, findMSB(int(ceil(min(reach, 1e6))) - 1) + 2 - findMSB(SUN_BLOCK));
    bool known = level <= SUN_LEVELS;
    level = min(level, SUN_LEVELS);
    int widest_side = sun_block_side, side = widest_side >> level, before = widest_side >> (level - 1);
    int first = map * sun_block_count + (widest_side * widest_side - before * before) / 3;
    ivec2 block = ivec2(clamp(place, vec2(0.0), vec2(numbers.w - 1.0))) >> (level + findMSB(SUN_BLOCK));
    vec2 both = texelFetch(sun_blocks, first + block.y * side + block.x).xy;
    float change = reach * (abs(receiver.slope.x) + abs(receiver.slope.y));
    if (!known) return -1.0;
    receiver.widest = clamp(2.0 * (receiver.place.z - both.x * numbers.x) * numbers.y, 1.0, receiver.widest);
    if (both.x >= 1.0 || receiver.place.z + change <= both.x * numbers.x) return 1.0;
    return both.y < 1.0 && receiver.place.z - change > both.y * numbers.x ? 0.0 : -1.0;
}

// Share of the sun that reaches the receiver, from texels.
float sunFromTexels(int map, SunReceiver receiver) {
    float tan_radius = sun_frames[5 * map + 3].y, side = receiver.widest;
    vec2 blockers;
    int pass = 1;
    do {
        blockers = sunBlockers(map, receiver, side, pass < SUN_PASSES);
        float next = clamp(SUN_BOX * blockers.y * tan_radius, 1.0, receiver.widest);
        if (blockers.x == 0.0 || blockers.x == 1.0 || max(side, next) == 1.0) break;
        side = next;
    } while (++pass <= SUN_PASSES);
    return 1.0 - blockers.x;
}

// Share of the sun that reaches the point, 0 to 1; 0 where the surface faces away. Most points look into one map.
float sunVisibility(int sun, vec3 position, vec3 normal) {
    int map = sun_maps[sun].x - 1;
    if (sun_maps[sun].x == sun_maps[sun].y) return 1.0;
    float sum = 0.0, before = 0.0, left = 1.0;  // sums of differences are exact where maps agree
    do {
        vec3 place;
        float weight;
        do {
            ++map;
            place = sunPlace(map, position);
            weight = sunWeight(map, place);
        } while (weight == 0.0);  // the last map has 1
        SunReceiver receiver;
        float share = sunReceiver(map, place, normal, receiver) ? sunFromBlocks(map, receiver) : 0.0;
        if (share < 0.0) share = sunFromTexels(map, receiver);
        sum += left * (share - before);
        before = share;
        left *= 1.0 - weight;
    } while (left > 0.0);
    return sum;
}

// The unit normal of the triangle that the fragment lies on, on the side of the unit `normal` that is interpolated. The
// two differ by some degrees on a coarse mesh. A depth map knows triangles alone, so by its vertices' normals a mesh
// would shadow itself in specks. Only for fragment shaders; `position` is interpolated.
vec3 sunFacing(vec3 position, vec3 normal) {
    vec3 face = cross(dFdx(position), dFdy(position));
    float size = length(face);
    return size > 0.0 ? face * (sign(dot(face, normal)) / size) : normal;
}
