// The far parts of a composed model in WGSL: what player/shaders/far.glsl and runtime/shaders/field.glsl have in GLSL,
// in the same order. Functions that are written out number by number come from the library as GLSL, whose assignments
// are those of WGSL.

/** Where the arrays of a composed model are in the buffers. */
export interface FarPlaces {
    /** Words of penumbra_asset_get_far, and where they begin. */
    far: Uint32Array;
    first: number;
    partCount: number;
    /** Floats of the pose: posed parts, and positions, normals, tangents [3, V, 3]. */
    parts: number;
    frames: number;
    vertexCount: number;
    /** Numbers of a vertex that are coefficients. */
    numbers: number;
}

/** The body of a function of the library's text. */
function bodyOf(glsl: string, name: string): string {
    const begin = glsl.indexOf('{\n', glsl.indexOf(`void ${name}(`)) + 2;
    return glsl.slice(begin, glsl.indexOf('\n}\n', begin));
}

/** Loops of one statement, and arrays of the invocation instead of those of a function. */
function inWgsl(body: string): string {
    return body
        .replace(/^ *float c\[6\].*$/m, '')
        .replace(/for \(int (\w) = 0; \w < (\d+); \+\+\w\) (.*;)/g, 'for (var $1 = 0; $1 < $2; $1++) { $3 }')
        .replace(/penumbra_far_(from_)?around\(.*\)/g, 'far_$1around()')
        .replace(/\b(c|s|ring|values)\[/g, 'far_$1[');
}

function constants(glsl: string): string {
    const numbers = [...glsl.matchAll(/^const float penumbra_(\w+) = ([^;]+);$/gm)];
    const scales = /penumbra_sphere_scales\[4\] = float\[4\]\(([^)]+)\)/.exec(glsl)![1];
    return (
        numbers.map(([, name, value]) => `const ${name}: f32 = ${value};\n`).join('') +
        `const sphere_scales = array<f32, 4>(${scales});\n`
    );
}

const AROUND = `
// The sum over m of c[m] cos(m phi) + s[m] sin(m phi) at phi = pi q / 8.
const cos1 = 0.92387953;
const cos2 = 0.70710678;
const cos3 = 0.38268343;
fn far_around() {
    let c = far_c;
    let s = far_s;
    let same = array<f32, 4>(c[0] + c[4], c[0] + s[4], c[0] - c[4], c[0] - s[4]);
    let over = array<f32, 4>(c[2], cos2 * (c[2] + s[2]), s[2], cos2 * (s[2] - c[2]));
    let cosine = array<f32, 4>(c[1] + c[3] + c[5], cos1 * c[1] + cos3 * c[3] - cos3 * c[5],
                               cos2 * (c[1] - c[3] - c[5]), cos3 * c[1] - cos1 * c[3] + cos1 * c[5]);
    let sine = array<f32, 5>(0.0, cos3 * s[1] + cos1 * s[3] + cos1 * s[5], cos2 * (s[1] + s[3] - s[5]),
                             cos1 * s[1] - cos3 * s[3] - cos3 * s[5], s[1] - s[3] + s[5]);
    var even = array<f32, 8>(same[0] + over[0], same[1] + over[1], same[2] + over[2], same[3] + over[3],
                             same[0] - over[0], same[1] - over[1], same[2] - over[2], same[3] - over[3]);
    var odd = array<f32, 8>(cosine[0], sine[1] + cosine[1], sine[2] + cosine[2], sine[3] + cosine[3],
                            sine[4], sine[3] - cosine[3], sine[2] - cosine[2], sine[1] - cosine[1]);
    for (var q = 0; q < 8; q++) {
        far_ring[q] = even[q] + odd[q];
        far_ring[q + 8] = even[q] - odd[q];
    }
}
// The transpose of that.
fn far_from_around() {
    var even: array<f32, 8>;
    var odd: array<f32, 8>;
    for (var q = 0; q < 8; q++) {
        even[q] = far_ring[q] + far_ring[q + 8];
        odd[q] = far_ring[q] - far_ring[q + 8];
    }
    let same = array<f32, 4>(even[0] + even[4], even[1] + even[5], even[2] + even[6], even[3] + even[7]);
    let over = array<f32, 4>(even[0] - even[4], even[1] - even[5], even[2] - even[6], even[3] - even[7]);
    let cosine = array<f32, 4>(0.0, odd[1] - odd[7], odd[2] - odd[6], odd[3] - odd[5]);
    let sine = array<f32, 4>(0.0, odd[1] + odd[7], odd[2] + odd[6], odd[3] + odd[5]);
    let c2 = cos2 * cosine[2];
    let s2 = cos2 * sine[2];
    far_c = array<f32, 6>((same[0] + same[2]) + (same[1] + same[3]), odd[0] + cos1 * cosine[1] + c2 + cos3 * cosine[3],
                          over[0] + cos2 * (over[1] - over[3]), odd[0] + cos3 * cosine[1] - c2 - cos1 * cosine[3],
                          same[0] - same[2], odd[0] - cos3 * cosine[1] - c2 + cos1 * cosine[3]);
    far_s = array<f32, 6>(0.0, odd[4] + cos3 * sine[1] + s2 + cos1 * sine[3], over[2] + cos2 * (over[1] + over[3]),
                          cos1 * sine[1] + s2 - cos3 * sine[3] - odd[4], same[1] - same[3],
                          cos1 * sine[1] - s2 - cos3 * sine[3] + odd[4]);
}
`;

