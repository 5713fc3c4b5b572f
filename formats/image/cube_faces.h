#pragma once
// Cubes that are no cross become one: six faces below one another, as OpenEXR has them, and six files.
#include <array>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "formats/image/file_picture.h"

namespace penumbra {

// Returns a horizontal cross (environment_map.h) of OpenEXR's six faces: +X, -X, +Y, -Y, +Z, -Z from the top
// (ImfEnvmap.h). In OpenEXR's frame the middle of a lat-long picture looks along +Z, and in ours along +x; a cube is
// turned as those pictures are, so that exrenvmap changes no light: its +Z face is our front, and -X is right of it.
Image crossOfStrip(const Image& strip);

// Which face a file has, by the end of its name: px nx py ny pz nz, posx negx ..., or right left top bottom front back
// (up and down for top and bottom). As programs write them, px is right of pz, and py has pz below it.
std::optional<int> faceOfName(const std::filesystem::path& file);  // 0 .. 5 in the order above
// Returns the six files of a cube of which `face` is one, or nothing where its name is no face's or one is missing.
std::optional<std::array<std::filesystem::path, 6>> findFaceFiles(const std::filesystem::path& face);
// Puts six files in that order. Throws InvalidInput where their names are not those of six faces.
std::array<std::filesystem::path, 6> orderFaceFiles(std::span<const std::filesystem::path> files);

// Reads six square pictures of one size and one colour space as a horizontal cross. Throws what openPicture() throws,
// and InvalidInput, which names the file that differs.
FilePicture readFaces(std::span<const std::filesystem::path, 6> files, const PictureOptions& options);

// Reads one picture, or six files that are the faces of a cube: six paths, or the path of one of them with the layout
// cube. Throws InvalidInput for another number of paths, and BadOption for six with another layout.
FilePicture readLightPicture(std::span<const std::filesystem::path> paths, const PictureOptions& options);

}  // namespace penumbra
