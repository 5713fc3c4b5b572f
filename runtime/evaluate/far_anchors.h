#pragma once
// Chooses the anchors of a composed asset (far_kernel.h): some vertices of each part, at which the far parts that block
// little are summed for all vertices around. docs/formulas.md, section 7, tells what that costs.
#include <cstdint>
#include <vector>

#include "formats/asset/asset_file.h"
#include "sh/far/far_tables.h"

namespace penumbra {

// Vertices of one part in one cluster, which the kernel evaluates together.
struct FarRun {
    std::uint16_t part = 0;
    std::uint32_t first = 0, count = 0;                // in FarLayout::receivers
    std::uint32_t first_anchor = 0, anchor_count = 0;  // in FarLayout::anchors; 0: the part has no anchors
    std::size_t first_value = 0;                       // where the values of its anchors begin
    float spacing = 0;                                 // mean distance of a vertex from its anchors, at rest
};

// Runs of one cluster use anchors of other clusters too, so that no seam shows where two of them meet. They evaluate
// these once more, so that clusters stay independent.
struct FarLayout {
    std::vector<FarRun> runs;
    std::vector<std::uint32_t> first_run;  // [clusters + 1]
    std::vector<std::uint32_t> receivers;  // [V] vertices: of each cluster by part, neighbours together
    std::vector<std::uint16_t> anchor;     // [V, 4] of each receiver, index into the anchors of its run
    std::vector<float> weight;             // [V, 4], rows sum to 1
    std::vector<std::uint32_t> anchors;    // vertices
    std::size_t values = 0;                // floats that the anchors of all runs take
};

// Lays out the fields of an asset. Local visibilities have `order` bands.
FarTables makeFarTables(const CompositionView& composition, int order);

// `part_counts` tells how many far parts the vertices of each part see.
FarLayout makeFarLayout(const AssetView& asset, const std::vector<std::size_t>& part_counts, FarQuality quality);

// The anchors of any asset with a model, at which others cast on it (CastShadow). There is one run for each cluster.
// `part` is the cluster, and there is no room for values.
FarLayout makeCastLayout(const AssetView& asset);

}  // namespace penumbra
