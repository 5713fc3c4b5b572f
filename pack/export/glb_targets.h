#pragma once
// The primitives of a .glb that an export writes to.
#include <span>
#include <vector>

#include "formats/rig/growing_glb.h"
#include "formats/rig/rig_file.h"
#include "pack/export/export_rows.h"

namespace penumbra {

// A primitive as one node draws it. Its vertices have one range of rows for each instance, which share their values.
struct GlbTarget {
    std::size_t node = 0, mesh = 0, primitive = 0;  // indices in the document
    std::vector<std::size_t> parts;                 // indices into Rig::part_colors, at least one
};

// Finds the primitives of the rows' parts, in the order of the file. A mesh that several nodes draw has another
// occlusion on each: the nodes get meshes of their own, which share all that the mesh had, and a note says so.
std::vector<GlbTarget> findTargets(const Rig& rig, const ExportRows& rows, GrowingGlb& glb);

nlohmann::ordered_json& primitiveOf(GrowingGlb& glb, const GlbTarget& target);

// Returns the values of the target's vertices: those of its rows, or the mean over its instances.
template <class Number>
std::vector<Number> valuesOf(const Rig& rig, const GlbTarget& target, const std::vector<Number>& of_rows) {
    const ColoredPart& first = rig.part_colors[target.parts[0]];
    std::vector<Number> out(first.vertices);
    for (std::size_t v = 0; v < out.size(); ++v) {
        out[v] = of_rows[first.first_vertex + v];
        for (std::size_t i = 1; i < target.parts.size(); ++i)
            out[v] += of_rows[rig.part_colors[target.parts[i]].first_vertex + v];
        if (target.parts.size() > 1) out[v] = out[v] * (1.0f / float(target.parts.size()));
    }
    return out;
}

// Writes into asset.extras what the file is (docs/exports.md). Throws InvalidInput where it is an export already, whose
// occlusion would count twice.
void markExport(GrowingGlb& glb, nlohmann::ordered_json mark);

}  // namespace penumbra
