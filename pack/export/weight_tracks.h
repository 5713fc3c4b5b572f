#pragma once
// Weights of morph targets over time, as channels of glTF have them.
#include <cstdint>
#include <span>
#include <vector>

namespace penumbra {

enum class TrackForm : std::uint8_t { kStep, kLinear, kCubic };

// M weights at each key; kCubic: three times as many (in-tangent, value, out-tangent; glTF 2.0, appendix C.5).
struct WeightTrack {
    TrackForm form = TrackForm::kLinear;
    std::size_t count = 0;      // M
    std::vector<float> times;   // [keys] seconds, ascending
    std::vector<float> values;  // [keys, M], or [keys, 3, M]
};

// Joins the weights that a mesh has already with further ones, which are linear between their keys. The result has the
// keys of both and shows what both showed. Cubic curves stay cubic: a straight line is one, and a cut one two of them.
// A step becomes a line from the last time before it (the nearest float) to it. Before its first key and after its
// last one a track stays as it is there.
WeightTrack joinTracks(const WeightTrack& own, const WeightTrack& linear);

// Returns the track with `more` further weights that are 0.
WeightTrack widened(const WeightTrack& own, std::size_t more);

}  // namespace penumbra
