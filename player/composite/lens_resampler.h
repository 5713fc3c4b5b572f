#pragma once
// Bends a picture that was drawn by a plain pinhole as a camera's lens would have.
#include <vector>

#include "player/composite/characters_drawing.h"
#include "sh/pinhole_camera.h"

namespace penumbra {

class LensResampler {
public:
    explicit LensResampler(const PinholeCamera& camera);
    // The camera without a lens whose picture holds all that the camera sees, and is sharper than it. It is the camera
    // itself where that has no lens.
    const PinholeCamera& plain() const { return plain_; }
    // Writes the picture of the camera, of a part that was drawn of the plain one. Each of its pixels is the mean of 2
    // x 2 places that lie in it; without a lens it is the pixel that was drawn.
    void resample(const DrawnPart& drawn, int threads, Image& out) const;

private:
    PinholeCamera camera_, plain_;
    std::vector<float> places_;  // [height, width, 4, 2] in the plain picture; empty: there is no lens
};

}  // namespace penumbra
