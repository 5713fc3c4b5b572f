#include "tests/formats/drawn_tags.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "formats/camera/tag_family.h"

namespace penumbra::samples {

namespace {

// Whether the tag is white at x, y of its upright picture: in modules from the upper left corner of the black square.
bool isWhite(const DrawnTag& tag, int x, int y, int& modules) {
    const FamilyPointer family = makeFamily(tag.family);
    modules = family->width_at_border;
    if (x < 0 || y < 0 || x >= modules || y >= modules) return true;
    if (tag.family != TagFamily::k4x4_50) x = modules - 1 - x, y = modules - 1 - y;  // printed as OpenCV prints them
    for (std::uint32_t bit = 0; bit < family->nbits; ++bit)
        if (int(family->bit_x[bit]) == x && int(family->bit_y[bit]) == y)
            return (family->codes[tag.id] >> (family->nbits - 1 - bit)) & 1;
    return false;  // the black border
}

struct Printed {
    DrawnTag tag;
    int modules = 0;
    std::vector<char> white;  // [modules, modules]
};

Printed printed(const DrawnTag& tag) {
    Printed out{tag, 0, {}};
    isWhite(tag, 0, 0, out.modules);
    for (int y = 0; y < out.modules; ++y)
        for (int x = 0, m = 0; x < out.modules; ++x) out.white.push_back(isWhite(tag, x, y, m));
    return out;
}

double lightOf(const Photograph& taken, std::span<const Printed> tags, double x, double y) {
    for (const Printed& one : tags) {
        const double module = one.tag.side / one.modules, half = one.tag.side / 2;
        const double u = (x - one.tag.place.x + half) / module, v = (half - (y - one.tag.place.y)) / module;
        if (u < -1 || v < -1 || u >= one.modules + 1 || v >= one.modules + 1) continue;
        const int column = int(std::floor(u)), row = int(std::floor(v));
        const bool border = column < 0 || row < 0 || column >= one.modules || row >= one.modules;
        return border || one.white[std::size_t(row * one.modules + column)] ? taken.paper : 0.05 * taken.paper;
    }
    return taken.floor;
}

}  // namespace

TexturePicture photographOf(const Photograph& taken, std::span<const DrawnTag> tags) {
    constexpr int kRays = 4;
    std::vector<Printed> all;
    for (const DrawnTag& tag : tags) all.push_back(printed(tag));
    const PinholeCamera& camera = taken.camera;
    const Vec3d eye = taken.pose.place();
    const Mat3d to_marker = transposed(taken.pose.rotation);
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    TexturePicture out{camera.width, camera.height, {}};
    for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x) {
            double sum = 0;
            for (int ray = 0; ray < kRays * kRays; ++ray) {
                const double dx = (ray % kRays + 0.5) / kRays - 0.5, dy = (ray / kRays + 0.5) / kRays - 0.5;
                const Vec3d way = to_marker * viewRay(camera, {x + dx, y + dy});
                const double t = -eye.z / way.z;
                sum += t > 0 ? lightOf(taken, all, eye.x + t * way.x, eye.y + t * way.y) : taken.floor;
            }
            const double light = sum / (kRays * kRays) + taken.noise * normal(random);
            for (int c = 0; c < 3; ++c)
                out.rgb.push_back(
                    std::uint8_t(std::lround(codeOf(taken.response, c, float(std::clamp(light, 0.0, 1.0))))));
        }
    return out;
}

CameraPose lookingAt(Vec3d eye, Vec3d target) {
    const Vec3d forward = normalized(target - eye), right = normalized(cross(forward, Vec3d{0, 0, 1}));
    CameraPose out;
    out.rotation = fromRows(right, cross(forward, right), forward);
    out.translation = -(out.rotation * eye);
    return out;
}

}  // namespace penumbra::samples