function written(glsl: string): string {
    const turn = bodyOf(glsl, 'penumbra_far_turn');
    return `
var<private> penumbra_f: array<f32, 36>;
var<private> penumbra_even: array<f32, 21>;
var<private> far_c: array<f32, 6>;
var<private> far_s: array<f32, 6>;
var<private> far_ring: array<f32, 16>;
var<private> far_values: array<f32, 64>;

// Turns penumbra_f into the frame whose axes are the rows.
fn far_turn(row0: vec3f, row1: vec3f, row2: vec3f) {
    var cos_a: array<f32, 6>;
    var sin_a: array<f32, 6>;
    var cos_b: array<f32, 6>;
    var sin_b: array<f32, 6>;
    var cos_c: array<f32, 6>;
    var sin_c: array<f32, 6>;
    var g: array<f32, 36>;
    var turned: f32;
    let square = row0.z * row0.z + row1.z * row1.z;
    let along = square > 1e-30;
    let scale = select(0.0, 1.0 / sqrt(max(square, 1e-30)), along);
    cos_a[1] = select(1.0, row0.z * scale, along);
    sin_a[1] = row1.z * scale;
    cos_b[1] = row2.z;
    sin_b[1] = cos_a[1] * row0.z + sin_a[1] * row1.z;
    cos_c[1] = cos_a[1] * row1.y - sin_a[1] * row0.y;
    sin_c[1] = cos_a[1] * row1.x - sin_a[1] * row0.x;
    for (var m = 2; m < 6; m++) {
        cos_a[m] = cos_a[m - 1] * cos_a[1] - sin_a[m - 1] * sin_a[1];
        sin_a[m] = sin_a[m - 1] * cos_a[1] + cos_a[m - 1] * sin_a[1];
        cos_b[m] = cos_b[m - 1] * cos_b[1] - sin_b[m - 1] * sin_b[1];
        sin_b[m] = sin_b[m - 1] * cos_b[1] + cos_b[m - 1] * sin_b[1];
        cos_c[m] = cos_c[m - 1] * cos_c[1] - sin_c[m - 1] * sin_c[1];
        sin_c[m] = sin_c[m - 1] * cos_c[1] + cos_c[m - 1] * sin_c[1];
    }
${turn.slice(turn.indexOf('\n    }\n') + 7)}
}
fn far_mirror(by_bands: f32, by_height: f32) {
${bodyOf(glsl, 'penumbra_far_mirror')}
}
${AROUND}
// The values of penumbra_even at the 64 directions, and the function that has these values.
fn far_to_values() {
${inWgsl(bodyOf(glsl, 'penumbra_far_values'))}
}
fn far_from_values() {
${inWgsl(bodyOf(glsl, 'penumbra_far_from_values'))}
}
`;
}

