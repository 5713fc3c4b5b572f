#pragma once
// The options of a comparison say what it varies, and its character is what a fit at the reference sees. The defaults
// here are the documented ones, and no other place holds a default.
#include <string>
#include <vector>

#include "fit/clusters/vertex_clusters.h"
#include "fit/models/features.h"
#include "fit/visibility/local_coefficients.h"
#include "fit/visibility/split_frames.h"
#include "formats/stage/field_file.h"

namespace penumbra {

// There is one list for each thing that is varied. All combinations would be too many, so every figure varies one thing
// and holds the others at the reference. The reference is the middle value of a list of numbers (of an even count, the
// upper one) and the first convention.
struct CompareOptions {
    std::vector<ModelKind> models{kModelKinds.begin(), kModelKinds.end()};
    // The papers' features come first. Meshes without a skeleton have dihedral-angles in place of joint-angles.
    std::vector<FeatureKind> features{FeatureKind::kJointAngles, FeatureKind::kRelativeBones};
    int parts = 0;  // near-rigid parts of such meshes; 0 lets fit/clusters/rigid_parts.h choose
    std::vector<int> clusters{8, 16, 32, 64};                    // ascending
    std::vector<double> output_variances{0.8, 0.9, 0.95, 0.99};  // ascending
    std::vector<Convention> conventions;                         // the papers' A4, and D5
    // Fields of the far parts. With them a composed model is a row of the summary, beside the additive one that has the
    // same convention. It is no part of the figures, which vary one thing of models that the papers could have made.
    std::vector<FieldFile> fields;
    std::vector<int> lobes;  // counts, 1..3, of Nowrouzezahrai 2008's model (lobe_models.h); empty: without it
    std::vector<std::string> holdout;
    int threads = 0;

    int referenceClusters() const { return clusters[clusters.size() / 2]; }
    double referenceVariance() const { return output_variances[output_variances.size() / 2]; }
    Convention referenceConvention() const { return conventions.front(); }
};

struct CompareInput {
    const VisibilityReader& reader;
    const PoseTable& poses;
    std::string file;  // names the reader's file in messages
};

struct CompareCharacter : Split {
    VertexClusters clusters;
    std::vector<Vec3> rest_tangents;

    LocalFrames frames() const { return {&rest_tangents, &clusters.cluster_of_vertex, clusters.joint}; }
};
CompareCharacter prepareCharacter(const CompareInput& input, const CompareOptions& options);

// Returns the request for numbers in a convention and on the options' threads, but for the vertices.
ClusterCoefficientsRequest requestFor(const CompareCharacter& character, const Convention& convention, int threads);
// Returns the recipe of features for all of its clusters.
FeatureRecipe recipeFor(const CompareInput& input, FeatureKind kind);

}  // namespace penumbra
