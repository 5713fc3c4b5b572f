// Makes the opacity micromap of a rig.
//
// Problem: a ray that hits a hair card must know the alpha at that place, a million times a frame.
//
// Naive: keep textures and texture coordinates beside the rays, and look alpha up at every hit. Then every program
// that traces needs the pictures, and a hit costs four texels and their interpolation.
//
// Here: each triangle is cut into pieces, about one a texel of its picture, and the alpha in their middle is kept as a
// byte (formats/common/opacity.h): 0 or 255 with a cut-off, else the share of rays that the piece stops. Triangles of
// equal pieces share them, as most cards of a head of hair do. A triangle that is opaque all over is not listed, so it
// costs nothing.
#include "bake/source/surface_opacity.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <unordered_map>

#include "bake/source/textured_surface.h"
#include "formats/common/errors.h"
#include "formats/common/twin_triangles.h"
#include "formats/common/write_file.h"

namespace penumbra {

namespace {

constexpr std::size_t kMaxValues = std::size_t(1) << 26;  // limit for all triangles together; if it is passed, pieces
                                                          // become larger

std::uint8_t shareStopped(const MaterialColor& material, double alpha) {
    if (material.alpha_mode == AlphaMode::kMask) return alpha >= double(material.alpha_cutoff) ? kStopsAll : 0;
    return std::uint8_t(std::lround(std::clamp(alpha, 0.0, 1.0) * kStopsAll));
}

// Returns into how many pieces to cut each edge.
int opacityPieces(const TexturedSurface& surface, const Triangle& triangle) {
    if (!surface.picture && surface.part.color.alphas.empty()) return 1;
    const int texels = int(std::min(std::ceil(texelsAlong(surface, triangle)), 1e6));
    return std::clamp(texels, surface.part.color.alphas.empty() ? 1 : kMinPieces, kMaxOpacityPieces);
}

std::vector<std::uint8_t> valuesOf(const TexturedSurface& surface, const Triangle& triangle, int n) {
    std::vector<std::uint8_t> values;
    eachPiece(n, [&](const std::array<double, 3>& at) {
        values.push_back(shareStopped(surface.part.color.material, alphaAt(surface, triangle, at)));
    });
    const bool alike = std::all_of(values.begin(), values.end(), [&](std::uint8_t v) { return v == values[0]; });
    if (alike) values.resize(1);
    return values;
}

// Collects triangles in ascending order. Equal lists of values are kept once.
class OpacityBuilder {
public:
    void add(std::uint32_t triangle, const std::vector<std::uint8_t>& values) {
        if (values.size() == 1 && values[0] == kStopsAll) return;
        const auto [at, is_new] =
            first_.try_emplace(std::string(values.begin(), values.end()), std::uint32_t(opacity_.values.size()));
        if (is_new) opacity_.values.insert(opacity_.values.end(), values.begin(), values.end());
        opacity_.triangles.push_back(triangle);
        opacity_.pieces.push_back(std::uint8_t(std::lround(std::sqrt(double(values.size())))));
        opacity_.first.push_back(at->second);
    }
    std::size_t size() const { return opacity_.values.size(); }
    Opacity take() { return std::move(opacity_); }

private:
    Opacity opacity_;
    std::unordered_map<std::string, std::uint32_t> first_;  // where each list of values begins
};

// Opens the pictures of the parts that are not opaque. Entries of opaque parts, and of those whose alpha cannot be
// known, are null.
struct AlphaPart {
    std::optional<TexturedSurface> surface;
};
std::vector<AlphaPart> openParts(Rig& rig, TexturePictures& pictures) {
    std::vector<AlphaPart> parts(rig.part_colors.size());
    for (std::size_t p = 0; p < parts.size(); ++p) {
        const ColoredPart& part = rig.part_colors[p];
        const MaterialColor& material = part.color.material;
        if (material.alpha_mode == AlphaMode::kOpaque) continue;
        const std::string file = rig.files_read.front().string();
        std::string problem = material.problem;
        try {
            const TexturePicture* picture = nullptr;
            if (problem.empty() && material.texture)
                picture = pictures.open(*material.texture, file + ": slot '" + rig.mesh.slots[part.slot] + "'",
                                        rig.files_read);
            if (problem.empty()) parts[p].surface.emplace(TexturedSurface{part, picture});
        } catch (const Interrupted&) {
            throw;
        } catch (const std::runtime_error& error) {
            problem = error.what();
        }
        const RigNote note{file, rig.mesh.slots[part.slot], "alpha", "is not known, so it stops all light: " + problem};
        if (!problem.empty() && std::find(rig.notes.begin(), rig.notes.end(), note) == rig.notes.end())
            rig.notes.push_back(note);
    }
    return parts;
}

}  // namespace

void readOpacity(Rig& rig) {
    TexturePictures pictures;
    const std::vector<AlphaPart> parts = openParts(rig, pictures);
    if (std::none_of(parts.begin(), parts.end(), [](const AlphaPart& part) { return part.surface.has_value(); }))
        return;
    const std::vector<std::uint32_t> twins = twinTriangles(rig.mesh, rig.skin);
    OpacityBuilder builder;
    for (std::uint32_t t = 0; t < rig.source_corners.size(); ++t) {
        throwIfInterrupted();
        if (!twins.empty() && twins[t] < t) continue;  // rays meet the front alone
        Triangle corners = rig.source_corners[t];
        const auto behind = std::upper_bound(rig.part_colors.begin(), rig.part_colors.end(), std::size_t(corners[0]),
                                             [](std::size_t v, const ColoredPart& p) { return v < p.first_vertex; });
        const auto part = std::size_t(behind - rig.part_colors.begin()) - 1;
        if (!parts[part].surface) continue;
        const TexturedSurface& surface = *parts[part].surface;
        for (std::uint32_t& corner : corners) corner -= std::uint32_t(surface.part.first_vertex);
        const auto room =
            double(kMaxValues - std::min(builder.size(), kMaxValues - 1)) / double(rig.source_corners.size() - t);
        const int most = std::max(1, int(std::min(std::sqrt(room) * 4, double(kMaxOpacityPieces))));
        builder.add(t, valuesOf(surface, corners, std::min(opacityPieces(surface, corners), most)));
    }
    rig.mesh.opacity = builder.take();
}

}  // namespace penumbra
