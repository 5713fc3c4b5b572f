#pragma once
// The ways in which the shadow of others joins what everyone sees of itself, to compare them in the window. All but
// the product are slow: they run on the CPU, where everyone keeps own numbers and knows V_c over the whole sphere.
#include "player/view/view_scene.h"

namespace penumbra {

// Returns the way that is shown: only pictures that have shadows of others have another one than the product.
CastMode shownCastMode(const ViewState& state);
// Goes to the next way that the scene has, or to the one before, round the ends.
void chooseNextCastMode(ViewState& state, const ViewContents& contents, bool back);
bool hasCastMode(const ViewContents& contents, CastMode mode);

// Returns which shadows the numbers of characters have in this way: those of others join later.
Shadows shadowsOfNumbers(Shadows shadows, CastMode mode);

// Brings V_c of a character's vertices to the pose and the casters of now. `mode` is not kProduct.
void needOthers(Scene& scene, std::size_t character, CastMode mode, int threads);

// Returns what the vertices show by their numbers, or by those of the truth, and by V_c, which needOthers() has brought
// up to date. The channel is shaded, ambient or error.
std::vector<Vec3> joinedValues(Scene& scene, std::size_t character, const ViewState& state, bool truth, int threads);

// Returns E of the ground, in x, or its radiance under `light`, which may be null, past V_c of all casters.
std::vector<Vec3> joinedGround(const Scene& scene, const GroundVertices& ground, CastMode mode, const LightView* light,
                               const Mat3& light_rotation, int threads);

}  // namespace penumbra
