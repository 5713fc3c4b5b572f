#pragma once
// The suns of a scene's light: where they stand, what the light is without them, and on the CPU whom they reach.
#include <vector>

#include "player/frame/render_options.h"
#include "player/scene/posed_scene.h"
#include "runtime/sun/sun_map.h"

namespace penumbra {

// Returns the suns of the light as it is turned, in the scene.
std::vector<Sun> sunsOf(const LightView& light, const Mat3& rotation);
// Returns the SH of the light without its suns, [n^2, 3].
std::vector<float> remainderOf(const LightView& light);

// Draws the maps of a sun, of `size` texels a side. Different threads draw different rows.
void drawSunMaps(const Sun& sun, const SunCasters& casters, int size, int threads, SunMaps& maps);
// Adds the props that are meshes to those who cast.
void addRealMeshes(const PosedScene& scene, SunCasters& casters);

struct SceneSuns {
    std::vector<Sun> suns;         // in the scene; empty: all light is SH
    std::vector<float> remainder;  // SH of the light without them
    std::vector<SunMaps> maps;     // one for each sun
};
// Draws the suns' maps of `map_size` texels a side, in which everyone in the scene casts who is
// not told to cast nothing. There are suns where `choice`
// lets them shine: kAuto where the light has some and others cast by products, as the other ways to join have no suns.
// Throws UsageError where kOn asks for suns that cannot be.
SceneSuns sceneSuns(const PosedScene& scene, SunChoice choice, int map_size, int threads);

}  // namespace penumbra
