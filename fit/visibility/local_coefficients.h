#pragma once
// Turns a bake's model-frame moments into the numbers of a convention in the vertices' local frames, frame by frame.
#include <functional>
#include <span>
#include <vector>

#include "fit/clusters/pose_table.h"
#include "fit/numerics/matrix.h"
#include "formats/stage/visibility_file.h"
#include "sh/indirect_coefficients.h"
#include "sh/sh_rotation.h"
#include "sh/visibility_convention.h"

namespace penumbra {

// How the moments of a vertex become the numbers that a model learns. A model that becomes a file has kVisibilityForm.
// Comparisons have others (fit/papers/compare/paper_forms.h).
struct NumberForm {
    // Writes the numbers of a vertex, from moments in its local frame and the rotation of these to the model frame.
    void (*convert)(const Convention& convention, std::span<const float> local, const ShRotation& to_model,
                    std::span<float> coefficients);
    // Returns the weights that give E from the numbers. They are empty where no weights do.
    std::vector<float> (*ambient_weights)(const Convention& convention);
    int more_bands = 0;  // that the moments need beside those of the convention
    bool clamp = true;   // predictions are moved to where E lies in [0, 1], as Predictor and the run time do
};
extern const NumberForm kVisibilityForm;
// Which moments of the file the numbers come from: those of all that blocks rays, or of nearby parts alone.
enum class Occluders { kAll, kLocalParts };

// Tells where each vertex' local frame comes from.
struct LocalFrames {
    const std::vector<Vec3>* rest_tangents = nullptr;               // [V]
    const std::vector<std::uint32_t>* cluster_of_vertex = nullptr;  // [V]
    std::span<const int> joint_of_cluster;
};

// Asks for the numbers of some clusters in all frames. result[i] is [F, Vc n], with the vertices in the order of
// vertices_of_cluster[i]. The file is read once, in ranges of vertices, and only those ranges that hold a vertex of
// these clusters. Besides the result this needs about 32 MB.
struct ClusterCoefficientsRequest {
    Convention convention;
    LocalFrames frames;
    std::span<const std::vector<std::uint32_t>> vertices_of_cluster;
    const NumberForm* form = &kVisibilityForm;
    Occluders occluders = Occluders::kAll;
    // Where it is set, the numbers are those of the indirect transfer (sh/indirect_coefficients.h) in these colours,
    // from a bake with bounces, instead of those of a convention.
    const ColorAxes* indirect = nullptr;
    int threads = 0;
    // The function is told how many more of the asked vertices are done. It may be empty.
    std::function<void(std::size_t)> vertices_done;

    std::size_t coefficientsOfVertex() const { return indirect ? kIndirectSize : std::size_t(convention.size()); }
};
std::vector<MatrixF> readClusterCoefficients(const VisibilityReader& reader, const PoseTable& poses,
                                             const ClusterCoefficientsRequest& request);

}  // namespace penumbra
