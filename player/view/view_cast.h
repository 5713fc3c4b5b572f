#pragma once
// Who casts on whom in the window.
#include "player/scene/scene_receivers.h"
#include "player/view/view_scene.h"

namespace penumbra {

// Makes the casters of an opened scene: every character that has fields or spheres, unless the file says otherwise.
// Throws Unsupported for too many.
void makeCasters(Scene& scene);

// Tells the casters how a character stands, after it was posed or moved.
void takeOver(Scene& scene, Character& character);

// Makes of a character's own numbers, of the model or of the truth, those that are shown: with or without the shadow of
// itself and of the others. Without others in reach they stay the very ones that they were.
// Writes what others and the ground take from a white sky, unless `hidden` is null.
void applyShadows(const Scene& scene, std::size_t character, const CoefficientsKey& key, int threads,
                  CastCoefficients coefficients, HiddenSky* hidden = nullptr);

// Takes a ground with heights to the moment that is shown.
void poseField(Scene& scene, const ViewState& state);

// Computes what the ground shows, unless that is there already. Returns whether it did.
bool updateGround(Scene& scene, const ViewState& state, const GroundKey& key, int threads);

// Returns what vertices show by the model or the truth where shadows of others join in another way than as a product
// (player/papers/cast_way.h). The channel is shaded, ambient or error.
std::vector<Vec3> joinedValues(Scene& scene, std::size_t character, const ViewState& state, const CharacterKey& key,
                               bool truth, int threads);

}  // namespace penumbra
