#pragma once
// Looks up the colour and the alpha of a rig's surface: base colour times texture times vertex colour.
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "formats/image/texture_file.h"
#include "formats/rig/rig_file.h"

namespace penumbra {

constexpr int kMinPieces = 4, kMaxPieces = 64;  // along an edge of a triangle whose colour varies

// A part of the rig with its picture.
struct TexturedSurface {
    const ColoredPart& part;
    const TexturePicture* picture = nullptr;  // null: none
    bool varies() const { return picture != nullptr || !part.color.tints.empty(); }
};

// Return the colour and the alpha at barycentric coordinates of a triangle, whose corners index the part's vertices.
// The four texels around a place, whose centers are at half numbers, are interpolated.
Vec3d colorAt(const TexturedSurface& surface, const Triangle& triangle, const std::array<double, 3>& at);
double alphaAt(const TexturedSurface& surface, const Triangle& triangle, const std::array<double, 3>& at);

// Returns how many texels the longest edge of a triangle crosses; 0 without a picture.
double texelsAlong(const TexturedSurface& surface, const Triangle& triangle);

// Calls visit(barycentric coordinates) at the middle of each of n^2 equal pieces of a triangle: by rows of constant u,
// each by v, and the piece that points up before the one that points down beside it.
template <class Visit>
void eachPiece(int n, const Visit& visit) {
    for (int i = 0; i < n; ++i)
        for (int k = 0; k + i < n; ++k)
            for (int upside_down = 0; upside_down < (k + i + 1 < n ? 2 : 1); ++upside_down) {
                const double third = (1 + upside_down) / 3.0;
                const double a = (i + third) / n, b = (k + third) / n;
                visit(std::array<double, 3>{1 - a - b, a, b});
            }
}

// Opens each picture once.
class TexturePictures {
public:
    // `where` names rig and slot in messages. Throws the errors of decodeTexture() and readTexture(). Appends the file
    // of a picture that is read for the first time to `files`.
    const TexturePicture* open(const Texture& texture, const std::string& where,
                               std::vector<std::filesystem::path>& files);

private:
    std::map<const Texture*, TexturePicture> opened_;
};

}  // namespace penumbra
