// Computes the visibility at the receivers of a height field, and with REFINED at finer ones: the twin of
// sh/height/height_refinement.h. heights.glsl and a preamble with LINES, SPACING, NORMALS_MATTER and ROW_QUADS stand
// before this text; with REFINED the preamble also has SHARES and TOLERANCE.
const ivec2 lines = LINES;  // rows and columns of receivers, SPACING points apart

layout(std430, binding = 2) readonly buffer Rows { vec4 rows[]; };  // written by heights_horizons.comp

#ifdef REFINED
layout(std430, binding = 6) buffer Finer { vec4 finer[]; };  // ROW_QUADS a point, of those that looked
// How much of what is finer shows in cells of SPACING, SPACING / 2, .. 2 points: SHARES to a cell between receivers.
layout(std430, binding = 7) buffer CellShares { float cell_shares[]; };

// Where the last cell ends.
#ifdef WRAPS
const ivec2 field_end = side;
#else
const ivec2 field_end = side - 1;
#endif

uint cellShareAt(ivec2 at, int size) {
    ivec2 cell = at / SPACING, part = at % SPACING / size;
    int count = SPACING / size;
    return uint(SHARES * (cell.x * lines.y + cell.y) + (count * count - 1) / 3 + part.x * count + part.y);
}

// The line of receivers at a point of an axis, or -1.
int lineAt(int at, int count, int line_count) {
    if (at % SPACING == 0) return at / SPACING;
#ifndef WRAPS
    if (at == count - 1) return line_count - 1;
#endif
    return -1;
}

// Where the quads of a receiver begin, and whether it is a finer one. Beyond a periodic border stands the first line.
int seenAt(ivec2 at, out bool is_finer) {
    at = ivec2(at.x < side.x ? at.x : 0, at.y < side.y ? at.y : 0);
    ivec2 line = ivec2(lineAt(at.x, side.x, lines.x), lineAt(at.y, side.y, lines.y));
    is_finer = line.x < 0 || line.y < 0;
    return ROW_QUADS * (is_finer ? at.x * side.y + at.y : line.x * lines.y + line.y);
}

vec3 normalOf(int first, bool is_finer) {
    vec3 normal;
    for (int c = 0; c < 3; ++c) {
        int quad = first + (ORDER * ORDER + c) / 4;
        vec4 four = is_finer ? finer[quad] : rows[quad];
        normal[c] = four[(ORDER * ORDER + c) % 4];
    }
    return normal;
}

void addSeen(ivec2 at, float weight, inout float v[ORDER * ORDER]) {
    bool is_finer;
    int first = seenAt(at, is_finer);
    for (int i = 0; i < ORDER * ORDER; i += 4) {
        vec4 four = is_finer ? finer[first + i / 4] : rows[first + i / 4];
        for (int k = 0; k < 4; ++k)
            if (i + k < ORDER * ORDER) v[i + k] += weight * four[k];
    }
}

// Mixes what finer receivers see into what those around a point do.
void mixFiner(ivec2 at, vec3 normal, inout float v[ORDER * ORDER]) {
    ivec2 inside = at % SPACING;
    float left = cell_shares[cellShareAt(at, SPACING)];  // share left for finer cells
    if (left <= 0.0) return;
    for (int i = 0; i < ORDER * ORDER; ++i) v[i] *= 1.0 - left;
    for (int size = SPACING / 2; left > 0.0; size /= 2) {
        if (size == 1) {
            addSeen(at, left, v);
            break;
        }
        float deeper = left * cell_shares[cellShareAt(at, size)], here = left - deeper;
        left = deeper;
        if (here <= 0.0) continue;
        ivec2 low = at - inside % size, high = min(low + size, field_end);
        vec2 share = vec2(at - low) / vec2(max(high - low, 1));
        float weights[4], sum = 0.0;
        for (int k = 0; k < 4; ++k) {
            bool down = k > 1, right = k % 2 == 1, is_finer;
            int first = seenAt(ivec2(down ? high.x : low.x, right ? high.y : low.y), is_finer);
            vec3 way = normalOf(first, is_finer) - normal;
            weights[k] = (down ? share.x : 1.0 - share.x) * (right ? share.y : 1.0 - share.y) /
                         (1.0 + NORMALS_MATTER * dot(way, way));
            sum += weights[k];
        }
        for (int k = 0; k < 4; ++k)
            addSeen(ivec2(k > 1 ? high.x : low.x, k % 2 == 1 ? high.y : low.y), here * weights[k] / sum, v);
    }
}
#endif
