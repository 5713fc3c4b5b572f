#pragma once
// Which point of a source each vertex of a .glb is.
#include <string>
#include <vector>

#include "formats/common/drawn_mesh.h"
#include "formats/rig/rig_file.h"
#include "pack/export/export_options.h"
#include "pack/export/occlusion_source.h"

namespace penumbra {

// Rows are vertices of a .glb, in the order of node, primitive and vertex. A row takes its value from up to three
// points.
struct ExportRows {
    PointTable points;                  // [R]
    std::vector<std::size_t> parts;     // indices of Rig::part_colors that take part, ascending
    std::vector<std::string> left_out;  // slots of those that the source does not have
    std::size_t by_place = 0;           // rows that were found by where they are, not by their number
    double max_distance = 0;            // for a level of detail, in diagonals of the source

    std::size_t count() const { return points.corners.size(); }
};

// Without a .glb the rows are the source vertices.
ExportRows ownRows(const OcclusionSource& source);

// Matches the vertices of `rig` with those of the source: by their numbers where all stand where the source has them,
// or else by their places at rest and their normals. Parts without any match are left out. Throws InvalidInput, which
// names the part and how many of its vertices do not match, for a part that matches in pieces, and where nothing
// matches. A level of detail takes the nearest point of the source's surface instead.
ExportRows matchRows(const OcclusionSource& source, const Rig& rig, ExportMesh mesh, int threads);

// Returns the value of each row from those of the points.
template <class Number>
std::vector<Number> valuesOfRows(const ExportRows& rows, const std::vector<Number>& of_points) {
    std::vector<Number> out(rows.count());
    for (std::size_t r = 0; r < out.size(); ++r) {
        const Triangle& corners = rows.points.corners[r];
        const std::array<float, 3>& weights = rows.points.weights[r];
        // A row that is a point has its very value.
        out[r] = weights[0] == 1 ? of_points[corners[0]]
                                 : of_points[corners[0]] * weights[0] + of_points[corners[1]] * weights[1] +
                                       of_points[corners[2]] * weights[2];
    }
    return out;
}

}  // namespace penumbra
