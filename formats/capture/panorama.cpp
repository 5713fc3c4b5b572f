#include "formats/capture/panorama.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "sh/angles.h"

namespace penumbra {

namespace {

constexpr double kLargeHole = 0.05;    // share of the sphere
constexpr double kRim = 20 * kDegree;  // around smaller holes
constexpr float kSeenEnough = 0.5f;    // weight from which a pixel counts as seen, in pixels
constexpr double kPi = std::numbers::pi;

Vec3d directionOf(const Panorama& p, std::size_t pixel) {
    const std::size_t width = std::size_t(p.width);
    return latLongDirection((double(pixel % width) + 0.5) / p.width, (double(pixel / width) + 0.5) / p.height);
}

double steradiansOf(const Panorama& p, std::size_t pixel) {
    return steradiansOfRow(p, int(pixel / std::size_t(p.width)));
}

// Mean of the seen pixels that `near` accepts, by solid angle.
template <class Accept>
SeenLight meanSeen(const Panorama& p, const std::vector<char>& hole, const Accept& accept) {
    Vec3d sum, uncertain;
    double area = 0;
    for (std::size_t i = 0; i < p.radiance.size(); ++i) {
        if (hole[i] || !accept(i)) continue;
        const double steradians = steradiansOf(p, i);
        sum += steradians * toDouble(p.radiance[i]);
        uncertain += steradians * toDouble(p.uncertain[i]);
        area += steradians;
    }
    if (!(area > 0)) return {};
    return {toFloat(sum / area), toFloat(uncertain / area), 0, float(area)};
}

// Lists the pixels of the hole that `start` belongs to. Pixels touch at their sides; those of the first and the last
// row all touch at the pole.
std::vector<std::size_t> holeAt(const Panorama& p, const std::vector<char>& hole, std::size_t start,
                                std::vector<char>& done) {
    const std::size_t width = std::size_t(p.width), height = std::size_t(p.height);
    std::vector<std::size_t> found{start};
    done[start] = 1;
    const auto take = [&](std::size_t x, std::size_t y) {
        const std::size_t pixel = y * width + x;
        if (!hole[pixel] || done[pixel]) return;
        done[pixel] = 1;
        found.push_back(pixel);
    };
    for (std::size_t next = 0; next < found.size(); ++next) {
        const std::size_t x = found[next] % width, y = found[next] / width;
        take((x + 1) % width, y);
        take((x + width - 1) % width, y);
        if (y > 0) take(x, y - 1);
        if (y + 1 < height) take(x, y + 1);
        if (y == 0 || y + 1 == height) take((x + width / 2) % width, y);
    }
    return found;
}

struct Hole {
    std::vector<std::size_t> pixels;
    double steradians = 0;
};

// Parts of the sphere that fill each other's holes.
enum class Side { kAny, kSky, kGround };

bool liesOn(Side side, Vec3d direction) { return side == Side::kAny || (direction.y > 0) == (side == Side::kSky); }

// Returns what fills the part of a hole that lies on a side.
SeenLight fillingOf(const Panorama& p, const std::vector<char>& hole, const Hole& one, Side side) {
    if (one.steradians < kLargeHole * 4 * kPi) {
        Vec3d middle;
        for (std::size_t i : one.pixels) middle += steradiansOf(p, i) * directionOf(p, i);
        middle = normalized(middle);
        double least = 1;  // cosine from the middle to the border
        for (std::size_t i : one.pixels) least = std::min(least, dot(middle, directionOf(p, i)));
        const double rim = std::cos(std::min(kPi, std::acos(std::clamp(least, -1.0, 1.0)) + kRim));
        const SeenLight mean = meanSeen(p, hole, [&](std::size_t i) {
            const Vec3d direction = directionOf(p, i);
            return dot(middle, direction) >= rim && liesOn(side, direction);
        });
        if (mean.weight > 0) return mean;
    }
    return meanSeen(p, hole, [](std::size_t) { return true; });
}

template <class Field>
Vec3d integrate(const Panorama& p, const std::vector<Field>& field, Vec3d normal) {
    Vec3d sum;
    for (std::size_t i = 0; i < field.size(); ++i)
        sum += toDouble(field[i]) * (steradiansOf(p, i) * std::max(0.0, dot(normal, directionOf(p, i))));
    return sum;
}

}  // namespace

Panorama makePanorama(int width) {
    assert(width >= 2 && width % 2 == 0);
    Panorama p;
    p.width = width;
    p.height = width / 2;
    const std::size_t pixels = std::size_t(p.width) * std::size_t(p.height);
    p.radiance.resize(pixels);
    p.uncertain.resize(pixels);
    p.seen.resize(pixels);
    p.dark.resize(pixels);
    return p;
}

double steradiansOfRow(const Panorama& p, int row) {
    return 2 * kPi / p.width * (std::cos(kPi * row / p.height) - std::cos(kPi * (row + 1) / p.height));
}

HoleReport fillHoles(Panorama& p, Ground ground) {
    std::vector<char> hole(p.seen.size()), done(p.seen.size());
    for (std::size_t i = 0; i < hole.size(); ++i) hole[i] = !(p.seen[i] >= kSeenEnough);
    if (std::ranges::all_of(hole, [](char c) { return c != 0; })) throw std::invalid_argument("nothing is seen");
    HoleReport report;
    std::vector<Hole> holes;
    for (std::size_t i = 0; i < hole.size(); ++i) {
        if (!hole[i] || done[i]) continue;
        Hole one{holeAt(p, hole, i, done), 0};
        for (std::size_t pixel : one.pixels) one.steradians += steradiansOf(p, pixel);
        const double share = one.steradians / (4 * kPi);
        report.share += share;
        report.largest = std::max(report.largest, share);
        holes.push_back(std::move(one));
    }
    report.holes = int(holes.size());
    for (const Hole& one : holes) {
        const std::array<SeenLight, 2> means{
            fillingOf(p, hole, one, ground == Ground::kLevel ? Side::kGround : Side::kAny),
            fillingOf(p, hole, one, ground == Ground::kLevel ? Side::kSky : Side::kAny)};
        for (std::size_t pixel : one.pixels) {
            const SeenLight& mean = means[directionOf(p, pixel).y > 0];
            p.radiance[pixel] = mean.radiance;
            p.uncertain[pixel] = mean.uncertain;
        }
    }
    return report;
}

Vec3d irradianceOn(const Panorama& p, Vec3d normal) { return integrate(p, p.radiance, normal); }
Vec3d uncertainIrradianceOn(const Panorama& p, Vec3d normal) { return integrate(p, p.uncertain, normal); }

RaiseReport raiseClipped(Panorama& p, Vec3d normal, Vec3d wanted) {
    RaiseReport report;
    report.wanted = wanted;
    report.found = irradianceOn(p, normal);
    const Vec3d clipped = uncertainIrradianceOn(p, normal);
    for (int c = 0; c < 3; ++c) {
        const double missing = wanted[c] - report.found[c];
        if (!(missing > 0)) continue;
        if (clipped[c] > 0)
            report.factor[c] = 1 + missing / clipped[c];
        else
            report.nothing_to_raise = true;
    }
    for (std::size_t i = 0; i < p.radiance.size(); ++i)
        for (int c = 0; c < 3; ++c) {
            p.radiance[i][c] += float((report.factor[c] - 1) * double(p.uncertain[i][c]));
            p.uncertain[i][c] *= float(report.factor[c]);
        }
    return report;
}

}  // namespace penumbra
