#pragma once
// The response of a camera: which code (0..255) a channel gives to light. It is stored the other way round, as the
// light of every code.
#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "sh/vec3.h"

namespace penumbra {

// exposure[channel][code] is radiance times exposure, as a part of that which saturates (code 255 has 1). It never
// falls as the code grows. Channels are red, green, blue.
struct CameraResponse {
    std::array<std::array<float, 256>, 3> exposure{};
};

// Codes from here on are clipped, and codes up to kMinCode are noise: a picture says nothing of the light there but
// that it is at least, or at most, so much.
constexpr int kMaxCode = 250, kMinCode = 3;

// Returns a known curve: "srgb" (IEC 61966-2-1), "linear" or "rec709" (ITU-R BT.709). None for any other name.
std::optional<CameraResponse> knownResponse(std::string_view name);

// Returns the light of a code between 0 and 255, by linear interpolation, and the code of some light, its inverse,
// clamped to 0..255 and not rounded.
float exposureOf(const CameraResponse& response, int channel, float code);
float codeOf(const CameraResponse& response, int channel, float exposure);

}  // namespace penumbra
