#pragma once
// The maps of a sun: one that holds everyone who casts, or fine ones around the members of a scene inside of coarser
// ones around them, as far as a wide ground goes.
#include "runtime/sun/sun_frame.h"

namespace penumbra {

constexpr int kMaxSunGroups = 6;  // groups of members, each with the finest map that it can have
constexpr int kMaxSunRings = 3;   // maps around all members, between these and the whole
constexpr int kMaxNestedMaps = kMaxSunGroups + kMaxSunRings + 1;

struct NestedSunMap {
    SunFrame frame;
    float border = 0;                    // texels along its edges over which the next maps take over; 0: it is the last
    std::vector<std::uint32_t> members;  // casters in the map, as indices into those of SunCasters
    bool whole_ground = true;            // all triangles of the ground cast in it
    std::vector<std::uint32_t> ground;   // else the ones that reach into it, [3 T]

    bool isGroundAlone() const { return members.empty(); }
    // How much of a point's light this map tells; the maps after it tell the rest.
    float weight(Vec3 point) const;
};

struct SunNest {
    std::vector<NestedSunMap> maps;  // a point takes the first ones that hold it; the last holds every point
};

// Chooses the maps, of `size` texels a side. There is one, that of fitSunFrame(), unless a ground casts, the least
// member spans fewer than 128 of its texels, and maps around the members have texels of at most half the side. `nest`
// may hold that of a frame before. It has no maps where fitSunFrame() gives an empty frame.
void fitSunNest(const SunCasters& casters, Vec3 direction, float radius, int size, SunNest& nest);

}  // namespace penumbra
