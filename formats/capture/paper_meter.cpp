#include "formats/capture/paper_meter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "sh/angles.h"

namespace penumbra {

namespace {

constexpr int kPlacesPerSide = 32;
constexpr double kMinMargin = 3;             // pixels
constexpr double kMinHeight = 0.2588190451;  // sine of the least angle at which paper is looked at, 15 degrees

// Places in the middle of the margin, on the four sides of the black square.
std::vector<Vec3d> marginPlaces(const PaperTag& tag) {
    const double half = tag.side / 2, away = half + tag.side / tag.modules / 2;
    std::vector<Vec3d> places;
    for (int i = 0; i < kPlacesPerSide; ++i) {
        const double along = half * ((2 * i + 1.0) / kPlacesPerSide - 1);
        places.insert(places.end(), {{along, away, 0}, {along, -away, 0}, {away, along, 0}, {-away, along, 0}});
    }
    return places;
}

// Whether the margin is wide enough in the picture, where it can be seen at all.
bool wideEnough(const PosedPicture& shot, const PaperTag& tag) {
    const Vec3d place = shot.pose.place();
    if (!(place.z >= kMinHeight * length(place))) return false;
    const double half = tag.side / 2, width = tag.side / tag.modules;
    double least = 1e30;
    for (const Vec3d& side : {Vec3d{1, 0, 0}, Vec3d{-1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, -1, 0}}) {
        const std::optional<PixelPoint> inner = pixelOfPlace(shot, half * side);
        const std::optional<PixelPoint> outer = pixelOfPlace(shot, (half + width) * side);
        if (inner && outer) least = std::min(least, std::hypot(inner->x - outer->x, inner->y - outer->y));
    }
    return least < 1e30 && least >= kMinMargin;
}

double medianOf(std::vector<double>& values) {
    const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

}  // namespace

PaperMeasure measurePaper(std::span<const PosedPicture> shots, const PaperTag& tag) {
    PaperMeasure out;
    std::array<std::vector<double>, 3> channels;
    const std::vector<Vec3d> places = marginPlaces(tag);
    for (const PosedPicture& shot : shots) {
        if (!wideEnough(shot, tag)) continue;
        const std::size_t before = out.places;
        for (const Vec3d& place : places) {
            const std::optional<PixelPoint> pixel = pixelOfPlace(shot, place);
            if (!pixel) continue;
            ++out.places;
            const SeenLight seen = lightAt(shot.picture, *pixel);
            const bool clipped = seen.uncertain.x > 0 || seen.uncertain.y > 0 || seen.uncertain.z > 0;
            out.clipped += clipped;
            if (clipped || seen.dark > 0) continue;
            for (std::size_t c = 0; c < 3; ++c) channels[c].push_back(double(seen.radiance[int(c)]));
        }
        out.pictures += out.places > before;
    }
    if (channels[0].empty()) {
        out.clipped = out.places;
        return out;
    }
    out.radiance = {medianOf(channels[0]), medianOf(channels[1]), medianOf(channels[2])};
    return out;
}

}  // namespace penumbra
