#pragma once
// Places of a bracket that tell its camera's response.
#include <array>
#include <vector>

#include "fit/camera/bracket_pictures.h"

namespace penumbra {

// One place of the picture in one channel.
struct ResponseSample {
    std::vector<float> codes;  // [K] mean code around the place; below 0 where this picture is of no use here
};

struct ResponseSamples {
    std::array<std::vector<ResponseSample>, 3> channels;
    double flatness = 0;
    double clipped = 0, dark = 0;  // share of the codes of all pictures
};

// Chooses up to `most` places a channel, spread over all brightnesses. A place is of use in a picture where the codes
// around it (5 x 5) are neither clipped nor noise and lie within `flatness` of their mean, and it is chosen where two
// pictures show it. Starts with a flatness of 4 codes and doubles it twice where fewer than 200 places are found.
ResponseSamples chooseResponseSamples(const BracketPictures& bracket, int most);

}  // namespace penumbra
