#include "formats/image/environment_map.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "formats/common/errors.h"
#include "formats/common/light_picture.h"
#include "formats/image/cube_faces.h"
#include "formats/image/negative_radiance.h"

namespace penumbra {

constexpr double kPi = std::numbers::pi;

std::string_view nameOf(MapLayout layout) {
    switch (layout) {
        case MapLayout::kLatLong:
            return "latlong";
        case MapLayout::kAngular:
            return "angular";
        case MapLayout::kBall:
            return "ball";
        default:
            return "cube";
    }
}

// --- Cubes ----------------------------------------------------------------------------------------------------------

namespace {

constexpr Vec3d kX{1, 0, 0}, kY{0, 1, 0}, kZ{0, 0, 1};
constexpr std::array<CubeFace, 6> kVerticalFaces = {{{1, 0, kY, kZ, kX},
                                                     {0, 1, -kZ, kX, -kY},
                                                     {1, 1, kX, kZ, -kY},
                                                     {2, 1, kZ, -kX, -kY},
                                                     {1, 2, -kY, kZ, -kX},
                                                     {1, 3, -kX, kZ, kY}}};
constexpr std::array<CubeFace, 6> kHorizontalFaces = {{{1, 0, kY, kZ, kX},
                                                       {0, 1, -kZ, kX, -kY},
                                                       {1, 1, kX, kZ, -kY},
                                                       {2, 1, kZ, -kX, -kY},
                                                       {3, 1, -kX, -kZ, -kY},
                                                       {1, 2, -kY, kZ, -kX}}};

}  // namespace

std::span<const CubeFace> cubeFaces(MapLayout layout) {
    assert(layout == MapLayout::kVerticalCross || layout == MapLayout::kHorizontalCross);
    if (layout == MapLayout::kVerticalCross) return kVerticalFaces;
    return kHorizontalFaces;
}

double cubeSolidAngle(double s0, double s1, double t0, double t1) {
    const auto corner = [](double s, double t) { return std::atan2(s * t, std::sqrt(s * s + t * t + 1)); };
    return corner(s1, t1) - corner(s0, t1) - corner(s1, t0) + corner(s0, t0);
}

namespace {

bool isCross(MapLayout layout) { return layout == MapLayout::kVerticalCross || layout == MapLayout::kHorizontalCross; }

double faceSize(const MapShape& shape) { return shape.width / (shape.layout == MapLayout::kVerticalCross ? 3.0 : 4.0); }

struct FacePoint {
    const CubeFace* face = nullptr;
    double s = 0, t = 0;
};

FacePoint facePoint(const MapShape& shape, double x, double y) {
    const double size = faceSize(shape);
    for (const CubeFace& face : cubeFaces(shape.layout)) {
        const double s = 2 * (x / size - face.column) - 1, t = 2 * (y / size - face.row) - 1;
        if (std::abs(s) <= 1 && std::abs(t) <= 1) return {&face, s, t};
    }
    return {};
}

FacePoint facePoint(const MapShape& shape, Vec3d direction) {
    FacePoint best;
    double forward = 0;
    for (const CubeFace& face : cubeFaces(shape.layout))
        if (const double along = dot(face.forward, direction); along > forward)
            forward = along, best = {&face, dot(face.right, direction) / along, dot(face.down, direction) / along};
    return best;
}

// --- Discs ----------------------------------------------------------------------------------------------------------

// u points right and v up, both in (-1, 1). Returns the polar angle from +x.
double polarOf(MapLayout layout, double r) {
    return layout == MapLayout::kAngular ? kPi * r : 2 * std::asin(std::min(1.0, r));
}

Vec3d discDirection(MapLayout layout, double u, double v) {
    const double r = std::hypot(u, v);
    if (r > 1) return {};
    const double polar = polarOf(layout, r), across = r > 0 ? std::sin(polar) / r : 0;
    return {std::cos(polar), across * v, (layout == MapLayout::kAngular ? across : -across) * u};
}

// Returns the steradians of a unit of area: sin(polar) dpolar / (r dr).
double discSteradians(MapLayout layout, double r) {
    if (r > 1) return 0;
    if (layout == MapLayout::kBall) return 4;
    return r > 1e-9 ? kPi * std::sin(kPi * r) / r : kPi * kPi;
}

void discCoordinates(MapLayout layout, Vec3d direction, double& u, double& v) {
    const double across = std::hypot(direction.y, direction.z), polar = std::atan2(across, direction.x);
    const double r = layout == MapLayout::kAngular ? polar / kPi : std::sin(polar / 2);
    const double scale = across > 0 ? r / across : 0;
    u = scale * (layout == MapLayout::kAngular ? direction.z : -direction.z);
    v = scale * direction.y;
    if (across == 0 && direction.x < 0) u = 1;  // any point of the rim
}

}  // namespace

// --- All layouts ----------------------------------------------------------------------------------------------------

Vec3d mapDirection(const MapShape& shape, double x, double y) {
    if (shape.layout == MapLayout::kLatLong) return latLongDirection(x / shape.width, y / shape.height);
    if (!isCross(shape.layout)) return discDirection(shape.layout, 2 * x / shape.width - 1, 1 - 2 * y / shape.height);
    const FacePoint point = facePoint(shape, x, y);
    if (!point.face) return {};
    return normalized(point.face->forward + point.s * point.face->right + point.t * point.face->down);
}

namespace {

void mapPoint(const MapShape& shape, Vec3d direction, double& x, double& y) {
    if (shape.layout == MapLayout::kLatLong) {
        latLongCoordinates(direction, x, y);
        x *= shape.width, y *= shape.height;
    } else if (!isCross(shape.layout)) {
        double u, v;
        discCoordinates(shape.layout, direction, u, v);
        x = (u + 1) / 2 * shape.width, y = (1 - v) / 2 * shape.height;
    } else {
        const FacePoint point = facePoint(shape, direction);
        const double size = faceSize(shape);
        // The place stays inside its face, whose neighbours in the picture may be no part of the light.
        const auto inside = [&](int cell, double s) {
            return std::clamp((s + 1) / 2 * size, 0.0, size - 1e-6) + cell * size;
        };
        x = inside(point.face->column, point.s), y = inside(point.face->row, point.t);
    }
}

}  // namespace

MapPixel mapPixel(const MapShape& shape, Vec3d direction) {
    double x, y;
    mapPoint(shape, direction, x, y);
    return {std::clamp(int(x), 0, shape.width - 1), std::clamp(int(y), 0, shape.height - 1)};
}

double mapSteradians(const MapShape& shape, double x, double y) {
    if (shape.layout == MapLayout::kLatLong)
        return 2 * kPi / shape.width * kPi / shape.height * std::sin(kPi * y / shape.height);
    if (!isCross(shape.layout))
        return discSteradians(shape.layout, std::hypot(2 * x / shape.width - 1, 1 - 2 * y / shape.height)) * 4 /
               (double(shape.width) * shape.height);
    const FacePoint point = facePoint(shape, x, y);
    if (!point.face) return 0;
    const double size = faceSize(shape), square = 1 + point.s * point.s + point.t * point.t;
    return 4 / (size * size * square * std::sqrt(square));
}

double mapSteradians(const MapShape& shape, Vec3d direction) {
    double x, y;
    mapPoint(shape, direction, x, y);
    return mapSteradians(shape, x, y);
}

// --- From pictures --------------------------------------------------------------------------------------------------

namespace {

std::string sizeOf(const Image& image) { return std::to_string(image.width) + " x " + std::to_string(image.height); }

PictureSides sidesOf(const Image& image) { return {image.width, image.height}; }

// Tells whether everything off the faces of a cross has one colour, as programs that write crosses leave it.
bool cornersAreEmpty(const Image& image, MapLayout layout) {
    const int size = layout == MapLayout::kVerticalCross ? image.width / 3 : image.width / 4;
    const auto faces = cubeFaces(layout);
    const Vec3 empty = image.pixels.back();  // the last corner is off the faces in both
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
            const bool used = std::any_of(faces.begin(), faces.end(), [&](const CubeFace& face) {
                return x / size == face.column && y / size == face.row;
            });
            if (!used && image.pixels[std::size_t(y) * std::size_t(image.width) + std::size_t(x)] != empty)
                return false;
        }
    return true;
}

MapLayout guessLayout(const Image& image, const std::string& name) {
    if (image.width == 2 * image.height) return MapLayout::kLatLong;
    for (MapLayout cross : {MapLayout::kVerticalCross, MapLayout::kHorizontalCross}) {
        const bool vertical = cross == MapLayout::kVerticalCross;
        if (!hasShape(sidesOf(image), vertical ? 3 : 4, vertical ? 4 : 3)) continue;
        if (cornersAreEmpty(image, cross)) return cross;
        throw InvalidInput(
            name + ": " + sizeOf(image) +
            " may be a cube cross, but the corners off its faces hold a picture: layout cube says that it is");
    }
    if (isLatLongShape(sidesOf(image))) return MapLayout::kLatLong;
    if (image.width == image.height)
        throw InvalidInput(name + ": " + sizeOf(image) +
                           " may be an angular map, a mirror ball or a face of a cube: layout angular or ball must be "
                           "given, or cube for a face with five more beside it");
    throw InvalidInput(name + ": " + sizeOf(image) +
                       " is not a layout: lat-long is 2:1, cube crosses are 3:4 or 4:3, cubes of six faces below one "
                       "another 1:6, angular maps and balls are square");
}

MapLayout chooseLayout(const Image& image, std::string_view layout, const std::string& name) {
    if (layout.empty()) return guessLayout(image, name);
    const auto expect = [&](const char* shape) {
        if (!hasLayoutShape(sidesOf(image), layout))
            throw InvalidInput(name + ": " + sizeOf(image) + ": layout " + std::string(layout) + " is " + shape);
    };
    if (layout == "latlong") {
        expect("twice as wide as high");
        return MapLayout::kLatLong;
    }
    if (layout == "cube") {
        expect("a cross of square faces, 3 x 4 or 4 x 3, or six faces below one another");
        return hasShape(sidesOf(image), 3, 4) ? MapLayout::kVerticalCross : MapLayout::kHorizontalCross;
    }
    if (layout != "angular" && layout != "ball")
        throw BadOption("layout", "must be latlong, angular, ball or cube, not '" + std::string(layout) + "'");
    expect("square");
    return layout == "angular" ? MapLayout::kAngular : MapLayout::kBall;
}

// Returns the layout that was asked for, or else the one that the file states.
std::string layoutOf(const FilePicture& picture, std::string_view asked, PictureNotes& notes) {
    const std::string& stated = picture.info.layout;
    if (stated == "cross") return "cube";  // the cross was made of six files
    if (stated.empty() || asked == stated) return std::string(asked);
    if (asked.empty()) return stated;
    notes.warnings.push_back("the file says that it is " + stated + "; it is read as " + std::string(asked) +
                             ", as was asked for");
    return std::string(asked);
}

void checkRadiance(const EnvironmentMap& map, const std::string& name) {
    for (std::size_t at = 0; at < map.image.pixels.size(); ++at) {
        const Vec3 pixel = map.image.pixels[at];
        const float most = std::max({pixel.x, pixel.y, pixel.z});
        const int x = int(at % std::size_t(map.image.width)), y = int(at / std::size_t(map.image.width));
        if (most <= float(kMaxRadiance) || mapSteradians(map.shape(), x + 0.5, y + 0.5) == 0) continue;
        char numbers[80];
        std::snprintf(numbers, sizeof numbers, "%.3g in pixel (%d, %d); at most %.0e is allowed", double(most), x, y,
                      kMaxRadiance);
        throw InvalidInput(name + ": a radiance of " + numbers);
    }
}

}  // namespace

