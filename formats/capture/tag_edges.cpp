#include "formats/capture/tag_edges.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "formats/capture/bracket_pose.h"
#include "sh/light/dominant_light.h"

namespace penumbra {

namespace {

constexpr int kProfiles = 48;                      // an edge
constexpr double kAlong = 0.85;                    // part of an edge that is used, away from the corners
constexpr double kMaxReach = 6, kMinReach = 1.5;   // pixels to both sides of an edge
constexpr double kPart = 0.4;                      // in modules, to both sides
constexpr double kStep = 0.25;                     // pixels
constexpr double kMinContrast = 3;                 // white over black
constexpr std::size_t kMinPlaces = kProfiles / 2;  // per edge

struct Line {
    PixelPoint middle;
    double nx = 0, ny = 0;  // unit normal
};

std::optional<double> lightOf(const PosedPicture& shot, double x, double y) {
    if (x < 0 || y < 0 || x > shot.camera.width - 1 || y > shot.camera.height - 1) return std::nullopt;
    const SeenLight seen = lightAt(shot.picture, {x, y});
    if (luminance(seen.uncertain) > 0) return std::nullopt;
    return double(luminance(seen.radiance));
}

// Returns how far beyond `at` the edge lies along the unit vector (dx, dy), which leads from black to white.
std::optional<double> edgeOffset(const PosedPicture& shot, PixelPoint at, PixelPoint d, double reach) {
    std::vector<double> profile;
    const int steps = int(std::floor(reach / kStep));
    for (int i = -steps; i <= steps; ++i) {
        const std::optional<double> light = lightOf(shot, at.x + i * kStep * d.x, at.y + i * kStep * d.y);
        if (!light) return std::nullopt;
        profile.push_back(*light);
    }
    const std::size_t outer = std::max<std::size_t>(1, profile.size() / 6);
    double black = 0, white = 0, sum = 0;
    for (std::size_t i = 0; i < outer; ++i) {
        black += profile[i] / double(outer);
        white += profile[profile.size() - 1 - i] / double(outer);
    }
    if (!(white > kMinContrast * black)) return std::nullopt;
    for (double v : profile) sum += (white - v) / (white - black);
    return (sum - double(profile.size()) / 2) * kStep;
}

// Total least squares.
Line lineThrough(const std::vector<PixelPoint>& places) {
    Line out;
    for (const PixelPoint& p : places) {
        out.middle.x += p.x / double(places.size());
        out.middle.y += p.y / double(places.size());
    }
    double xx = 0, xy = 0, yy = 0;
    for (const PixelPoint& p : places) {
        const double x = p.x - out.middle.x, y = p.y - out.middle.y;
        xx += x * x, xy += x * y, yy += y * y;
    }
    const double angle = std::atan2(2 * xy, xx - yy) / 2;  // direction of the line
    out.nx = -std::sin(angle);
    out.ny = std::cos(angle);
    return out;
}

// A line through the places without those that lie off by more than three times the median distance.
Line robustLine(std::vector<PixelPoint> places) {
    for (int pass = 0; pass < 2; ++pass) {
        const Line line = lineThrough(places);
        const auto distance = [&](const PixelPoint& p) {
            return std::abs((p.x - line.middle.x) * line.nx + (p.y - line.middle.y) * line.ny);
        };
        std::vector<double> all;
        for (const PixelPoint& p : places) all.push_back(distance(p));
        std::ranges::nth_element(all, all.begin() + std::ptrdiff_t(all.size() / 2));
        const double most = 3 * all[all.size() / 2] + 1e-9;
        std::erase_if(places, [&](const PixelPoint& p) { return distance(p) > most; });
    }
    return lineThrough(places);
}

// Lines live where the lens is undone, at z = 1 before the camera.
PixelPoint withoutLens(const PinholeCamera& camera, PixelPoint pixel) {
    const Vec3d ray = viewRay(camera, pixel);
    return {ray.x / ray.z, ray.y / ray.z};
}

// The edge whose outward direction is `out`; `along` is the other axis of the marker's plane.
std::optional<Line> edgeLine(const PosedPicture& shot, const PaperTag& tag, Vec3d out, Vec3d along) {
    const double half = tag.side / 2, module = tag.side / tag.modules;
    std::vector<PixelPoint> places;
    for (int i = 0; i < kProfiles; ++i) {
        const Vec3d place = half * out + (kAlong * half * ((2 * i + 1.0) / kProfiles - 1)) * along;
        const std::optional<PixelPoint> at = pixelOfPlace(shot, place), next = pixelOfPlace(shot, place + module * out);
        const std::optional<PixelPoint> beside = pixelOfPlace(shot, place + 0.1 * module * along);
        if (!at || !next || !beside) continue;
        // Across the edge as the picture has it, not as the paper.
        const double length = std::hypot(beside->x - at->x, beside->y - at->y);
        PixelPoint d{-(beside->y - at->y) / length, (beside->x - at->x) / length};
        double width = (next->x - at->x) * d.x + (next->y - at->y) * d.y;
        if (width < 0) d = {-d.x, -d.y}, width = -width;
        const double reach = std::min(kPart * width, kMaxReach);
        if (reach < kMinReach) continue;
        const std::optional<double> offset = edgeOffset(shot, *at, d, reach);
        if (!offset || std::abs(*offset) > reach / 2) continue;
        places.push_back(withoutLens(shot.camera, {at->x + *offset * d.x, at->y + *offset * d.y}));
    }
    if (places.size() < kMinPlaces) return std::nullopt;
    return robustLine(std::move(places));
}

std::optional<PixelPoint> meetingOf(const Line& a, const Line& b, const PinholeCamera& camera) {
    const double determinant = a.nx * b.ny - a.ny * b.nx;
    if (std::abs(determinant) < 1e-6) return std::nullopt;
    const double p = a.nx * a.middle.x + a.ny * a.middle.y, q = b.nx * b.middle.x + b.ny * b.middle.y;
    return project(camera, {(p * b.ny - q * a.ny) / determinant, (a.nx * q - b.nx * p) / determinant, 1});
}

}  // namespace

std::optional<std::vector<SeenPoint>> cornersByEdges(const PosedPicture& shot, const PaperTag& tag) {
    constexpr Vec3d kX{1, 0, 0}, kY{0, 1, 0};
    const std::array<std::optional<Line>, 4> lines = {edgeLine(shot, tag, -kY, kX), edgeLine(shot, tag, kX, kY),
                                                      edgeLine(shot, tag, kY, kX), edgeLine(shot, tag, -kX, kY)};
    if (!std::ranges::all_of(lines, [](const auto& line) { return line.has_value(); })) return std::nullopt;
    const std::array<Vec3d, 4> corners = tagCorners(tag.side);  // from the lower left one, counter-clockwise
    std::vector<SeenPoint> out;
    for (std::size_t i = 0; i < 4; ++i) {
        const std::optional<PixelPoint> pixel = meetingOf(*lines[(i + 3) % 4], *lines[i], shot.camera);
        if (!pixel) return std::nullopt;
        out.push_back({corners[i], *pixel});
    }
    return out;
}

void refineCorners(const TexturePicture& picture, const PinholeCamera& camera, const CameraResponse& response,
                   std::span<const TagChoice> chosen, std::span<DetectedTag> tags) {
    constexpr std::array<double, 1> kExposure{1};
    PosedPicture shot{{}, camera, {}};
    for (DetectedTag& tag : tags) {
        const auto choice = std::ranges::find_if(
            chosen, [&](const TagChoice& one) { return one.family == tag.family && one.id == tag.id; });
        if (choice == chosen.end()) continue;
        if (shot.picture.width == 0) shot.picture = mergeExposures({&picture, 1}, kExposure, response);
        for (int pass = 0; pass < 2; ++pass) {  // the second one samples nearer to the edges
            const std::optional<PoseEstimate> pose = estimatePose(camera, seenCorners(tag, choice->side));
            if (!pose) break;
            shot.pose = pose->pose;
            const std::optional<std::vector<SeenPoint>> corners = cornersByEdges(shot, paperOf(*choice));
            if (!corners) break;
            for (std::size_t i = 0; i < 4; ++i) tag.corners[i] = (*corners)[i].pixel;
        }
    }
}

}  // namespace penumbra
