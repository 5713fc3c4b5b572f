#pragma once
// Finds the response of a camera from a bracket (Debevec and Malik 1997).
#include <array>

#include "fit/camera/bracket_pictures.h"
#include "sh/camera_response.h"

namespace penumbra {

// How well one channel was found.
struct ResponseQuality {
    int samples = 0;                // places of the picture that were compared
    int lowest = 255, highest = 0;  // codes that they show; the curve is extrapolated beyond
    // rms of ln(light) of a place between one picture and the mean of all, weighted: .03 is 3%
    double rms = 0;
};

struct FoundResponse {
    // Each channel has a scale of its own, which no bracket tells: 1 at code 255.
    CameraResponse response;
    std::array<ResponseQuality, 3> channels;
    double flatness = 0;  // largest standard deviation of the codes around a sample
};

// Throws InvalidInput where too few places show usable codes in two pictures: all is clipped or dark, the exposures lie
// too far apart, or nothing is flat.
FoundResponse findResponse(const BracketPictures& bracket);

}  // namespace penumbra
