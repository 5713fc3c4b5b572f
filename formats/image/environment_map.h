#pragma once
// Reads pictures of a whole sphere of radiance, seen from its center. In the model frame the middle of a lat-long
// picture, the center of an angular map and of a mirror ball and the front face of a cube all look along +x with +y
// up.
// - lat-long: twice as wide as high; latLongDirection() has the formula; rightwards is +z.
// - angular: a square, Debevec's light probe. r = polar angle from +x / pi, 0 at the center, 1 on the rim (-x);
//   rightwards is +z.
// - ball: a square, the cropped photograph of a mirror ball by a distant camera at +x. r = sin(polar angle / 2). The
//   picture is mirrored as the ball does it, so that rightwards is -z.
// - cube: a cross of six faces. 3 x 4: top (+y); left (-z), front (+x), right (+z); bottom (-y); back (-x) upside
//   down. 4 x 3: top above and bottom below the front of the row left, front, right, back. Faces touch as they do
//   when the cross is folded. Strips of six faces and six files become crosses when they are read (cube_faces.h).
// Pixels outside of the disc or of the faces are not part of the light.
#include <string>
#include <string_view>

#include "formats/image/file_picture.h"
#include "formats/image/picture_shape.h"

namespace penumbra {

enum class MapLayout { kLatLong, kAngular, kBall, kVerticalCross, kHorizontalCross };
std::string_view nameOf(MapLayout layout);  // latlong, angular, ball, cube

struct MapShape {
    MapLayout layout = MapLayout::kLatLong;
    int width = 0, height = 0;  // pixels
};

struct EnvironmentMap {
    MapLayout layout = MapLayout::kLatLong;
    Image image;
    std::size_t negative_pixels = 0;  // pixels that makeEnvironmentMap() found and mended (negative_radiance.h)
    double negative_share = 0;        // their share of the light
    PictureNotes notes;               // notes of the reader

    MapShape shape() const { return {layout, image.width, image.height}; }
};

// Makes a map. `layout` is one of the names above, or "" to go by the shape: 2:1 is lat-long; 3:4 and 4:3 are crosses
// where everything off the faces has one colour; a square may be an angular map or a ball and must be named. `name`
// starts messages. Throws InvalidInput for another shape, for a radiance above kMaxRadiance, and for negative radiance
// that is no ringing of compression (negative_radiance.h).
EnvironmentMap makeEnvironmentMap(Image image, std::string_view layout, const std::string& name);
// Makes a map of a picture in its file's colours. Ringing is looked for in those; then they become linear Rec.709,
// where colours outside of its gamut stay negative.
EnvironmentMap makeEnvironmentMap(FilePicture picture, std::string_view layout, const std::string& name);
// Reads the picture of a light. Throws what openPicture() and makeEnvironmentMap() throw.
EnvironmentMap readEnvironmentMap(const std::filesystem::path& path, const PictureOptions& options);
// Does the same with one file, or with six that are the faces of a cube.
EnvironmentMap readEnvironmentMap(std::span<const std::filesystem::path> paths, const PictureOptions& options);
// Returns the files that readEnvironmentMap() reads: six where layout is cube and the file's name is that of a face.
std::vector<std::filesystem::path> filesOfPicture(const std::filesystem::path& path, const PictureOptions& options);
// Tells whether a picture of these sides is a lat-long map. `stated` is what its file says.
bool isLatLongMap(PictureSides sides, std::string_view layout, std::string_view stated);

// --- Geometry, in pixels: x right from the left edge, y down from the top edge ---------------------------------------
struct MapPixel {
    int x = 0, y = 0;
};
Vec3d mapDirection(const MapShape& shape, double x, double y);  // zero outside of the light
MapPixel mapPixel(const MapShape& shape, Vec3d direction);
// Return the steradians that a unit of area of the picture (pixels^2) covers at this point, or where `direction`
// lies; 0 outside of the light.
double mapSteradians(const MapShape& shape, double x, double y);
double mapSteradians(const MapShape& shape, Vec3d direction);

// --- Cubes ----------------------------------------------------------------------------------------------------------
struct CubeFace {
    int column = 0, row = 0;     // place in the cross, counted in faces
    Vec3d forward, right, down;  // direction = forward + s right + t down, s and t in (-1, 1) from the face's top left
};
std::span<const CubeFace> cubeFaces(MapLayout layout);
// Returns the solid angle of the rectangle [s0, s1] x [t0, t1] of a face.
double cubeSolidAngle(double s0, double s1, double t0, double t1);

}  // namespace penumbra