const FIELD = `
fn float_at(at: u32) -> f32 { return bitcast<f32>(words[at]); }
fn vector_at(at: u32) -> vec3f { return vec3f(float_at(at), float_at(at + 1u), float_at(at + 2u)); }
fn bytes_of(word: u32) -> vec4f {
    let w = bitcast<i32>(word);
    return vec4f(f32(extractBits(w, 0u, 8u)), f32(extractBits(w, 8u, 8u)), f32(extractBits(w, 16u, 8u)), f32(extractBits(w, 24u, 8u)));
}
fn part_row(part: u32, row: u32) -> vec4f {
    let at = PARTS + 28u * part + 4u * row;
    return vec4f(pose[at], pose[at + 1u], pose[at + 2u], pose[at + 3u]);
}
fn frame_of(vertex: u32, which: u32) -> vec3f {
    let at = FRAMES + 3u * (which * VERTICES + vertex);
    return vec3f(pose[at], pose[at + 1u], pose[at + 2u]);
}

// A part as one point sees it.
struct Sight { height: f32, sine: f32, share: f32, weight: f32, inside: f32, counts: bool }

// Tells how high the part stands, and whether it is large enough to count.
fn field_height(part: u32, position: vec3f, normal: vec3f, sight: ptr<function, Sight>) -> bool {
    let sphere = part_row(part, 6u);
    let way = sphere.xyz - position;
    let along = dot(way, normal);
    let square = dot(way, way);
    let radius2 = sphere.w * sphere.w;
    (*sight).height = clamp(along / sphere.w, -1.0, 1.0);
    (*sight).sine = along / sqrt(square + 1e-20);
    return radius2 >= 4.0 * blocked_from * (square - radius2);
}

// Eight points of a level around the point.
struct Level { share: f32, first: i32, stride: vec3i, part: vec3f }

fn field_box(box: u32, point: vec3f) -> Level {
    let cells = vector_at(box + 9u);
    let above = point - vector_at(box);
    let below = vector_at(box + 3u) - point;
    let depth = min(min(min(above.x, below.x), min(above.y, below.y)), min(above.z, below.z));
    let t = clamp(above * vector_at(box + 6u), vec3f(0.0), cells);
    let cell = vec3i(min(t, cells - 1.0));
    let stride = vec3i(1, i32(words[box + 13u]), i32(words[box + 14u]));
    let first = i32(words[box + 15u]) + cell.x + cell.y * stride.y + cell.z * stride.z;
    return Level(clamp(depth * float_at(box + 12u), 0.0, 1.0), first, stride, t - vec3f(cell));
}

// Four points on each of two spheres, which are linear in u = r / d. The octahedral map unfolds a sphere to a square.
fn field_spheres(at: u32, offset: vec3f, distance: f32, radius: f32) -> Level {
    var scales = sphere_scales;
    let u = clamp(select(1.0, radius / max(distance, 1e-30), distance > 0.0), scales[0], scales[3]);
    let sphere = select(select(0, 1, u > scales[1]), 2, u > scales[2]);
    let low = scales[sphere];
    let high = scales[sphere + 1];
    let size = abs(offset);
    let sum = size.x + size.y + size.z;
    let side = select(vec2f(-1.0), vec2f(1.0), offset.xy >= vec2f(0.0));
    let over = max(sum, 1e-30);
    let folded = select((1.0 - size.yx / over) * side, offset.xy / over, offset.z >= 0.0);
    let map = select(vec2f(0.0), folded, sum > 0.0);
    let t = clamp((map + 1.0) * 6.0, vec2f(0.0), vec2f(12.0));
    let cell = vec2i(min(t, vec2f(11.0)));
    let first = i32(words[at + 37u]) + sphere * 169 + cell.x * 13 + cell.y;
    return Level(0.0, first, vec3i(13, 1, 169), vec3f(t - vec2f(cell), (u - low) / (high - low)));
}

// Adds the share of a level to penumbra_f. Returns its share of the signed distance, which only the fine box has.
fn field_add(at: u32, index: u32, level: Level) -> f32 {
    var sum: array<vec4f, 9>;
    var distance = 0.0;
    for (var c = 0; c < 8; c++) {
        let corner = vec3i(c & 1, (c >> 1u) & 1, c >> 2u);
        let weights = mix(1.0 - level.part, level.part, vec3f(corner));
        let weight = weights.x * weights.y * weights.z;
        let steps = corner * level.stride;
        let point = u32(level.first + steps.x + steps.y + steps.z);
        let word = words[at + 38u] + 9u * point;
        for (var i = 0u; i < 9u; i++) { sum[i] += weight * bytes_of(words[word + i]); }
        if (index == 0u) {
            let four = bitcast<i32>(words[words[at + 39u] + point / 4u]);
            distance += weight * f32(extractBits(four, 8u * (point % 4u), 8u));
        }
    }
    for (var l = 0u; l < 6u; l++) {
        let scale = level.share * float_at(at + 41u + 6u * index + l);
        for (var i = l * l; i < (l + 1u) * (l + 1u); i++) { penumbra_f[i] += scale * sum[i / 4u][i % 4u]; }
    }
    return select(0.0, level.share * float_at(at + 40u) * distance, index == 0u);
}

// Writes V - 1 of a part in its rest frame to penumbra_f, and tells by what it counts.
fn field_blocked(part: u32, position: vec3f, sight: ptr<function, Sight>) {
    let at = 4u * u32(part_row(part, 3u).w);
    let p = vec4f(position, 1.0);
    let point = vec3f(dot(part_row(part, 0u), p), dot(part_row(part, 1u), p), dot(part_row(part, 2u), p));
    let offset = point - vector_at(at + 32u);
    let square = dot(offset, offset);
    let radius = float_at(at + 35u);
    for (var i = 0; i < 36; i++) { penumbra_f[i] = 0.0; }
    var fine_share = 0.0;
    var left = 1.0;
    var distance = 0.0;
    for (var l = 0u; l < 3u; l++) {
        if (left <= 0.0) { break; }
        var level: Level;
        if (l < 2u) {
            level = field_box(at + 16u * l, point);
            if (l == 0u) { fine_share = level.share; }
            level.share *= left;
        } else {
            level = field_spheres(at, offset, sqrt(square), radius);
            level.share = left;
        }
        left -= level.share;
        if (level.share > 0.0) { distance += field_add(at, l, level); }
    }
    let scale = 1.0 / (square + 0.25 * radius * radius);
    for (var i = 0; i < 36; i++) { penumbra_f[i] *= scale; }
    (*sight).inside = clamp(-distance * float_at(at + 36u) * dark, 0.0, fine_share);
    let share = -penumbra_f[0] / root_of_sphere;
    (*sight).share = share;
    (*sight).weight = clamp((share - blocked_from) / (blocked_full - blocked_from), 0.0, 1.0) *
                      (overlap + (1.0 - overlap) * clamp(share / solid, 0.0, 1.0));
    (*sight).counts = (*sight).weight > 0.0 || (*sight).inside > 0.0;
}

fn into_part(part: u32) -> mat3x3f {
    return mat3x3f(part_row(part, 3u).xyz, part_row(part, 4u).xyz, part_row(part, 5u).xyz);
}

// exp(x) = exp(x / 8)^8, for x in [-6, 2].
fn far_exponential(exponent: f32) -> f32 {
    var x = 0.125 * clamp(exponent, -6.0, 2.0);
    x = 1.0 + x * (1.0 + x * (0.5 + x * (1.0 / 6.0 + x * (1.0 / 24.0))));
    x *= x;
    x *= x;
    return x * x;
}

fn list_begin(part: u32) -> u32 { return words[LISTS + part]; }
fn list_part(i: u32) -> u32 { return words[LISTS + PART_COUNT + 1u + i]; }
`;

