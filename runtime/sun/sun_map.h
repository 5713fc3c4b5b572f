#pragma once
// The depth map of a sun on the CPU: which points the sun reaches, past all casters. player/shaders/sun.glsl has the
// same rules.
#include <vector>

#include "runtime/sun/sun_nest.h"

namespace penumbra {

// The receiver is this much nearer to the sun than it is, in texels of depth: kSunBias + kSunSlopeBias tan(angle
// between normal and sun). Flat receivers need less, since they compare with their plane; the rest is for normals that
// are interpolated over the facets of a mesh.
constexpr float kSunBias = 0.5f, kSunSlopeBias = 0.5f;
constexpr float kSunMinCosine = 0.02f;  // slopes are limited to those of this cosine
// The box that filters as a disc of the sun does has this side, in radii of the disc (docs/formulas.md, section 12).
constexpr float kSunBox = 1.71f;
// Most cells that a box has along a side, without those at its border: of the filter, and of a search.
constexpr int kSunCells = 8, kSunSearchCells = 4;
constexpr int kSunPasses = 3;  // boxes that a point looks through: search, search again, filter

class SunMap {
public:
    // Takes a new frame and forgets all depths. Allocates only when the size grows.
    void begin(const SunFrame& frame);
    // Draws the casters into rows `first` to `last` - 1. Several threads may draw different rows at once.
    void draw(std::span<const SunCaster> casters, int first, int last);
    void draw(std::span<const SunCaster> casters) { draw(casters, 0, frame_.size); }

    // Share of the sun that reaches the point, 0 to 1. `normal` is a unit vector. It is 0 where the surface faces away
    // from the sun, and where the position or the normal is not finite.
    float visibility(Vec3 position, Vec3 normal) const;

    const SunFrame& frame() const { return frame_; }
    std::span<const float> depths() const { return depths_; }  // [size, size], depth / range; 1: nothing

private:
    SunFrame frame_;
    std::vector<float> depths_;
};

// All maps of a sun.
class SunMaps {
public:
    // Takes the maps of fitSunNest() and forgets all depths. Allocates only where maps grow or there are several.
    void begin(const SunCasters& casters, Vec3 direction, float radius, int size = kSunMapSize);
    // Draws the casters of begin() into one of `bands` parts of every map. Several threads may draw
    // different parts at once.
    void draw(const SunCasters& casters, int band = 0, int bands = 1);

    // Fraction of the sun visible from a point, 0 to 1, as in SunMap::visibility(). Without maps every point is lit.
    float visibility(Vec3 position, Vec3 normal) const;

    const SunNest& nest() const { return nest_; }
    std::span<const SunMap> maps() const { return maps_; }

private:
    SunNest nest_;
    std::vector<SunMap> maps_;
};

}  // namespace penumbra
