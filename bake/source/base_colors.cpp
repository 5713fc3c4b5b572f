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

#include "bake/source/textured_surface.h"
#include "formats/common/errors.h"
#include "formats/common/mesh_places.h"
#include "formats/common/write_file.h"

namespace penumbra {

namespace {

// Returns into how many pieces to cut each edge: one for each texel along the longest.
int piecesOf(const TexturedSurface& surface, const Triangle& triangle) {
    if (!surface.varies()) return 1;
    return std::clamp(int(std::min(std::ceil(texelsAlong(surface, triangle)), 1e6)), kMinPieces, kMaxPieces);
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

void addTriangles(const Mesh& mesh, const TexturedSurface& surface, ColorSums& sums) {
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
void addLoneVertices(const Mesh& mesh, const TexturedSurface& surface, ColorSums& sums) {
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
    const std::vector<std::uint32_t> first = firstOfPlaces(rig.mesh.rest_positions, rig.skin, rig.mesh.morphs);
    std::vector<std::uint32_t> donor_of_place(first.size(), UINT32_MAX), donors;
    for (std::uint32_t v = 0; v < first.size(); ++v)
        if (sums.weights[v] > 0) donor_of_place[first[v]] = std::min(donor_of_place[first[v]], v);
    for (std::uint32_t v = 0; v < first.size(); ++v) {
        const bool lacks = !(sums.weights[v] > 0) && donor_of_place[first[v]] != UINT32_MAX;
        donors.push_back(lacks ? donor_of_place[first[v]] : v);
    }
    return donors;
}

// Gives points that no vertex of the file leads to the colour of what they are the other side of.
void addBackPoints(const Rig& rig, ColorSums& sums) {
    for (std::size_t t = 0; t < rig.source_corners.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t point = rig.mesh.triangles[t][k];
            const std::uint32_t front = rig.mesh.source_vertex[rig.source_corners[t][k]];
            if (!(sums.weights[point] > 0) && sums.weights[front] > 0)
                sums.add(point, sums.weights[front], sums.colors[front] / sums.weights[front]);
        }
}

}  // namespace

BaseColors readBaseColors(const Rig& rig, const std::string& file) {
    const Mesh& mesh = rig.mesh;
    BaseColors out;
    TexturePictures pictures;
    ColorSums sums{std::vector<Vec3d>(mesh.vertexCount()), std::vector<double>(mesh.vertexCount())};
    std::vector<TexturedSurface> surfaces;
    for (const ColoredPart& part : rig.part_colors) {
        const MaterialColor& material = part.color.material;
        const std::string where = file + ": slot '" + mesh.slots[part.slot] + "'";
        if (!material.problem.empty()) throw InvalidInput(material.problem);
        if (!material.base) throw BadOption("albedo", "is needed: " + where + " has no base colour");
        surfaces.push_back({part, material.texture ? pictures.open(*material.texture, where, out.pictures) : nullptr});
        out.textured = out.textured || material.texture;
    }
    for (const TexturedSurface& surface : surfaces) addTriangles(mesh, surface, sums);
    for (const TexturedSurface& surface : surfaces) addLoneVertices(mesh, surface, sums);
    addBackPoints(rig, sums);
    const std::vector<std::uint32_t> donors = colorDonors(rig, sums);
    for (const std::uint32_t v : donors) out.colors.push_back(toFloat(sums.colors[v] / sums.weights[v]));
    return out;
}

}  // namespace penumbra
