#pragma once
// Turns a bake's model-frame moments into the numbers of a convention in the vertices' local frames, frame by frame.
#include <functional>
#include <span>
#include <vector>

#include "fit/clusters/pose_table.h"
#include "fit/numerics/matrix.h"
#include "formats/stage/visibility_file.h"
#include "sh/indirect_numbers.h"
#include "sh/visibility_convention.h"

namespace penumbra {

// The function that the numbers describe. kCosineWeighted numbers are the moments of V(s) max(s.N, 0). They are 0 below
// the horizon whatever the convention (A or B) says. They are exact, which takes moments of one order more.
enum class Target { kVisibility, kCosineWeighted };
// kGlobal is the same function in the model frame. With convention A it has the 1 below the vertex' own horizon.
enum class Frame { kLocal, kGlobal };
// Which moments of the file the numbers come from: those of all that blocks rays, or of nearby parts alone.
enum class Occluders { kAll, kLocalParts };

// Computes the moments of z f(s), order^2 of them, from those of f, (order + 1)^2: z y_lm = a(l+1,m) y_(l+1)m + a(l,m)
// y_(l-1)m with a(l,m)^2 = (l^2 - m^2) / (4 l^2 - 1).
void timesZ(int order, std::span<const float> moments, std::span<float> out);

// Tells where each vertex' local frame comes from.
struct LocalFrames {
    const std::vector<Vec3>* rest_tangents = nullptr;               // [V]
    const std::vector<std::uint32_t>* cluster_of_vertex = nullptr;  // [V]
    std::span<const int> joint_of_cluster;
};

// Asks for the numbers of some clusters in all frames. result[i] is [F, Vc n], with the vertices in the order of
// vertices_of_cluster[i]. The file is read once, in ranges of vertices, and only those ranges that hold a vertex of
// these clusters. Besides the result this needs about 32 MB.
struct ClusterNumbersRequest {
    Convention convention;
    LocalFrames frames;
    std::span<const std::vector<std::uint32_t>> vertices_of_cluster;
    Target target = Target::kVisibility;
    Frame frame = Frame::kLocal;
    Occluders occluders = Occluders::kAll;
    // Where it is set, the numbers are those of the indirect transfer (sh/indirect_numbers.h) in these colours, from a
    // bake with bounces, instead of those of a convention.
    const ColorAxes* indirect = nullptr;
    int threads = 0;
    // The function is told how many more of the asked vertices are done. It may be empty.
    std::function<void(std::size_t)> vertices_done;

    std::size_t numbersOfVertex() const { return indirect ? kIndirectNumbers : std::size_t(convention.size()); }
};
std::vector<MatrixF> readClusterNumbers(const VisibilityReader& reader, const PoseTable& poses,
                                        const ClusterNumbersRequest& request);

}  // namespace penumbra
