// The share of a sun that a point sees, from depth maps of the casters. It has the rules of SunMap
// (player/runtime/sun_map.h), whose source tells the method. player/draw/sun_map_painter.cpp defines MAX_SUNS, BIAS,
// SLOPE_BIAS, LEAST_COSINE, BOX, CELLS, SEARCH_CELLS, PASSES and BLOCK as SUN_... from its constants.
uniform sampler2DArray sun_depths;        // a layer a sun: depth / range; 1: nothing
uniform samplerBuffer sun_blocks;           // what sun_blocks.comp makes
uniform vec4 sun_frames[4 * SUN_MAX_SUNS];  // SunFrame: 3 rows, then (range, tangent of the radius, texel, size)

// Where cell `across` of a line tests its texel, from its start: the multiples of the golden section.
int sunCellTexel(int across, int stride) { return (((across * 40503) & 65535) * stride) >> 16; }

// The share of a box that blockers cover, and their mean distance. Lengths are in texels. `place` is the receiver's,
// less the bias in depth, and `slope` that of the depth of its plane.
vec2 sunBlockers(int sun, vec3 place, vec2 slope, float side, int cells) {
    int size = int(sun_frames[4 * sun + 3].w);
    float range = sun_frames[4 * sun + 3].x;
    int stride = max(1, int(ceil(side / float(cells))));
    vec2 low = place.xy - side / 2.0, high = place.xy + side / 2.0;
    ivec2 first = ivec2(floor(low / float(stride))), last = ivec2(floor(high / float(stride)));
    float total = 0.0, blocked = 0.0, sum = 0.0;
    for (int j = first.y; j <= last.y; ++j)
        for (int i = first.x; i <= last.x; ++i) {
            ivec2 texel = ivec2(i * stride + sunCellTexel(j, stride), j * stride + sunCellTexel(i, stride));
            bool inside = all(greaterThanEqual(texel, ivec2(0))) && all(lessThan(texel, ivec2(size)));
            float stored = texelFetch(sun_depths, ivec3(clamp(texel, ivec2(0), ivec2(size - 1)), sun), 0).x;
            float above = place.z + dot(slope, vec2(texel) + 0.5 - place.xy) - stored * range;
            vec2 cell = vec2(i, j);
            vec2 overlap = min(high, (cell + 1.0) * float(stride)) - max(low, cell * float(stride));
            float weight = overlap.x * overlap.y;
            total += weight;
            if (inside && stored < 1.0 && above > 0.0) {
                blocked += weight;
                sum += weight * above;
            }
        }
    return blocked > 0.0 ? vec2(blocked / total, sum / blocked) : vec2(0.0);
}

// Whether the box shows that nothing hides the point (1) or that everything does (0), from the extremes of blocks; -1
// where texels must tell. It changes no result.
float sunAtOnce(int sun, vec3 place, vec2 slope, float side) {
    int size = int(sun_frames[4 * sun + 3].w);
    float range = sun_frames[4 * sun + 3].x;
    int fine = (size + SUN_BLOCK - 1) / SUN_BLOCK, coarse = (fine + SUN_BLOCK - 1) / SUN_BLOCK;
    bool small = side <= float(2 * SUN_BLOCK);
    int first_block = sun * (fine * fine + coarse * coarse) + (small ? 0 : fine * fine);
    int blocks_side = small ? fine : coarse;
    float block = float(small ? SUN_BLOCK : SUN_BLOCK * SUN_BLOCK);
    // The cells of a wide box reach beyond it.
    float reach = side / 2.0 + ceil(side / float(SUN_SEARCH_CELLS));
    ivec2 first = ivec2(floor((place.xy - reach) / block)), last = ivec2(floor((place.xy + reach) / block));
    vec2 both = vec2(1.0, 0.0);
    bool outside = any(lessThan(place.xy - reach, vec2(0.0))) || any(greaterThan(place.xy + reach, vec2(size)));
    first = clamp(first, ivec2(0), ivec2(blocks_side - 1));
    last = clamp(last, ivec2(0), ivec2(blocks_side - 1));
    for (int j = first.y; j <= last.y; ++j)
        for (int i = first.x; i <= last.x; ++i) {
            vec2 one = texelFetch(sun_blocks, first_block + j * blocks_side + i).xy;
            both = vec2(min(both.x, one.x), max(both.y, one.y));
        }
    float change = reach * (abs(slope.x) + abs(slope.y));
    if (both.x >= 1.0 || place.z + change <= both.x * range) return 1.0;
    return !outside && both.y < 1.0 && place.z - change > both.y * range ? 0.0 : -1.0;
}

// Share of the sun that reaches the point, 0 to 1. `normal` is a unit vector. 0 where the surface faces away.
float sunVisibility(int sun, vec3 position, vec3 normal) {
    vec4 numbers = sun_frames[4 * sun + 3];
    if (numbers.w == 0.0) return 1.0;
    vec3 n, place;
    for (int i = 0; i < 3; ++i) {
        vec4 row = sun_frames[4 * sun + i];
        n[i] = dot(row.xyz, normal);
        place[i] = dot(row.xyz, position) / numbers.z + row.w;
    }
    float cosine = -n.z;
    if (!(cosine > 0.0)) return 0.0;
    float limited = max(cosine, SUN_LEAST_COSINE);
    float widest = max(2.0 * place.z * numbers.y, 1.0);
    place.z -= SUN_BIAS + SUN_SLOPE_BIAS * sqrt(max(1.0 - limited * limited, 0.0)) / limited;
    vec2 slope = n.xy / limited;
    float at_once = sunAtOnce(sun, place, slope, widest);
    // Software GL skips no branches, but loops that are over.
    int passes = at_once < 0.0 ? SUN_PASSES : 0;
    float side = widest;
    vec2 blockers = vec2(1.0 - at_once, 0.0);
    for (int pass = 0; pass < passes; ++pass) {
        blockers = sunBlockers(sun, place, slope, side, pass + 1 < SUN_PASSES ? SUN_SEARCH_CELLS : SUN_CELLS);
        float next = clamp(SUN_BOX * blockers.y * numbers.y, 1.0, widest);
        if (blockers.x == 0.0 || blockers.x == 1.0 || max(side, next) == 1.0) break;
        if (pass + 1 < SUN_PASSES) side = next;
    }
    return 1.0 - blockers.x;
}

// The unit normal of the triangle that the fragment lies on, on the side of the unit `normal` that is interpolated. The
// two differ by some degrees on a coarse mesh. A depth map knows triangles alone, so by its vertices' normals a mesh
// would shadow itself in specks. Only for fragment shaders; `position` is interpolated.
vec3 sunFacing(vec3 position, vec3 normal) {
    vec3 face = cross(dFdx(position), dFdy(position));
    float size = length(face);
    return size > 0.0 ? face * (sign(dot(face, normal)) / size) : normal;
}
