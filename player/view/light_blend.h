#pragma once
// One light becomes another. Between the two the light is L = (1 - t) A + t B, whose suns are found anew at every
// moment and smoothed over time. It uses no GL.
#include <optional>

#include "player/frame/sky_picture.h"
#include "sh/light/sun_smoothing.h"

namespace penumbra {

struct LightFade {
    double seconds = 0.5;   // from one light to the next; 0: at once
    double sun_time = 0.1;  // time constant of SunSmoothing, in seconds
};

class LightBlend {
public:
    // Throws std::invalid_argument for seconds that are negative or not finite.
    explicit LightBlend(const LightFade& fade = {});

    // Goes on by `seconds` towards `wanted`, one of `lights`, none of which has more than `order` bands. The first call
    // takes the light as it is. So does every call where `fades` is false. Another light in the middle of a blend
    // begins a new one where this one stands.
    void advance(std::span<const LightView> lights, int order, std::size_t wanted, double seconds);
    // Shows `wanted` at once.
    void jump(std::size_t wanted);

    bool active() const { return active_; }             // else the light is the one that was wanted last
    double part() const;                                // t, of the way to the light that is wanted
    std::size_t from() const { return from_light_; }    // the light that was wanted before
    bool hasSuns() const { return most_ > 0; }          // one of the two lights has
    std::uint64_t version() const { return version_; }  // increases when the light changes and at the end
    // While active: the light, whose suns are the smoothed ones, and what it looks like. They are valid until the next
    // advance(). The sky draws the suns of both lights, because both pictures were stored without suns.
    LightView light() const;
    const SkyPicture& sky() const { return sky_; }

private:
    static constexpr int kSkyHeight = 128;
    struct Moment {
        std::vector<float> sh, window;  // [order^2, 3], [order]
        std::vector<Sun> suns;
        std::vector<Vec3> sky;   // [kSkyHeight, 2 kSkyHeight]
        std::vector<Sun> discs;  // suns that the sky lacks
    };
    LightFade fade_;
    SunSmoothing filter_;
    std::optional<LightFactor> factor_;  // for `most_` suns
    int order_ = 1;
    std::size_t most_ = 0;  // suns
    std::optional<std::size_t> wanted_;
    std::size_t from_light_ = 0;
    Moment from_, to_, now_;
    SkyPicture sky_;
    bool active_ = false;
    double elapsed_ = 0;
    std::uint64_t version_ = 1;

    Moment momentOf(const LightView& light) const;
    void begin(const LightView& from, const LightView& to);
    void mixSky(float t);
    std::vector<SunD> findSuns();
    SunD nearStored(SunD sun) const;
    void step(double seconds);
};

}  // namespace penumbra
