#pragma once
// Spheres that move with the bones of a character and stand for it when it casts (docs/formulas.md, section 9).
#include <optional>
#include <string>
#include <vector>

#include "fit/blockers/refine_radii.h"
#include "formats/common/words.h"
#include "formats/stage/blocker_file.h"
#include "formats/stage/model_file.h"

namespace penumbra {

enum class BlockerMethod {
    kArea,  // k-means of points spread evenly over the surface, mean distances as radii, silhouettes of the right area
    kPaper  // Nowrouzezahrai 2009, section 7: k-means of the vertices, with spheres that hold all of their vertices
};
inline constexpr Word<BlockerMethod> kBlockerMethodWords[] = {{"area", BlockerMethod::kArea},
                                                              {"paper", BlockerMethod::kPaper}};
constexpr std::string_view nameOf(BlockerMethod method) { return wordOf(kBlockerMethodWords, method); }

struct BlockerOptions {
    int spheres = 15;  // 1..kMaxBlockers
    BlockerMethod method = BlockerMethod::kArea;
    std::uint64_t seed = 1;
    bool refine = false;  // refineRadii() after the one factor; of kArea
};

struct FootBlockers {
    std::string joint;
    int spheres = 0;
};

struct BlockerFit {
    SphereBlockers blockers;
    double scale = 1;             // factor on the method's radii
    double mesh_area = 0;         // m^2, mean silhouette of the mesh over poses and views
    double area = 0;              // m^2, mean silhouette of the spheres over the same
    double silhouette_error = 0;  // rms over poses and views of the area of the spheres - that of the mesh, / mesh_area
    double rigid_share = 0;       // share of the points whose own joint is that of their sphere
    std::size_t poses = 0, views = 0;
    std::vector<FootBlockers> feet;  // set by kArea
    std::optional<RadiusRefinement> refinement;
};

// Fits blockers to the rest mesh of a model, and scales them by training frames (by the rest pose where the model has
// none). Throws InvalidInput where the mesh has no area or the model no joints that move it. The result is the same for
// any number of threads.
BlockerFit fitBlockers(const Model& model, const BlockerOptions& options, int threads);

// The steps of it, for tests. Groups the points around `count` centers: a foot (-1: none) gets two spheres at least,
// and more by its share of the points, as long as a sphere is left for the rest. Radii are mean distances.
struct SurfaceSamples;
struct GroupedBlockers {
    SphereBlockers blockers;
    std::vector<std::uint32_t> sphere_of_point;  // [N]
};
GroupedBlockers groupBlockers(const SurfaceSamples& samples, std::span<const int> foot_of_joint, int count,
                              std::uint64_t seed);
// Returns the spheres of the papers' method.
GroupedBlockers boundVertices(const SurfaceSamples& samples, int count, std::uint64_t seed);

}  // namespace penumbra