const ANCHORS = `
// Sums the parts that block little, and tells how near each part is.
@compute @workgroup_size(64)
fn anchors(@builtin(global_invocation_id) id: vec3u) {
    if (id.x >= ANCHOR_COUNT) { return; }
    let vertex = words[ANCHORS + 2u * id.x];
    let out_at = words[ANCHORS + 2u * id.x + 1u];
    let own_part = words[PART_OF_VERTEX + vertex];
    let position = frame_of(vertex, 0u);
    let normal = frame_of(vertex, 1u);
    var rest: array<f32, 36>;
    let begin = list_begin(own_part);
    for (var i = begin; i < list_begin(own_part + 1u); i++) {
        let part = list_part(i);
        var sight: Sight;
        var near = 0.0;
        if (field_height(part, position, normal, &sight)) {
            field_blocked(part, position, &sight);
            if (sight.counts) {
                near = clamp((sight.share - near_from) / (near_full - near_from), 0.0, 1.0);
                // Few bands are darker in the middle than V - 1, and leak below the horizon.
                let deep = clamp(36.0 * sight.share, 0.0, 1.0);
                let above = clamp(1.0 + sight.sine, 0.0, 1.0);
                let scale = sight.weight * (1.0 - near) * above * (1.0 + depth * deep);
                if (scale > 0.0) {
                    let turn = into_part(part);
                    far_turn(turn[0], turn[1], turn[2]);
                    for (var j = 0; j < 36; j++) { rest[j] += scale * penumbra_f[j]; }
                }
            }
        }
        anchor_values[out_at + 9u + (i - begin) / 4u][(i - begin) % 4u] = near;
    }
    for (var i = 0u; i < 9u; i++) {
        anchor_values[out_at + i] = vec4f(rest[4u * i], rest[4u * i + 1u], rest[4u * i + 2u], rest[4u * i + 3u]);
    }
}
`;

