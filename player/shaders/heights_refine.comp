// Finer receivers of a height field, in cells that may look at something that changed: how much of what is finer each
// cell of `size` points shows, and where LOOK what the points half-way see. heights_seen.glsl and a preamble with
// WORK_GROUP stand before this text.
layout(local_size_x = WORK_GROUP) in;

layout(std430, binding = 3) readonly buffer Looking { uint looking[]; };  // cells between receivers

uniform int size;
uniform uint item_count;

#ifdef LOOK
bool shows(ivec2 low, ivec2 base) {
    return all(greaterThanEqual(low, base)) && all(lessThan(low, min(base + SPACING, side))) &&
           cell_shares[cellShareAt(low, size)] > 0.0;
}

// Whether a point is on the lattice of the cells of `size` points, which has looked before.
bool onLattice(int at, int base, int end) { return (at - base) % size == 0 || at == end; }

void lookAt(ivec2 base, ivec2 part) {
    int half_size = size / 2;
    ivec2 at = base + half_size * part;
    if (half_size == 1) {
        // The points themselves, of which the far edges belong to other cells.
        if (any(greaterThanEqual(at, min(base + SPACING, side)))) return;
    } else {
        if (any(greaterThanEqual(at, field_end + half_size))) return;
        at = min(at, field_end);
    }
    if (onLattice(at.x, base.x, field_end.x) && onLattice(at.y, base.y, field_end.y)) return;
    // The cells around it, unless only that one counts that it is in.
    ivec2 low = at - (at - base) % size;
    bool wanted = shows(low, base);
    if (half_size > 1) {
        ivec2 before = ivec2(onLattice(at.x, base.x, field_end.x) ? 1 : 0, onLattice(at.y, base.y, field_end.y) ? 1 : 0);
        ivec2 other = base + (max(at - before - base, 0)) / size * size;
        wanted = wanted || shows(other, base);
    }
    if (!wanted) return;
    ivec2 there = ivec2(at.x < side.x ? at.x : 0, at.y < side.y ? at.y : 0);
    int point = there.x * side.y + there.y;
    float v[ORDER * ORDER];
    heightVisibility(vec3(there, heights[point]), v);
    vec3 normal = heightNormal(there);
    for (int q = 0; q < ROW_QUADS; ++q) {
        vec4 four = vec4(0.0);
        for (int k = 0; k < 4; ++k) {
            int i = 4 * q + k;
            if (i < ORDER * ORDER + 3) four[k] = i < ORDER * ORDER ? v[min(i, ORDER * ORDER - 1)] : normal[max(i - ORDER * ORDER, 0)];
        }
        finer[ROW_QUADS * point + q] = four;
    }
}
#else
// HeightVisibility::shareOf().
float shareOf(ivec2 low, ivec2 high) {
    // A narrow cell at the border stands for a smaller one.
    int half_size = size / 2;
    while (half_size > 0 && half_size >= max(high.x - low.x, high.y - low.y)) half_size /= 2;
    if (half_size == 0) return 0.0;
    bvec2 has = lessThan(low + half_size, high);
    int first[4];
    bool is_finer[4];
    vec3 normals[4];
    for (int k = 0; k < 4; ++k) {
        first[k] = seenAt(ivec2(k > 1 ? high.x : low.x, k % 2 == 1 ? high.y : low.y), is_finer[k]);
        normals[k] = normalOf(first[k], is_finer[k]);
    }
    float apart = 0.0;
    for (int i = 0; i < ORDER * ORDER; i += 4) {
        vec4 four[4], mean = vec4(0.0);
        for (int k = 0; k < 4; ++k) {
            four[k] = is_finer[k] ? finer[first[k] + i / 4] : rows[first[k] + i / 4];
            mean += 0.25 * four[k];
        }
        vec4 used = vec4(lessThan(ivec4(i) + ivec4(0, 1, 2, 3), ivec4(ORDER * ORDER)));
        for (int k = 0; k < 4; ++k) apart += dot(used * (four[k] - mean), four[k] - mean);
    }
    apart = sqrt(apart / (16.0 * 3.14159265358979));
    vec2 middle = vec2(half_size) / vec2(max(high - low, 1));
    float sum = 0.0, count = 0.0;
    for (int k = 0; k < 5; ++k) {
        // The middle, then the middles of the edges along both axes.
        if (k == 0 ? !all(has) : k < 3 ? !has.y : !has.x) continue;
        vec2 share = k == 0 ? middle : k < 3 ? vec2(k - 1, middle.y) : vec2(middle.x, k - 3);
        ivec2 at = ivec2(k == 0 || k > 2 ? low.x + half_size : k == 1 ? low.x : high.x,
                         k < 3 ? low.y + half_size : k == 3 ? low.y : high.y);
        vec3 between = mix(mix(normals[0], normals[1], share.y), mix(normals[2], normals[3], share.y), share.x);
        vec3 off = heightNormal(ivec2(at.x < side.x ? at.x : 0, at.y < side.y ? at.y : 0)) - between;
        sum += dot(off, off);
        count += 1.0;
    }
    float rough = sqrt(sum / count), error = 0.5 * sqrt((apart + 0.1 * rough) * (rough + 0.1 * apart));  // cellError()
    return clamp((error - TOLERANCE) / (0.5 * TOLERANCE), 0.0, 1.0);
}
#endif

void main() {
    uint item = gl_GlobalInvocationID.x + gl_GlobalInvocationID.y * gl_NumWorkGroups.x * WORK_GROUP;
    if (item >= item_count) return;
#ifdef LOOK
    uint count = uint(2 * SPACING / size + 1);
#else
    uint count = uint(SPACING / size);
#endif
    uint cell = looking[item / (count * count)], part = item % (count * count);
    ivec2 base = SPACING * ivec2(cell / uint(lines.y), cell % uint(lines.y));
    ivec2 offset = ivec2(part / count, part % count);
    if (any(greaterThanEqual(base, side))) return;
#ifdef LOOK
    lookAt(base, offset);
#else
    ivec2 low = base + size * offset;
    if (any(greaterThanEqual(low, side))) return;
    bool shown = size == SPACING || cell_shares[cellShareAt(low, 2 * size)] > 0.0;
    cell_shares[cellShareAt(low, size)] = shown ? shareOf(low, min(low + size, field_end)) : 0.0;
#endif
}
