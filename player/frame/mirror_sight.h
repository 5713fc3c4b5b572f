#pragma once
// How much of what a mirror reflects to the eye its surface sees (Nowrouzezahrai 2011 eq. 21).
#include <vector>

#include "player/frame/frame_values.h"
#include "player/frame/lobe_table.h"

namespace penumbra {

// Returns V at the direction that each vertex mirrors towards `eye`, from its numbers, clamped to [0, 1].
std::vector<float> mirrorSight(const Convention& convention, int stride, const FrameVertices& vertices, Vec3 eye,
                               int threads);

// Takes mirrors out of what vertices show, because the shader reflects the light's picture in them, which SH blur.
// Returns the sight of all vertices, and nothing where no vertex is of a mirror. `lobes` and `values` are [V].
std::vector<float> takeMirrorsOut(const Convention& convention, int stride, const FrameVertices& vertices, Vec3 eye,
                                  int threads, const LobeTable& table, std::span<const LobeRange> lobes,
                                  std::span<Vec3> values);

}  // namespace penumbra
