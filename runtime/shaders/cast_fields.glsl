// Computes the visibility past the parts of characters at any point, like CastShadow (runtime/cast/cast_shadow.h).
// Before this stands field.glsl.

float penumbra_product[64];  // visibility past the parts so far, at the directions
float penumbra_light;        // factor for being inside of parts

void penumbra_cast_begin() {
    penumbra_light = 1.0;
    for (int d = 0; d < 64; ++d) penumbra_product[d] = 1.0;
}

// Multiplies by what a share of part i leaves visible. `axes` are the columns of the receiver's frame. Returns whether
// the part counts.
bool penumbra_cast_part(int i, float share, vec3 position, mat3 axes) {
    PenumbraSight sight;
    if (!penumbra_field_height(i, position, axes[2], sight) || sight.height <= -1.0) return false;
    penumbra_field_blocked(i, position, sight);
    if (!sight.counts) return false;
    penumbra_light *= 1.0 - sight.inside * share;
    if (sight.weight == 0.0) return true;
    mat3 into_part = penumbra_into_part(i);
    penumbra_far_turn(into_part * axes[0], into_part * axes[1], into_part * axes[2]);
    float sure = sight.height * sight.height, counted = share * sight.weight, factor[64];
    penumbra_far_mirror(counted * (1.0 - sure), sight.height > 0.0 ? 2.0 * counted * sure : 0.0);
    penumbra_even[0] += penumbra_root_of_sphere;
    penumbra_far_values(factor);
    for (int d = 0; d < 64; ++d) penumbra_product[d] *= factor[d];
    return true;
}

// Writes the product of all parts where any counts, and free sight elsewhere.
void penumbra_cast_end(bool seen, out float mirrored[21]) {
    for (int i = 0; i < 21; ++i) mirrored[i] = 0.0;
    mirrored[0] = penumbra_root_of_sphere;
    if (!seen) return;
    // A crowd has many factors, each of which rings above 1 somewhere.
    for (int d = 0; d < 64; ++d) penumbra_product[d] = min(penumbra_product[d], penumbra_most);
    penumbra_far_from_values(penumbra_product);
    for (int i = 0; i < 21; ++i) mirrored[i] = penumbra_light * penumbra_even[i];
}

// Writes the visibility past all parts i < part_count but those with left_out.x <= i < left_out.y, mirrored at the
// horizon: the 21 SH of order 6 with even l+m, in the frame whose axes are the rows of local_from_scene. The last one
// is the normal. Returns false where no part counts and everything is visible.
bool penumbra_cast_fields(int part_count, ivec2 left_out, vec3 position, mat3 local_from_scene,
                          out float mirrored[21]) {
    mat3 axes = transpose(local_from_scene);
    bool seen = false;
    penumbra_cast_begin();
    for (int i = 0; i < part_count; ++i)
        if ((i < left_out.x || i >= left_out.y) && penumbra_cast_part(i, 1.0, position, axes)) seen = true;
    penumbra_cast_end(seen, mirrored);
    return seen;
}

// Multiplies what some casters leave visible by what others do, both mirrored.
void penumbra_cast_combine(inout float mirrored[21], float others[21]) {
    float values[64], factor[64];
    for (int i = 0; i < 21; ++i) penumbra_even[i] = mirrored[i];
    penumbra_far_values(values);
    for (int i = 0; i < 21; ++i) penumbra_even[i] = others[i];
    penumbra_far_values(factor);
    for (int d = 0; d < 64; ++d) values[d] *= factor[d];
    penumbra_far_from_values(values);
    for (int i = 0; i < 21; ++i) mirrored[i] = penumbra_even[i];
}
