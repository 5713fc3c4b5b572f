#pragma once
// A small asset in memory: a sphere on three joints with bumpy weights. Its model has numbers that are made up but of
// plausible size. It has a truth of unoccluded vertices, fitted materials and a light, and needs neither a file nor
// the packer.
#include <random>
#include <span>
#include <string>
#include <vector>

#include "formats/asset/asset_file.h"
#include "runtime/shade/exact_light_lobes.h"
#include "sh/brdf/brdf.h"

namespace penumbra::player_test {

// Returns the slices of one analytic BRDF, [J^2, E] (docs/formulas.md, section 3), by quadrature and cosine-weighted
// least squares, on `grid` heights times 2 grid azimuths of the view.
std::vector<float> fitSlices(const BrdfSpec& spec, int grid = 10);

struct AssetRecipe {
    std::string convention = "D5";
    AssetPrecision precision = AssetPrecision::kF32;
    bool mixed = false;            // instead of `precision`: each cluster another one than those before and after it
    int rings = 24;                // rings of the sphere, which has rings * 2 rings + 2 vertices
    float basis_size = 0.05f;      // size of the PCA components; 0: the model's numbers are the mean in every pose
    bool open = false;             // mean = unoccluded, else darkened from vertex to vertex
    Vec3 light_from{-1, 1, 0.5f};  // where most of the light comes from
    float light_ambient = 0.4f;    // radiance that comes from everywhere
    float light_lobe = 1;          // size of the directed part, a clamped cosine
    int light_order = 4;           // order of "sky"
    int slots = 0;                 // parts "part0", "part1", ... with materials 0, 1, ...; each vertex has another one
                                   // than its neighbours
};

// Owns what `asset` and `truth` look at. The clips are "swing" (3 frames) and "still" (1 frame). The materials are
// "lambert", "ggx" and "tinted" (three channels), each also as operators that are the slices exactly. The lights are
// "sky" and "even" (order 2, radiance 1 from everywhere), each also as lobes that are the light exactly.
class SyntheticAsset {
public:
    explicit SyntheticAsset(const AssetRecipe& recipe = {});
    SyntheticAsset(const SyntheticAsset&) = delete;
    AssetView asset, truth;

private:
    std::vector<std::vector<float>> operators_;  // u, w of each material
    std::vector<LightLobes> lobes_;
    std::vector<std::vector<float>> lobe_numbers_;
    std::vector<std::string> slot_names_;
    std::vector<std::uint16_t> slot_of_vertex_;
    void makeMesh(const AssetRecipe& recipe);
    void makeAnimation();
    void makeClusters(const AssetRecipe& recipe);
    void makeTruth();
    void makeMaterials();
    void makeLights(const AssetRecipe& recipe);
    void addOperators();
    void addLobes();
    void makeSlots(const AssetRecipe& recipe);

    std::vector<Vec3> positions_, tangents_;
    std::vector<std::uint32_t> triangles_, shading_point_;
    std::vector<std::uint16_t> skin_joints_;
    std::vector<float> skin_weights_;
    std::vector<double> times_;
    std::vector<Affine> bones_;
    std::vector<Vec3> joint_centers_;
    std::vector<Mat3> joint_spreads_;
    struct ClusterData {
        std::vector<float> feature_mean, input_basis, input_min, input_max, weights, bias, scale;
        std::vector<float> mean, basis;
        std::vector<std::uint16_t> mean_half, basis_half;
        std::vector<std::int8_t> basis_bytes;
    };
    static void fillRegression(ClusterData& data, std::mt19937& random);
    ClusterView makeCluster(const AssetRecipe& recipe, std::span<const float> open, ClusterData& data,
                            std::uint32_t count, std::mt19937& random);
    std::vector<ClusterData> clusters_;
    std::vector<float> truth_, lambert_, ggx_, tinted_, sky_, even_;
};

}  // namespace penumbra::player_test
