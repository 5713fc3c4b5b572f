#include "player/view/light_blend.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "formats/common/fp16.h"
#include "formats/image/image_file.h"
#include "sh/angles.h"

namespace penumbra {

namespace {

// A sun that is found is that of a light where it is nearer than kSame, and one of its own beyond kOther.
constexpr double kSame = 5 * kDegree, kOther = 15 * kDegree;
constexpr double kSettled = 8;  // time constants, after which 0.03% of a difference is left

double smoothStep(double low, double high, double x) {
    const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

template <class T>
std::vector<T> mixed(const std::vector<T>& a, const std::vector<T>& b, float t) {
    std::vector<T> out(a.size());
    for (std::size_t i = 0; i < a.size(); ++i) out[i] = a[i] * (1 - t) + b[i] * t;
    return out;
}

// The suns of both, each with its share.
std::vector<Sun> sharedSuns(const std::vector<Sun>& a, const std::vector<Sun>& b, float t) {
    std::vector<Sun> out;
    for (const auto& [suns, share] : {std::pair(&a, 1 - t), std::pair(&b, t)})
        for (Sun sun : *suns) {
            sun.irradiance = sun.irradiance * share;
            out.push_back(sun);
        }
    std::ranges::stable_sort(out, std::greater(), [](const Sun& sun) { return luminance(sun.irradiance); });
    if (out.size() > kMaxSuns) out.resize(kMaxSuns);
    return out;
}

// The nearest texels of the sky.
std::vector<Vec3> resampled(const SkyPicture& sky, int height) {
    std::vector<Vec3> out;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < 2 * height; ++x) {
            const int row = (2 * y + 1) * sky.height / (2 * height), column = (2 * x + 1) * sky.width / (4 * height);
            const auto& texel = sky.texels[std::size_t(row * sky.width + column)];
            out.push_back({halfToFloat(texel[0]), halfToFloat(texel[1]), halfToFloat(texel[2])});
        }
    return out;
}

}  // namespace

LightBlend::LightBlend(const LightFade& fade) : fade_(fade), filter_(fade.sun_time) {
    if (!(fade.seconds >= 0) || !std::isfinite(fade.seconds))
        throw std::invalid_argument("a light fades in a finite number of seconds, 0 or more");
}

double LightBlend::part() const { return active_ ? std::min(1.0, elapsed_ / fade_.seconds) : 1; }

// Bands that the light lacks are 0, and suns have no part in them.
LightBlend::Moment LightBlend::momentOf(const LightView& light) const {
    const SkyPicture sky = skyPicture(light);
    Moment out{{light.sh.begin(), light.sh.end()},
               {light.window.begin(), light.window.end()},
               {light.suns.begin(), light.suns.end()},
               resampled(sky, kSkyHeight),
               sky.suns};
    out.sh.resize(std::size_t(3 * coefficientCount(order_)));
    if (out.window.empty()) out.window.assign(std::size_t(light.order), 1.0f);
    out.window.resize(std::size_t(order_));
    return out;
}

void LightBlend::begin(const LightView& from, const LightView& to) {
    if (active_) {
        from_ = now_;
    } else {
        from_ = momentOf(from);
        filter_.reset();
        std::array<SunD, kMaxSuns> suns;
        for (std::size_t i = 0; i < from_.suns.size(); ++i)
            suns[i] = {toDouble(from_.suns[i].direction), toDouble(from_.suns[i].irradiance), from_.suns[i].radius};
        filter_.update(std::span(suns).first(from_.suns.size()), kMaxSuns, 0);
    }
    to_ = momentOf(to);
    most_ = std::min<std::size_t>(kMaxSuns, from_.suns.size() + to_.suns.size());
    factor_.reset();
    if (most_ > 0) factor_.emplace(order_, int(most_));
    active_ = true;
    elapsed_ = 0;
}

void LightBlend::jump(std::size_t wanted) {
    if (active_) ++version_;
    active_ = false;
    wanted_ = wanted;
}

void LightBlend::advance(std::span<const LightView> lights, int order, std::size_t wanted, double seconds) {
    if (!wanted_ || fade_.seconds == 0 || (!active_ && wanted_ == wanted)) return jump(wanted);
    if (wanted_ != wanted) {
        order_ = order;
        begin(lights[*wanted_], lights[wanted]);
        from_light_ = *wanted_;
        wanted_ = wanted;
    }
    step(seconds);
}

void LightBlend::mixSky(float t) {
    now_.sky = mixed(from_.sky, to_.sky, t);
    now_.discs = sharedSuns(from_.discs, to_.discs, t);
    sky_.width = 2 * kSkyHeight;
    sky_.height = kSkyHeight;
    sky_.suns = now_.discs;
    sky_.texels.clear();
    for (const Vec3& rgb : now_.sky)
        sky_.texels.push_back({floatToHalf(rgb.x), floatToHalf(rgb.y), floatToHalf(rgb.z), 0});
}

// Suns found in SH are off by some degrees and have no radius. Near suns that the lights have stored, this takes
// theirs.
SunD LightBlend::nearStored(SunD sun) const {
    Vec3d direction;
    double radius = 0, sum = 0, same = 0;
    for (const auto& [moment, share] : {std::pair(&from_, 1 - part()), std::pair(&to_, part())})
        for (const Sun& stored : moment->suns) {
            const Vec3d toward = toDouble(stored.direction);
            const double angle = std::acos(std::clamp(dot(toward, sun.direction), -1.0, 1.0));
            const double near = 1 - smoothStep(kSame, kOther, angle);
            const double weight = near * share * luminance(toDouble(stored.irradiance));
            direction += weight * toward;
            radius += weight * double(stored.radius);
            sum += weight;
            same = std::max(same, near);
        }
    if (!(sum > 0)) return sun;
    sun.direction = normalized((1 - same) * sun.direction + same / sum * direction);
    sun.radius = same * radius / sum;
    return sun;
}

std::vector<SunD> LightBlend::findSuns() {
    std::vector<SunD> suns;
    if (part() == 1) {
        for (const Sun& sun : to_.suns)
            suns.push_back({toDouble(sun.direction), toDouble(sun.irradiance), double(sun.radius)});
        return suns;
    }
    const std::vector<double> sh(now_.sh.begin(), now_.sh.end());
    const FactoredLight found = factor_->factor(sh);
    for (std::size_t i = 0; i < std::size_t(found.count); ++i)
        if (luminance(found.candidates[i].sun.irradiance) > 0) suns.push_back(nearStored(found.candidates[i].sun));
    return suns;
}

void LightBlend::step(double seconds) {
    elapsed_ += seconds;
    ++version_;
    const double settling = most_ > 0 ? kSettled * fade_.sun_time : 0;
    if (elapsed_ >= fade_.seconds + settling) {
        active_ = false;
        return;
    }
    const auto t = float(part());
    now_.sh = mixed(from_.sh, to_.sh, t);
    now_.window = mixed(from_.window, to_.window, t);
    mixSky(t);
    now_.suns.clear();
    if (most_ == 0) return;
    for (const SunD& sun : filter_.update(findSuns(), kMaxSuns, seconds)) now_.suns.push_back(floatSun(sun));
}

LightView LightBlend::light() const { return {"", order_, now_.sh, {}, now_.suns, now_.window, {}}; }

}  // namespace penumbra
