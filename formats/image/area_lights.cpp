// Problem: find the lights of a room whose shadows one can tell apart, such that nothing jumps when the room changes.
//
// Naive: one sun at the brightest direction of SH (sh/light/dominant_light.h). Its lobe is 66 degrees wide, so that two
// lamps of a room are one sun, or none.
//
// Here: 1. What is brighter than the median of its surroundings may be a light. 2. It is blurred a little; every
// maximum of the blurred picture is a light. A maximum that is hardly parted from a higher one has no weight. 3. Every
// pixel is shared out among the lights around it. The moments of what a light gets are its direction, its size and its
// irradiance. 4. A light counts by what it takes from a level ground when it is blocked, as far as SH cannot show the
// edge. Every step is continuous in the picture, and each light takes its pixels with it. docs/formulas.md, section 11.
#include "formats/image/area_lights.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include "formats/image/sun_picture.h"
#include "sh/angles.h"

namespace penumbra {

namespace {

constexpr int kRows = 96, kColumns = 2 * kRows;           // size of the picture that is searched
constexpr int kSkyRows = 24, kSkyColumns = 2 * kSkyRows;  // size of the picture of the surroundings
constexpr double kAroundLight = 35 * kDegree;             // angle within which the surroundings of a pixel are taken
constexpr double kBlur = 14 * kDegree;  // to the end of the kernel; two lamps this far apart have two maxima
constexpr double kReach = 8 * kDegree;  // standard deviation of what a light takes of the pixels around it
constexpr double kEnd = 28 * kDegree;   // where nothing of that is left
constexpr double kAlone = 0.05;         // a pixel is shared out where the lights' parts exceed this
constexpr std::size_t kMaxMaxima = 32;  // the highest ones
constexpr double kMinMaximum = 0.01;    // relative to the highest
constexpr double kMinParted = 0.02, kParted = 0.15;               // depth of a saddle, as a part of the lower maximum
constexpr double kMuchLower = 0.85;                               // a maximum this much below its neighbour is none
constexpr double kMinWorth = 0.006, kFullWorth = 0.015;           // shares of the light of a level ground
constexpr double kNarrow = 14.5 * kDegree, kWide = 18 * kDegree;  // measured: a light fades out between these widths
constexpr double kFullHeight = 0.2;  // sine of the elevation from which on a light that rises has its whole share
constexpr double kFullLead = 1.5;    // over the light after the last one, where a light has its whole share

double smooth(double low, double high, double x) {
    const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

double angleOf(Vec3d a, Vec3d b) { return std::atan2(length(cross(a, b)), dot(a, b)); }

// A lat-long picture of one channel.
struct Plane {
    int rows = 0, columns = 0;
    std::vector<double> values;

    Plane(int r, int c) : rows(r), columns(c), values(std::size_t(r * c)) {}
    Vec3d direction(int row, int column) const {
        return mapDirection({MapLayout::kLatLong, columns, rows}, column + 0.5, row + 0.5);
    }
    double steradians(int row) const { return mapSteradians({MapLayout::kLatLong, columns, rows}, 0.5, row + 0.5); }
    double& at(int row, int column) { return values[std::size_t(row * columns + column)]; }
    double at(int row, int column) const { return values[std::size_t(row * columns + column)]; }
    // Interpolates between the centers of pixels.
    double at(Vec3d direction) const {
        const double y = std::acos(std::clamp(direction.y, -1.0, 1.0)) / std::numbers::pi * rows - 0.5;
        const double x = (std::atan2(direction.z, direction.x) / (2 * std::numbers::pi) + 0.5) * columns - 0.5;
        const int row = std::clamp(int(std::floor(y)), 0, rows - 2), left = int(std::floor(x));
        const double down = std::clamp(y - row, 0.0, 1.0), right = x - left;
        const int a = (left + columns) % columns, b = (left + 1 + columns) % columns;
        return (1 - down) * ((1 - right) * at(row, a) + right * at(row, b)) +
               down * ((1 - right) * at(row + 1, a) + right * at(row + 1, b));
    }
};

Plane luminanceOf(const EnvironmentMap& map, int rows) {
    double clamped = 0;
    const LightPicture picture = smallPicture(map, 2 * rows, clamped);
    Plane plane(rows, 2 * rows);
    for (std::size_t i = 0; i < plane.values.size(); ++i)
        plane.values[i] = luminance(Vec3d{picture.pixels[3 * i], picture.pixels[3 * i + 1], picture.pixels[3 * i + 2]});
    return plane;
}

// The median by solid angle of what is within kAroundLight.
Plane surroundings(const EnvironmentMap& map) {
    const Plane light = luminanceOf(map, 2 * kSkyRows);
    std::vector<int> order(light.values.size());
    std::iota(order.begin(), order.end(), 0);
    std::sort(order.begin(), order.end(),
              [&](int a, int b) { return light.values[std::size_t(a)] < light.values[std::size_t(b)]; });
    std::vector<Vec3d> directions;
    std::vector<double> steradians;
    for (int p : order) {
        directions.push_back(light.direction(p / light.columns, p % light.columns));
        steradians.push_back(light.steradians(p / light.columns));
    }
    Plane sky(kSkyRows, kSkyColumns);
    std::vector<std::pair<double, double>> around;  // solid angle of all up to here, luminance
    for (int row = 0; row < kSkyRows; ++row)
        for (int column = 0; column < kSkyColumns; ++column) {
            const Vec3d center = sky.direction(row, column);
            around.clear();
            double sum = 0;
            for (std::size_t i = 0; i < order.size(); ++i)
                if (dot(directions[i], center) > std::cos(kAroundLight))
                    around.push_back({sum += steradians[i], light.values[std::size_t(order[i])]});
            const auto middle = std::lower_bound(around.begin(), around.end(), std::pair(sum / 2, 0.0));
            sky.at(row, column) = middle->second;
        }
    return sky;
}

// Adds a part of a row of pixels that is turned by some columns to another row.
void addTurned(double part, const double* row, int turn, double* out) {
    for (int c = 0; c < kColumns - turn; ++c) out[c] += part * row[c + turn];
    for (int c = kColumns - turn; c < kColumns; ++c) out[c] += part * row[c + turn - kColumns];
}

// Blurs by (1 - (angle / kBlur)^2)^2. Rows are multiplied with the kernel between two rows, which is made once.
Plane blurred(const Plane& light) {
    Plane out(kRows, kColumns);
    const int reach = int(std::ceil(kBlur / std::numbers::pi * kRows));
    std::vector<Vec3d> directions;
    for (int row = 0; row < kRows; ++row)
        for (int turn = 0; turn < kColumns; ++turn) directions.push_back(light.direction(row, turn));
    std::array<double, kColumns> kernel;
    for (int row = 0; row < kRows; ++row)
        for (int from = std::max(0, row - reach); from <= std::min(kRows - 1, row + reach); ++from) {
            const double weight = light.steradians(from);
            const Vec3d* around = &directions[std::size_t(from * kColumns)];
            for (int turn = 0; turn < kColumns; ++turn) {
                const double cosine = dot(directions[std::size_t(row * kColumns)], around[turn]);
                const double x = cosine > std::cos(kBlur) ? std::acos(std::min(cosine, 1.0)) / kBlur : 1;
                kernel[std::size_t(turn)] = weight * (1 - x * x) * (1 - x * x);
            }
            for (int turn = 0; turn < kColumns; ++turn)
                if (const double part = kernel[std::size_t(turn)]; part != 0)
                    addTurned(part, &light.values[std::size_t(from * kColumns)], turn, &out.at(row, 0));
        }
    return out;
}

struct Maximum {
    Vec3d direction;
    double height = 0, weight = 1;
    std::vector<double> saddle;  // to each of the maxima: the height of the pass between them
};

// The tree in which the maxima of a picture join, from the top down.
class MergeTree {
public:
    explicit MergeTree(const Plane& plane) : plane_(plane), label_(plane.values.size(), -1) {
        std::vector<int> order(plane.values.size());
        std::iota(order.begin(), order.end(), 0);
        std::stable_sort(order.begin(), order.end(),
                         [&](int a, int b) { return plane.values[std::size_t(a)] > plane.values[std::size_t(b)]; });
        for (int pixel : order)
            if (plane.values[std::size_t(pixel)] > 0) add(pixel);
    }
    std::vector<Maximum> take() { return std::move(maxima_); }

private:
    const Plane& plane_;
    std::vector<int> label_;                    // region of each pixel
    std::vector<int> parent_;                   // parent of each region
    std::vector<std::vector<std::size_t>> in_;  // for each region, its maxima among those that are kept
    std::vector<Maximum> maxima_;

    int root(int region) const {
        while (parent_[std::size_t(region)] != region) region = parent_[std::size_t(region)];
        return region;
    }
    void add(int pixel) {
        const int row = pixel / plane_.columns, column = pixel % plane_.columns;
        const double height = plane_.values[std::size_t(pixel)];
        int mine = -1;
        for (int y = std::max(0, row - 1); y <= std::min(plane_.rows - 1, row + 1); ++y)
            for (int x = column - 1; x <= column + 1; ++x) {
                const int other = label_[std::size_t(y * plane_.columns + (x + plane_.columns) % plane_.columns)];
                if (other < 0) continue;
                if (mine < 0)
                    mine = root(other);
                else if (root(other) != mine)
                    mine = join(mine, root(other), height);
            }
        label_[std::size_t(pixel)] = mine >= 0 ? mine : begin(plane_.direction(row, column), height);
    }
    int begin(Vec3d direction, double height) {
        const int region = int(parent_.size());
        parent_.push_back(region);
        in_.emplace_back();
        if (maxima_.size() < kMaxMaxima && (maxima_.empty() || height > kMinMaximum * maxima_[0].height)) {
            in_.back().push_back(maxima_.size());
            maxima_.push_back({direction, height, 1, std::vector<double>(kMaxMaxima)});
        }
        return region;
    }
    int join(int a, int b, double height) {
        std::vector<std::size_t>&one = in_[std::size_t(a)], &two = in_[std::size_t(b)];
        for (std::size_t i : one)
            for (std::size_t j : two) maxima_[i].saddle[j] = maxima_[j].saddle[i] = height;
        one.insert(one.end(), two.begin(), two.end());
        parent_[std::size_t(b)] = a;
        return a;
    }
};

// A maximum loses weight where it is hardly parted from one that is higher. So it has none when it comes into being on
// the slope of another, and two of one height share what is between them.
std::vector<Maximum> weightedMaxima(const Plane& plane) {
    std::vector<Maximum> maxima = MergeTree(plane).take();
    for (std::size_t i = 0; i < maxima.size(); ++i)
        for (std::size_t j = 0; j < maxima.size(); ++j) {
            if (i == j) continue;
            const double lower = std::min(maxima[i].height, maxima[j].height);
            const double parted = smooth(kMinParted, kParted, 1 - maxima[i].saddle[j] / lower);
            maxima[i].weight *= parted + (1 - parted) * smooth(kMuchLower, 1, maxima[i].height / maxima[j].height);
        }
    std::erase_if(maxima, [](const Maximum& maximum) { return maximum.weight == 0; });
    return maxima;
}

// The pixels of the picture that are brighter than their surroundings.
struct BrightPixel {
    std::size_t place = 0;        // in the picture
    Vec3d direction, flux;        // after the surroundings are subtracted
    double bright = 0, part = 0;  // its luminance above the surroundings; as a part of the pixel's own
};

std::vector<BrightPixel> brightPixels(const EnvironmentMap& map, const Plane& sky) {
    std::vector<BrightPixel> pixels;
    const MapShape shape = map.shape();
    for (int y = 0; y < shape.height; ++y)
        for (int x = 0; x < shape.width; ++x) {
            const double steradians = mapSteradians(shape, x + 0.5, y + 0.5);
            if (!(steradians > 0)) continue;
            const std::size_t place = std::size_t(y) * std::size_t(shape.width) + std::size_t(x);
            const Vec3d rgb = toDouble(map.image.pixels[place]), direction = mapDirection(shape, x + 0.5, y + 0.5);
            const double all = luminance(rgb), bright = all - sky.at(direction);
            if (bright > 0) pixels.push_back({place, direction, steradians * bright / all * rgb, bright, bright / all});
        }
    return pixels;
}

// Shares the light of a pixel out among the maxima, `parts` [maxima]. The sum is below 1.
void shareOut(const std::vector<Maximum>& maxima, Vec3d direction, std::vector<double>& parts) {
    double sum = kAlone;
    for (std::size_t i = 0; i < maxima.size(); ++i) {
        parts[i] = 0;
        if (dot(maxima[i].direction, direction) < std::cos(kEnd)) continue;
        const double angle = angleOf(maxima[i].direction, direction), x = angle / kReach;
        parts[i] = maxima[i].weight * std::exp(-x * x / 2) * (1 - smooth(0.8 * kEnd, kEnd, angle));
        sum += parts[i];
    }
    for (double& part : parts) part /= sum;
}

// A light's own pixels end beyond its rim; farther away what is bright belongs to the picture.
double within(const SunD& sun, double angle) {
    return 1 - smooth(1.25 * sun.radius + 0.5 * kDegree, 2 * sun.radius + 2 * kDegree, angle);
}

// The part of a disc's light that SH of order 5 leave out. Bands of a disc fall about as exp(-l (l + 1) radius^2 / 8).
double sharpness(double radius) {
    constexpr int kShown = 5, kBands = 60;
    constexpr double kFinest = 0.05;  // radians; finer than limbs no shadow shows
    double all = 0, left = 0;
    for (int l = 0; l < kBands; ++l) {
        const double band = (2 * l + 1) * std::exp(-l * (l + 1) * (radius * radius / 4 + kFinest * kFinest / 2));
        all += band;
        if (l >= kShown) left += band;
    }
    return left / all;
}

// Where the light of every maximum lies, and how large it is: moments by the square of brightness, which a dim halo
// does not change, and of its part, so that a neighbour does not make it wide.
std::vector<SunD> measured(const std::vector<BrightPixel>& pixels, const std::vector<Maximum>& maxima) {
    std::vector<SunD> suns(maxima.size());
    std::vector<double> parts(maxima.size()), weights(maxima.size()), spread(maxima.size());
    std::vector<Vec3d> centers(maxima.size());
    for (int pass = 0; pass < 2; ++pass) {
        for (const BrightPixel& pixel : pixels) {
            shareOut(maxima, pixel.direction, parts);
            for (std::size_t i = 0; i < maxima.size(); ++i) {
                if (parts[i] == 0) continue;
                const double weight = parts[i] * parts[i] * luminance(pixel.flux) * pixel.bright;
                if (pass == 0) {
                    centers[i] += weight * pixel.direction;
                    weights[i] += weight;
                } else {
                    const double angle = angleOf(suns[i].direction, pixel.direction);
                    spread[i] += weight * angle * angle;
                }
            }
        }
        for (std::size_t i = 0; i < maxima.size(); ++i) {
            if (pass == 0) suns[i].direction = weights[i] > 0 ? normalized(centers[i]) : maxima[i].direction;
            if (pass == 1) suns[i].radius = weights[i] > 0 ? std::sqrt(2 * spread[i] / weights[i]) : 0;
        }
    }
    return suns;
}

double groundLight(const EnvironmentMap& map) {
    const Plane light = luminanceOf(map, kRows);
    double sum = 0;
    for (int row = 0; row < kRows / 2; ++row)
        for (int column = 0; column < kColumns; ++column)
            sum += light.at(row, column) * light.direction(row, column).y * light.steradians(row);
    return sum;
}

// Worth and share of every light. The light after the last one takes over only after the last has faded.
void fillShares(double ground, int most, std::vector<AreaLight>& lights) {
    std::vector<double> worths;
    for (AreaLight& light : lights) {
        const SunD& sun = light.sun;
        const double narrow = 1 - smooth(kNarrow, kWide, sun.radius);
        light.worth =
            luminance(sun.irradiance) * std::max(0.0, sun.direction.y) * sharpness(sun.radius) * narrow / ground;
        worths.push_back(light.worth);
    }
    std::sort(worths.begin(), worths.end(), std::greater<>());
    const double next = worths.size() > std::size_t(most) ? worths[std::size_t(most)] : 0;
    for (AreaLight& light : lights) {
        light.share = smooth(kMinWorth, kFullWorth, light.worth) * smooth(0, kFullHeight, light.sun.direction.y);
        if (next > 0) light.share *= smooth(1, kFullLead, light.worth / next);
    }
}

}  // namespace

AreaLights findAreaLights(const EnvironmentMap& map, int most) {
    assert(most >= 1 && most <= kMaxSuns);
    AreaLights found{{}, map};
    const double ground = groundLight(map);
    if (!(ground > 0)) return found;
    // 1. Bright pixels, and the maxima of what is left of the picture when it is blurred.
    const Plane sky = surroundings(map);
    Plane bright = luminanceOf(map, kRows);
    for (int row = 0; row < kRows; ++row)
        for (int column = 0; column < kColumns; ++column)
            bright.at(row, column) = std::max(0.0, bright.at(row, column) - sky.at(bright.direction(row, column)));
    const std::vector<Maximum> maxima = weightedMaxima(blurred(bright));
    const std::vector<BrightPixel> pixels = brightPixels(map, sky);
    // 2. What each of them is.
    for (const SunD& sun : measured(pixels, maxima)) found.lights.push_back({sun, 0, 0});
    std::vector<double> parts(maxima.size());
    const auto forEachPart = [&](const auto& visit) {
        for (const BrightPixel& pixel : pixels) {
            shareOut(maxima, pixel.direction, parts);
            for (std::size_t i = 0; i < maxima.size(); ++i)
                if (parts[i] > 0)
                    visit(pixel, found.lights[i],
                          parts[i] *
                              within(found.lights[i].sun, angleOf(found.lights[i].sun.direction, pixel.direction)));
        }
    };
    forEachPart(
        [](const BrightPixel& pixel, AreaLight& light, double part) { light.sun.irradiance += part * pixel.flux; });
    fillShares(ground, most, found.lights);
    // 3. The picture without them.
    forEachPart([&](const BrightPixel& pixel, const AreaLight& light, double part) {
        Vec3& rgb = found.rest.image.pixels[pixel.place];
        const Vec3 whole = map.image.pixels[pixel.place];
        for (int c = 0; c < 3; ++c) rgb[c] = std::max(0.0f, rgb[c] - float(light.share * part * pixel.part) * whole[c]);
    });
    for (AreaLight& light : found.lights) {
        light.sun.irradiance *= light.share;
        // Pixels of wide gamuts may be negative in a channel, which no sun is.
        for (int c = 0; c < 3; ++c) light.sun.irradiance[c] = std::max(0.0, light.sun.irradiance[c]);
    }
    std::erase_if(found.lights, [](const AreaLight& light) { return !(luminance(light.sun.irradiance) > 0); });
    std::stable_sort(found.lights.begin(), found.lights.end(),
                     [](const AreaLight& a, const AreaLight& b) { return a.worth > b.worth; });
    return found;
}

}  // namespace penumbra
