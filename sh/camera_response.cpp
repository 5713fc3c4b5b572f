#include "sh/camera_response.h"

#include <algorithm>
#include <cmath>

namespace penumbra {

namespace {

// The inverses of the transfer functions of IEC 61966-2-1 and ITU-R BT.709 item 1.2.
double fromSrgb(double v) { return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4); }
double fromRec709(double v) { return v < 0.081 ? v / 4.5 : std::pow((v + 0.099) / 1.099, 1 / 0.45); }
double fromLinear(double v) { return v; }

}  // namespace

std::optional<CameraResponse> knownResponse(std::string_view name) {
    double (*curve)(double) = name == "srgb"     ? fromSrgb
                              : name == "linear" ? fromLinear
                              : name == "rec709" ? fromRec709
                                                 : nullptr;
    if (!curve) return std::nullopt;
    CameraResponse response;
    for (std::array<float, 256>& channel : response.exposure)
        for (std::size_t code = 0; code < 256; ++code) channel[code] = float(curve(double(code) / 255));
    return response;
}

float exposureOf(const CameraResponse& response, int channel, float code) {
    const std::array<float, 256>& curve = response.exposure[std::size_t(channel)];
    const float at = std::clamp(code, 0.0f, 255.0f);
    const std::size_t low = std::min(std::size_t(at), std::size_t(254));
    return curve[low] + (at - float(low)) * (curve[low + 1] - curve[low]);
}

float codeOf(const CameraResponse& response, int channel, float exposure) {
    const std::array<float, 256>& curve = response.exposure[std::size_t(channel)];
    const auto above = std::upper_bound(curve.begin(), curve.end(), exposure);
    if (above == curve.begin()) return 0;
    if (above == curve.end()) return 255;
    const float low = *(above - 1);
    return float(above - curve.begin() - 1) + (exposure - low) / (*above - low);
}

}  // namespace penumbra
