#pragma once
// What the vertices of a scene see past its casters.
#include "player/frame/frame_values.h"
#include "player/scene/posed_scene.h"
#include "player/scene/received_light.h"

namespace penumbra {

// Multiplies numbers of all vertices of a character, in the convention of its model [V, stride], by what the chosen
// casters leave visible. `vertices` are in the scene. Returns whether any of them sees one; without, the numbers stay
// the very ones that they were. Light that bounces, `indirect` [V, kIndirectStride] or empty, is multiplied by the
// share of a white sky that is left (docs/formulas.md, section 15).
bool castOnCoefficients(const CastShadow& cast, CasterChoice choice, const Evaluator& character,
                        const CastReceivers& vertices, int threads, std::span<float> coefficients,
                        std::span<float> indirect = {});

// Writes the vertices of a member in the scene. Their numbers stay what they are.
void skinMember(const SceneMember& member, int threads, FrameVertices& vertices);
// Sizes `vertices`, which may hold those of a frame before. Computes the vertices of a member in the scene, with its
// own numbers alone.
void ownVertices(const SceneMember& member, int threads, FrameVertices& vertices);

// Who takes light from a character.
struct OthersAround {
    const CastShadow& cast;
    CasterChoice choice;        // all but the character itself
    const SceneField* heights;  // of the ground; null where it is level or missing
    bool level_ground;          // there is one that casts
};
// Numbers of the vertices of a character, in the convention of its model, and light that bounces to them (or empty).
struct CastCoefficients {
    std::span<float> coefficients, indirect;
};
// Multiplies numbers of a character whose vertices stand in the scene by what all others and the ground leave visible.
// Writes what each of them takes from a white sky, unless `hidden` is null.
void castOthers(const OthersAround& others, const Evaluator& character, const CastReceivers& vertices, int threads,
                CastCoefficients coefficients, HiddenSky* hidden = nullptr);
// The same for a member of a scene.
void castOthers(const PosedScene& scene, const SceneMember& member, int threads, FrameVertices& vertices,
                HiddenSky* hidden = nullptr);

// Multiplies the numbers of vertices [V, stride] that stand on a level ground by what it leaves visible.
void castGround(const ModelView& model, const CastReceivers& vertices, int threads, std::span<float> coefficients);

// Sizes `vertices`, which may hold those of a frame before. Computes the vertices of a member in the scene, with
// numbers past its own parts and all other casters. Where nobody casts on it, these are the very numbers that it has
// alone.
void memberVertices(const PosedScene& scene, std::size_t member, int threads, FrameVertices& vertices,
                    HiddenSky* hidden = nullptr);
FrameVertices memberVertices(const PosedScene& scene, std::size_t member, int threads);

}  // namespace penumbra
