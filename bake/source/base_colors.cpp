// Finds one colour for each vertex of a textured mesh.
//
// Problem: a texture has many texels between one vertex and the next, and a bake has one albedo a vertex, which
// triangles interpolate.
//
// Naive: take the texel at the vertex' texture coordinates. One texel of a pattern says little about the surface around
// it, and at a seam each side has another.
//
// Here: a vertex has the mean colour of all triangles around it, weighted by area and by the hat function that is 1 at
// the vertex and 0 at its neighbours: c_v = sum of hat c dA / sum of hat dA. Interpolated over the mesh these colours
// then reflect as much light in total as the texture does. The integrals are sums over equal pieces of each triangle,
// about one a texel. All source vertices that are one shading point add to the same sums, so seams need no care.
// Where a shading point joins parts of several slots only those of its own slot count, as everywhere else.
#include "bake/source/base_colors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "formats/common/errors.h"
#include "formats/common/mesh_places.h"
#include "formats/common/write_file.h"
#include "formats/image/image_file.h"
#include "formats/image/texture_file.h"

namespace penumbra {

namespace {

constexpr int kMinPieces = 4, kMaxPieces = 64;  // along an edge of a triangle whose colour varies

// A part of the rig with its picture.
struct Surface {
    const ColoredPart& part;
    const TexturePicture* picture = nullptr;  // null: none
    bool varies() const { return picture != nullptr || !part.color.tints.empty(); }
};

std::int64_t wrapped(std::int64_t i, std::int64_t size, TextureWrap wrap) {
    if (wrap == TextureWrap::kClamp) return std::clamp<std::int64_t>(i, 0, size - 1);
    const std::int64_t period = wrap == TextureWrap::kMirror ? 2 * size : size;
    const std::int64_t at = (i % period + period) % period;
    return at < size ? at : period - 1 - at;
}

Vec3d texel(const Surface& surface, std::int64_t column, std::int64_t row) {
    static const std::array<double, 256> linear = [] {
        std::array<double, 256> table;
        for (std::size_t i = 0; i < 256; ++i) table[i] = double(linearFromSrgb(float(i) / 255));
        return table;
    }();
    const TexturePicture& picture = *surface.picture;
    const MaterialColor& material = surface.part.color.material;
    const std::int64_t x = wrapped(column, picture.width, material.wrap_u);
    const std::int64_t y = wrapped(row, picture.height, material.wrap_v);
    const std::uint8_t* rgb = picture.rgb.data() + std::size_t(y * picture.width + x) * 3;
    return {linear[rgb[0]], linear[rgb[1]], linear[rgb[2]]};
}

// Interpolates the four texels around a place, whose centers are at half numbers.
Vec3d pictureAt(const Surface& surface, double u, double v) {
    const double x = u * surface.picture->width - 0.5, y = v * surface.picture->height - 0.5;
    const auto column = std::int64_t(std::floor(x)), row = std::int64_t(std::floor(y));
    const double s = x - double(column), t = y - double(row);
    return (1 - t) * ((1 - s) * texel(surface, column, row) + s * texel(surface, column + 1, row)) +
           t * ((1 - s) * texel(surface, column, row + 1) + s * texel(surface, column + 1, row + 1));
}

// Returns the colour at barycentric coordinates of a triangle.
Vec3d colorAt(const Surface& surface, const Triangle& triangle, const std::array<double, 3>& at) {
    const PartColor& color = surface.part.color;
    Vec3d out = toDouble(*color.material.base), tint;
    double u = 0, v = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        if (surface.picture) u += at[k] * color.uv[triangle[k]][0], v += at[k] * color.uv[triangle[k]][1];
        if (!color.tints.empty()) tint += at[k] * toDouble(color.tints[triangle[k]]);
    }
    if (surface.picture) out = out * pictureAt(surface, u, v);
    return color.tints.empty() ? out : out * tint;
}

// Returns into how many pieces to cut each edge: one for each texel along the longest.
int piecesOf(const Surface& surface, const Triangle& triangle) {
    if (!surface.varies()) return 1;
    double longest = 0;
    for (std::size_t k = 0; k < 3 && surface.picture; ++k) {
        const std::array<double, 2>&a = surface.part.color.uv[triangle[k]],
                                 &b = surface.part.color.uv[triangle[(k + 1) % 3]];
        longest = std::max(
            {longest, std::abs(b[0] - a[0]) * surface.picture->width, std::abs(b[1] - a[1]) * surface.picture->height});
    }
    return std::clamp(int(std::min(std::ceil(longest), 1e6)), kMinPieces, kMaxPieces);
}

// Calls visit(barycentric coordinates) at the middle of each of n^2 equal pieces of a triangle.
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

// Weighted sums of the colours around each shading point.
struct ColorSums {
    std::vector<Vec3d> colors;
    std::vector<double> weights;