bool isLatLongMap(PictureSides sides, std::string_view layout, std::string_view stated) {
    const std::string_view meant = layout.empty() ? stated : layout;
    if (!meant.empty()) return meant == "latlong" && isLatLongShape(sides);
    return isLatLongShape(sides) && !isCrossShape(sides);
}

EnvironmentMap makeEnvironmentMap(FilePicture picture, std::string_view layout, const std::string& name) {
    EnvironmentMap map;
    map.notes = std::move(picture.info.notes);
    const std::string meant = layoutOf(picture, layout, map.notes);
    if (isStripShape(sidesOf(picture.image)) && (meant.empty() || meant == "cube")) {
        picture.image = crossOfStrip(picture.image);
        map.layout = MapLayout::kHorizontalCross;
    } else {
        map.layout = chooseLayout(picture.image, meant, name);
        if (map.layout == MapLayout::kLatLong && picture.image.width != 2 * picture.image.height)
            map.notes.lines.push_back(sizeOf(picture.image) + " is nearly 2:1 and is read as lat-long");
    }
    map.image = std::move(picture.image);
    checkRadiance(map, name);
    const NegativeRadiance negative = removeNegativeRadiance(map, name);
    map.negative_pixels = negative.pixels;
    map.negative_share = negative.share;
    convertColors(picture.info.to_rec709, map.image);
    return map;
}

EnvironmentMap makeEnvironmentMap(Image image, std::string_view layout, const std::string& name) {
    FilePicture picture;
    picture.image = std::move(image);
    return makeEnvironmentMap(std::move(picture), layout, name);
}

std::vector<std::filesystem::path> filesOfPicture(const std::filesystem::path& path, const PictureOptions& options) {
    if (options.layout != "cube") return {path};
    const auto faces = findFaceFiles(path);
    return faces ? std::vector(faces->begin(), faces->end()) : std::vector{path};
}

EnvironmentMap readEnvironmentMap(const std::filesystem::path& path, const PictureOptions& options) {
    return readEnvironmentMap({&path, 1}, options);
}

EnvironmentMap readEnvironmentMap(std::span<const std::filesystem::path> paths, const PictureOptions& options) {
    assert(!paths.empty());
    return makeEnvironmentMap(readLightPicture(paths, options), options.layout, paths.front().string());
}

}  // namespace penumbra
