#pragma once
// What the rigid parts of a posed character leave visible at a point: the product of the visibilities of all parts that
// can be seen from there (docs/formulas.md, section 7), for the vertices of the character itself or for any other
// point. These functions are the plain form; fits and the run time compute the same for many points at once (sh/far/).
#include <cstdint>
#include <span>
#include <vector>

#include "sh/far/part_field.h"
#include "sh/mirrored_product.h"
#include "sh/sh_rotation.h"

namespace penumbra {

constexpr std::size_t kFarCoefficients = std::size_t(mirroredCount(kFieldOrder));
// A part that blocks less than the first share of the sphere does not count, above the second it counts in full.
constexpr float kMinBlocked = 0.001f, kFullBlocked = 0.003f;

// The fields of a character, ready for lookups, and the bone that each moves with.
struct FarFields {
    std::vector<FieldTable> tables;     // [P]
    std::vector<std::uint32_t> joints;  // [P]
    bool floor = false;                 // an infinite floor hides what points down (sh/far/floor_factor.h)
};

// A part in one pose.
struct PosedPart {
    Affine to_part;       // from the model frame to the part's rest frame
    Mat3 turn;            // of the directions: from the rest frame to the model frame
    ShRotation to_model;  // the same for SH functions
    Vec3 center;          // bounding sphere, in the model frame
    float radius = 0;
};
// Poses all parts by the bones [J] of a frame; out.size() == P. A bone whose linear part cannot be inverted has its
// nearest rotation instead. `still` moves the parts without a bone: where the bones go on from the model frame into
// that of a scene, it is the way there.
void poseParts(const FarFields& fields, std::span<const Affine> bones, std::span<PosedPart> out,
               const Affine& still = {});

// Returns for each part those that are more than `local_steps` away from it, ascending. `steps` is [P, P], as in
// PartTable (formats/common/part_table.h).
std::vector<std::vector<std::uint16_t>> farParts(std::span<const std::uint8_t> steps, std::size_t parts,
                                                 int local_steps);

struct Receiver {
    Vec3 position, normal, tangent;  // model frame; the vectors are unit and orthogonal
};

// Writes the far visibility of a receiver in its local frame, mirrored at its horizon, as mirroredCount(kFieldOrder)
// numbers. `parts` are the parts that it sees, by ascending index. Parts that lie below the horizon or block less than
// 0.1% of the sphere do not count; they fade out before that, so that no part appears at once. A receiver inside a part
// is dark.
void farVisibility(const FarFields& fields, std::span<const PosedPart> posed, std::span<const std::uint16_t> parts,
                   const Receiver& receiver, std::span<float> out);

// A near part of a receiver.
struct NearPart {
    std::uint16_t part = 0;
    float gain = 1;
};
// Multiplies a far visibility by near parts, in their order. What a part leaves visible as a far one is 1 + x; with a
// gain it is 1 + gain x. With gains of 1 this goes on with the product as farVisibility() does.
void multiplyByNear(const FarFields& fields, std::span<const PosedPart> posed, std::span<const NearPart> near_parts,
                    const Receiver& receiver, std::span<float> out);

}  // namespace penumbra
