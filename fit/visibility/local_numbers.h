#pragma once
// From a bake's model-frame moments to the numbers of a convention in the vertices' local frames, frame by frame.
#include <functional>
#include <span>
#include <vector>

#include "fit/clusters/pose_table.h"
#include "fit/numerics/matrix.h"
#include "formats/stage/visibility_file.h"
#include "sh/visibility_convention.h"

namespace penumbra {

// What the numbers are of. kCosineWeighted: moments of V(s) max(s.N, 0), 0 below the horizon whatever the convention
// (A or B) says; exact, so it takes moments of one order more.
enum class Target { kVisibility, kCosineWeighted };
// kGlobal: the same functions in the model frame (convention A: with the 1 below the vertex' own horizon).
enum class Frame { kLocal, kGlobal };

// Moments of z f(s), order^2 of them, from those of f, (order + 1)^2: z y_lm = a(l+1,m) y_(l+1)m + a(l,m) y_(l-1)m with
// a(l,m)^2 = (l^2 - m^2) / (4 l^2 - 1).
void timesZ(int order, std::span<const float> moments, std::span<float> out);

// Where each vertex' local frame comes from.
struct LocalFrames {
    const std::vector<Vec3>* rest_tangents = nullptr;               // [V]
    const std::vector<std::uint32_t>* cluster_of_vertex = nullptr;  // [V]
    std::span<const int> joint_of_cluster;
};

// Numbers of the asked clusters in all frames: result[i] is [F, Vc n] with the vertices as in vertices_of_cluster[i].
// One pass over the file in vertex ranges, reading only ranges that hold a vertex of these clusters; beside the result
// it needs about 32 MB.
struct ClusterNumbersRequest {
    Convention convention;
    LocalFrames frames;
    std::span<const std::vector<std::uint32_t>> vertices_of_cluster;
    Target target = Target::kVisibility;
    Frame frame = Frame::kLocal;
    int threads = 0;
    std::function<void(std::size_t)> vertices_done;  // how many more of the asked vertices are there; may be empty
};
std::vector<MatrixF> readClusterNumbers(const VisibilityReader& reader, const PoseTable& poses,
                                        const ClusterNumbersRequest& request);

}  // namespace penumbra
