#include "formats/image/sun_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "sh/angles.h"

namespace penumbra {

namespace {

using std::numbers::pi;

constexpr double kAround = 35 * kDegree;
constexpr double kPartOfDisc = 0.05;  // pixels above this part of the peak belong to the sun

// Calls visit(direction, solid angle, pixel) for every pixel of the light. Sines and cosines of a lat-long picture are
// those of its rows and columns, because at large sizes they take most of the time.
template <class Image, class Visit>
void forEachLatLongPixel(Image& image, const MapShape& shape, Visit visit) {
    struct Column {
        double cosine, sine;
    };
    std::vector<Column> columns;
    for (int x = 0; x < shape.width; ++x) {
        const double p = 2 * pi * ((x + 0.5) / shape.width - 0.5);
        columns.push_back({std::cos(p), std::sin(p)});
    }
    std::size_t at = 0;
    for (int y = 0; y < shape.height; ++y) {
        const double t = pi * ((y + 0.5) / shape.height), across = std::sin(t), up = std::cos(t);
        const double solid_angle = mapSteradians(shape, 0.5, y + 0.5);
        for (const Column& column : columns) {
            if (solid_angle > 0)
                visit(Vec3d{across * column.cosine, up, across * column.sine}, solid_angle, image.pixels[at]);
            ++at;
        }
    }
}

template <class Image, class Visit>
void forEachPixel(Image& image, const MapShape& shape, Visit visit) {
    if (shape.layout == MapLayout::kLatLong) return forEachLatLongPixel(image, shape, visit);
    for (int y = 0; y < shape.height; ++y)
        for (int x = 0; x < shape.width; ++x) {
            const double solid_angle = mapSteradians(shape, x + 0.5, y + 0.5);
            if (solid_angle > 0)
                visit(mapDirection(shape, x + 0.5, y + 0.5), solid_angle,
                      image.pixels[std::size_t(y) * std::size_t(shape.width) + std::size_t(x)]);
        }
}

}  // namespace

SunDisc measureSun(const EnvironmentMap& map, Vec3d near) {
    struct Pixel {
        Vec3d direction;
        double solid_angle, luminance;
    };
    std::vector<Pixel> pixels;
    forEachPixel(map.image, map.shape(), [&](Vec3d d, double solid_angle, Vec3 rgb) {
        if (dot(d, near) > std::cos(kAround)) pixels.push_back({d, solid_angle, luminance(toDouble(rgb))});
    });
    SunDisc disc{near, 0, 0};
    if (pixels.empty()) return disc;
    // 1. The median is the sky around the sun. Where the sun fills more than half of what is looked at, as a window
    //    may, the median is the sun itself, and the darkest tenth is the sky. If that is the sun, too, we see no end of
    //    it.
    const auto less = [](const Pixel& a, const Pixel& b) { return a.luminance < b.luminance; };
    const auto darkest = [&](std::size_t count) {
        const auto last = pixels.begin() + std::ptrdiff_t(count);
        std::nth_element(pixels.begin(), last, pixels.end(), less);
        return last->luminance;
    };
    const double brightest = std::max_element(pixels.begin(), pixels.end(), less)->luminance;
    double background = darkest(pixels.size() / 2);
    if (background > brightest / 2) background = darkest(pixels.size() / 10);
    if (background > brightest / 2) disc.radius = kAround;
    const double peak = brightest - background;
    if (disc.radius > 0 || !(peak > 0)) return disc;
    // 2. Flux and center of what stands out.
    double flux = 0;
    Vec3d center;
    for (const Pixel& pixel : pixels) {
        if (pixel.luminance == brightest) ++disc.flat_pixels;
        const double above = pixel.luminance - background;
        if (above < kPartOfDisc * peak) continue;
        flux += above * pixel.solid_angle;
        center += above * pixel.solid_angle * pixel.direction;
    }
    disc.direction = normalized(center);
    disc.radius = std::acos(std::max(-1.0, 1 - flux / (2 * pi * peak)));
    return disc;
}

void removeSun(EnvironmentMap& map, SunD& sun) {
    const double cosine = std::cos(kAround);
    for (int c = 0; c < 3; ++c) {
        struct Pixel {
            float* value;
            double solid_angle;
        };
        std::vector<Pixel> pixels;
        forEachPixel(map.image, map.shape(), [&](Vec3d d, double solid_angle, Vec3& rgb) {
            if (dot(d, sun.direction) > cosine)
                pixels.push_back({c == 0 ? &rgb.x : c == 1 ? &rgb.y : &rgb.z, solid_angle});
        });
        // From the brightest pixel down: the level is found where the pixels above it have the flux of the sun.
        std::sort(pixels.begin(), pixels.end(), [](Pixel a, Pixel b) { return *a.value > *b.value; });
        double flux = 0, area = 0, level = 0;
        for (std::size_t i = 0; i < pixels.size(); ++i) {
            flux += pixels[i].solid_angle * double(*pixels[i].value);
            area += pixels[i].solid_angle;
            const double next = i + 1 < pixels.size() ? double(*pixels[i + 1].value) : 0;
            if (flux - area * next < sun.irradiance[c]) continue;
            level = std::max(0.0, (flux - sun.irradiance[c]) / area);
            break;
        }
        sun.irradiance[c] = std::min(sun.irradiance[c], std::max(0.0, flux));  // pixels of wide gamuts may be negative
        for (const Pixel& pixel : pixels) *pixel.value = std::min(*pixel.value, float(level));
    }
}

namespace {

// How one axis of a picture is cut into another number of cells: for every new cell the first old cell and the weights
// of the old cells that it overlaps.
struct Cells {
    std::size_t first = 0;
    std::vector<double> weights;
};

std::vector<Cells> overlaps(const std::vector<double>& from, const std::vector<double>& to) {
    std::vector<Cells> cells(to.size() - 1);
    for (std::size_t i = 0; i + 1 < to.size(); ++i)
        for (std::size_t j = 0; j + 1 < from.size(); ++j) {
            const double overlap = std::min(to[i + 1], from[j + 1]) - std::max(to[i], from[j]);
            if (!(overlap > 0)) continue;
            if (cells[i].weights.empty()) cells[i].first = j;
            cells[i].weights.push_back(overlap);
        }
    return cells;
}

std::vector<double> columnEdges(int width) {
    std::vector<double> edges;
    for (int x = 0; x <= width; ++x) edges.push_back(2 * pi * x / width);
    return edges;
}

std::vector<double> rowEdges(int height) {
    std::vector<double> edges;
    for (int y = 0; y <= height; ++y) edges.push_back(-std::cos(pi * y / height));
    return edges;
}

// Other layouts become lat-long first, fine enough that every pixel is met, and scaled to the flux that they had.
EnvironmentMap asLatLong(const EnvironmentMap& map) {
    EnvironmentMap out;
    out.image.height = 2 * std::max(map.image.width, map.image.height), out.image.width = 2 * out.image.height;
    out.image.pixels.resize(std::size_t(out.image.width) * std::size_t(out.image.height));
    Vec3d flux, painted;
    forEachPixel(map.image, map.shape(), [&](Vec3d, double w, Vec3 rgb) { flux += w * toDouble(rgb); });
    forEachPixel(out.image, out.shape(), [&](Vec3d d, double w, Vec3& rgb) {
        const MapPixel at = mapPixel(map.shape(), d);
        rgb = map.image.pixels[std::size_t(at.y) * std::size_t(map.image.width) + std::size_t(at.x)];
        painted += w * toDouble(rgb);
    });
    for (Vec3& rgb : out.image.pixels)
        for (int c = 0; c < 3; ++c)
            if (painted[c] > 0) rgb[c] *= float(flux[c] / painted[c]);
    return out;
}

}  // namespace

LightPicture smallPicture(const EnvironmentMap& map, int width, double& clamped) {
    if (map.layout != MapLayout::kLatLong) return smallPicture(asLatLong(map), width, clamped);
    LightPicture picture{width, width / 2, {}};
    const auto columns = overlaps(columnEdges(map.image.width), columnEdges(width));
    const auto rows = overlaps(rowEdges(map.image.height), rowEdges(picture.height));
    constexpr double kLargestHalf = 65504;
    double all = 0, lost = 0;
    for (const Cells& row : rows)
        for (const Cells& column : columns) {
            Vec3d flux;
            double solid_angle = 0;
            for (std::size_t j = 0; j < row.weights.size(); ++j)
                for (std::size_t i = 0; i < column.weights.size(); ++i) {
                    const double w = row.weights[j] * column.weights[i];
                    flux +=
                        w *
                        toDouble(map.image.pixels[(row.first + j) * std::size_t(map.image.width) + column.first + i]);
                    solid_angle += w;
                }
            for (int c = 0; c < 3; ++c) {
                const double radiance = std::max(0.0, flux[c] / solid_angle);
                all += radiance * solid_angle;
                lost += std::max(0.0, radiance - kLargestHalf) * solid_angle;
                picture.pixels.push_back(float(std::min(radiance, kLargestHalf)));
            }
        }
    clamped = all > 0 ? lost / all : 0;
    return picture;
}

EnvironmentMap paintLights(const LightParts& parts, int width) {
    EnvironmentMap map;
    map.image.width = width, map.image.height = width / 2;
    map.image.pixels.resize(std::size_t(width) * std::size_t(width / 2));
    std::vector<Vec3d> discs(parts.discs.size());  // painted flux of each
    const auto paint = [&](bool measure) {
        forEachPixel(map.image, map.shape(), [&](Vec3d d, double w, Vec3& rgb) {
            Vec3d sum;
            for (const SmoothLight& light : parts.smooth) sum += light.radiance(d);
            for (std::size_t i = 0; i < discs.size(); ++i) {
                if (!parts.discs[i].covers(d)) continue;
                if (measure) discs[i] += Vec3d{w, w, w};
                sum += parts.discs[i].radiance * (measure ? 1 : parts.discs[i].solidAngle() / discs[i].x);
            }
            rgb = toFloat(sum);
        });
    };
    paint(true);   // 1. How much of each disc the pixels' centers meet.
    paint(false);  // 2. Discs with their whole flux.
    // 3. Deltas, and discs so small that they lie between the centers.
    const auto add = [&](Vec3d direction, Vec3d flux) {
        const MapPixel at = mapPixel(map.shape(), direction);
        map.image.pixels[std::size_t(at.y) * std::size_t(width) + std::size_t(at.x)] +=
            toFloat(flux / mapSteradians(map.shape(), at.x + 0.5, at.y + 0.5));
    };
    for (const DirectionalLight& light : parts.directional) add(light.direction, light.irradiance);
    for (std::size_t i = 0; i < discs.size(); ++i)
        if (discs[i].x == 0) add(parts.discs[i].direction, parts.discs[i].solidAngle() * parts.discs[i].radiance);
    return map;
}

}  // namespace penumbra