    void add(std::uint32_t point, double weight, Vec3d color) {
        colors[point] += weight * color;
        weights[point] += weight;
    }
};

double areaOf(const Mesh& mesh, const std::array<std::uint32_t, 3>& points) {
    const Vec3d a = toDouble(mesh.rest_positions[points[0]]), b = toDouble(mesh.rest_positions[points[1]]),
                c = toDouble(mesh.rest_positions[points[2]]);
    return 0.5 * length(cross(b - a, c - a));
}

void addTriangles(const Mesh& mesh, const Surface& surface, ColorSums& sums) {
    const ColoredPart& part = surface.part;
    for (const Triangle& triangle : part.triangles) {
        throwIfInterrupted();
        std::array<std::uint32_t, 3> points;
        for (std::size_t k = 0; k < 3; ++k) points[k] = mesh.source_vertex[part.first_vertex + triangle[k]];
        const double area = areaOf(mesh, points);
        if (!(area > 0)) continue;
        const int n = piecesOf(surface, triangle);
        eachPiece(n, [&](const std::array<double, 3>& at) {
            const Vec3d color = colorAt(surface, triangle, at);
            for (std::size_t k = 0; k < 3; ++k)
                if (mesh.slot_of_vertex[points[k]] == part.slot)
                    sums.add(points[k], area * at[k] / (double(n) * n), color);
        });
    }
}

// Gives vertices without a triangle that has an area the colour at their own place.
void addLoneVertices(const Mesh& mesh, const Surface& surface, ColorSums& sums) {
    const ColoredPart& part = surface.part;
    for (std::uint32_t v = 0; v < part.vertices; ++v) {
        const std::uint32_t point = mesh.source_vertex[part.first_vertex + v];
        if (sums.weights[point] > 0 || mesh.slot_of_vertex[point] != part.slot) continue;
        sums.add(point, 1, colorAt(surface, {v, v, v}, {1, 0, 0}));
    }
}

// Returns for each point the one whose colour it has: itself, or another of its place where a vertex of the source
// became several points, of which the source names one.
std::vector<std::uint32_t> colorDonors(const Rig& rig, const ColorSums& sums) {
    const std::vector<std::uint32_t> first = firstOfPlaces(rig.mesh.rest_positions, rig.skin);
    std::vector<std::uint32_t> donor_of_place(first.size(), UINT32_MAX), donors;
    for (std::uint32_t v = 0; v < first.size(); ++v)
        if (sums.weights[v] > 0) donor_of_place[first[v]] = std::min(donor_of_place[first[v]], v);
    for (std::uint32_t v = 0; v < first.size(); ++v) {
        const bool lacks = !(sums.weights[v] > 0) && donor_of_place[first[v]] != UINT32_MAX;
        donors.push_back(lacks ? donor_of_place[first[v]] : v);
    }
    return donors;
}

// Opens each picture once. `where` names rig and slot.
class Pictures {
public:
    const TexturePicture* open(const Texture& texture, const std::string& where, BaseColors& out) {
        const auto [at, is_new] = opened_.try_emplace(&texture);
        if (!is_new) return &at->second;
        const std::string name = where + ": " + texture.name;
        if (texture.file.empty()) {
            at->second = decodeTexture(texture.bytes, name);
            return &at->second;
        }
        out.pictures.push_back(texture.file);
        try {
            at->second = readTexture(texture.file, name);
        } catch (const IoError& error) {
            throw IoError(name + ": " + error.what());
        }
        return &at->second;
    }

private:
    std::map<const Texture*, TexturePicture> opened_;
};

}  // namespace

BaseColors readBaseColors(const Rig& rig, const std::string& file) {
    const Mesh& mesh = rig.mesh;
    BaseColors out;
    Pictures pictures;
    ColorSums sums{std::vector<Vec3d>(mesh.vertexCount()), std::vector<double>(mesh.vertexCount())};
    std::vector<Surface> surfaces;
    for (const ColoredPart& part : rig.part_colors) {
        const MaterialColor& material = part.color.material;
        const std::string where = file + ": slot '" + mesh.slots[part.slot] + "'";
        if (!material.problem.empty()) throw InvalidInput(material.problem);
        if (!material.base) throw BadOption("albedo", "is needed: " + where + " has no base colour");
        surfaces.push_back({part, material.texture ? pictures.open(*material.texture, where, out) : nullptr});
        out.textured = out.textured || material.texture;
    }
    for (const Surface& surface : surfaces) addTriangles(mesh, surface, sums);
    for (const Surface& surface : surfaces) addLoneVertices(mesh, surface, sums);
    const std::vector<std::uint32_t> donors = colorDonors(rig, sums);
    for (const std::uint32_t v : donors) out.colors.push_back(toFloat(sums.colors[v] / sums.weights[v]));
    return out;
}

}  // namespace penumbra