const COMPOSE = `
// The share of a vertex in its anchors.
struct Owed { has_anchors: bool, begin: vec4u, weight: vec4f }
fn interpolated(owed: Owed, i: u32) -> vec4f {
    let at = owed.begin + i;
    return owed.weight.x * anchor_values[at.x] + owed.weight.y * anchor_values[at.y] +
           owed.weight.z * anchor_values[at.z] + owed.weight.w * anchor_values[at.w];
}

// Multiplies sums by what the far and near parts leave visible at the vertex.
fn compose(vertex: u32, sums: ptr<function, array<vec4f, STRIDE4>>) {
    let position = frame_of(vertex, 0u);
    let normal = frame_of(vertex, 1u);
    let tangent = frame_of(vertex, 2u);
    let bitangent = cross(normal, tangent);
    let own_part = words[PART_OF_VERTEX + vertex];
    var product: array<f32, 64>;
    for (var d = 0; d < 64; d++) { product[d] = 1.0; }
    var light = 1.0;
    let row = RECEIVERS + 8u * vertex;
    let owed = Owed(words[row] != 0xffffffffu, vec4u(words[row], words[row + 1u], words[row + 2u], words[row + 3u]),
                    vec4f(float_at(row + 4u), float_at(row + 5u), float_at(row + 6u), float_at(row + 7u)));
    // 1. What blocks much, or without anchors all far parts; then the sum of the others; then near parts.
    let begin = list_begin(own_part);
    let end = list_begin(own_part + 1u);
    for (var i = begin; i <= end + NEAR_COUNT; i++) {
        let is_sum = i == end;
        var row0 = tangent;
        var row1 = bitangent;
        var row2 = normal;
        var by_bands = 1.0;
        var by_height = 0.0;
        var whole = 1.0;
        if (is_sum) {
            if (!owed.has_anchors) { continue; }
            for (var j = 0u; j < 9u; j++) {
                let four = interpolated(owed, j);
                for (var k = 0u; k < 4u; k++) { penumbra_f[4u * j + k] = four[k]; }
            }
            if (penumbra_f[0] >= 0.0) { continue; }
        } else {
            var part: u32;
            var share = 1.0;
            if (i > end) {
                part = words[NEAR_PARTS + NEAR_COUNT * own_part + i - end - 1u];
                if (part == 65535u) { continue; }
                share = f32(words[NEAR_GAINS + NEAR_COUNT * vertex + i - end - 1u]) / 128.0;
            } else {
                part = list_part(i);
                if (owed.has_anchors) {
                    let near = interpolated(owed, 9u + (i - begin) / 4u);
                    share = clamp(near[(i - begin) % 4u], 0.0, 1.0);
                }
            }
            if (share <= 0.0) { continue; }
            var sight: Sight;
            if (!field_height(part, position, normal, &sight) || sight.height <= -1.0) { continue; }
            field_blocked(part, position, &sight);
            let outside = 1.0 - sight.inside * share;
            var counted = share * sight.weight;
            if (i > end && sight.weight > 0.0) {
                // 1 - a (1 - (1 + w g) (1 - inside)) = 1 - a inside + a (1 - inside) w g
                whole = outside;
                counted *= 1.0 - sight.inside;
            } else {
                light *= outside;
            }
            if (sight.weight == 0.0) { continue; }
            let turn = into_part(part);
            row0 = turn * row0;
            row1 = turn * row1;
            row2 = turn * row2;
            let sure = sight.height * sight.height;
            by_bands = counted * (1.0 - sure);
            by_height = select(0.0, 2.0 * counted * sure, sight.height > 0.0);
        }
        far_turn(row0, row1, row2);
        far_mirror(by_bands, by_height);
        if (!is_sum) { penumbra_even[0] += root_of_sphere * whole; }
        far_to_values();
        for (var d = 0; d < 64; d++) { product[d] *= select(far_values[d], far_exponential(far_values[d]), is_sum); }
    }
    // 2. Back from the directions, which leaves the bands of a far factor.
    far_values = product;
    far_from_values();
    for (var i = 0; i < 21; i++) { penumbra_even[i] *= light; }
    // 3. The product of that and the coefficients, at the same directions.
    far_to_values();
    product = far_values;
    for (var i = 0u; i < 21u; i++) { penumbra_even[i] = select(0.0, (*sums)[min(i / 4u, STRIDE4 - 1u)][i % 4u], i < NUMBERS); }
    far_to_values();
    for (var d = 0; d < 64; d++) { far_values[d] *= product[d]; }
    far_from_values();
    for (var i = 0u; i < NUMBERS; i++) { (*sums)[i / 4u][i % 4u] = penumbra_even[i]; }
}
`;

/** Declarations of `compose` and of the entry point `anchors`, which need `words`, `pose` and `anchor_values`. */
export function farWgsl(glsl: string, { far, first, ...places }: FarPlaces): string {
    const names = ['LISTS', 'ANCHORS', 'RECEIVERS', 'PART_OF_VERTEX', 'NEAR_PARTS', 'NEAR_GAINS'];
    const numbers: Record<string, number> = {
        ...Object.fromEntries(names.map((name, i) => [name, first + far[3 + i]])),
        ANCHOR_COUNT: far[0],
        NEAR_COUNT: far[2],
        PART_COUNT: places.partCount,
        PARTS: places.parts,
        FRAMES: places.frames,
        VERTICES: places.vertexCount,
        NUMBERS: places.numbers,
    };
    const all = Object.entries(numbers).map(([name, value]) => `const ${name} = ${value}u;\n`).join('');
    return all + constants(glsl) + written(glsl) + FIELD + ANCHORS + COMPOSE;
}
