// Measures how fast the run time shades a frame with the linear models of transfer, against the paper's table 1 (Master
// Pai: 11,534 vertices, 54 angles): PCA(8,22) 105 Hz, PCA(15,500) 34 Hz, L 65 Hz. One thread, RGB light of order 6. A
// frame is the pose, and the light that reaches every vertex. The numbers of the models are random, which changes no
// time.
//   bench_transfer
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <random>
#include <vector>

#include "pack/pack_transfer.h"
#include "runtime/evaluate/evaluator.h"

namespace {

using namespace penumbra;

constexpr std::size_t kVertices = 11534, kJoints = 18, kAngles = 3 * kJoints;

std::vector<float> randomCoefficients(std::size_t count) {
    std::mt19937 random{7};
    std::uniform_real_distribution<float> uniform(-1, 1);
    std::vector<float> values(count);
    for (float& x : values) x = uniform(random);
    return values;
}

// Points of which the first joint moves all.
TransferModel randomCharacter() {
    TransferModel model;
    const std::vector<float> places = randomCoefficients(3 * kVertices);
    for (std::size_t v = 0; v < kVertices; ++v)
        model.mesh.rest_positions.push_back({places[3 * v], places[3 * v + 1], places[3 * v + 2]});
    model.rest_normals.assign(kVertices, {0, 1, 0});
    for (std::size_t j = 0; j < kJoints; ++j) model.skin.joint_names.push_back("joint" + std::to_string(j));
    model.skin.parents.assign(kJoints, -1);
    model.skin.influences = 1;
    model.skin.joints.assign(kVertices, 0);
    model.skin.weights.assign(kVertices, 1);
    model.frames = {{"still"}, {0}, {0}};
    model.bones.assign(kJoints, Affine());
    model.pose_size = int(kAngles);
    model.pose = randomCoefficients(kAngles);
    for (std::size_t i = 0; i < kAngles; ++i) model.angles.push_back(std::uint32_t(i));
    return model;
}

// k 0: the linear model.
TransferModel randomModel(std::size_t k, std::size_t m) {
    TransferModel model = randomCharacter();
    if (k == 0) {
        model.kind = TransferModelKind::kLinear;
        model.weights = randomCoefficients(36 * (kAngles + 1) * kVertices);
        return model;
    }
    model.pose_basis = randomCoefficients(kAngles * k);
    model.weights = randomCoefficients(36 * (k + 1) * m);
    model.basis = randomCoefficients(m * kVertices);
    model.mean = randomCoefficients(kVertices);
    return model;
}

// The least time of a call among as many as fit into half a second, in milliseconds.
template <class Body>
double milliseconds(const Body& body) {
    using Clock = std::chrono::steady_clock;
    double least = 1e9;
    int runs = 0;
    for (const auto end = Clock::now() + std::chrono::milliseconds(500); Clock::now() < end || runs < 3; ++runs) {
        const auto start = Clock::now();
        body();
        least = std::min(least, std::chrono::duration<double, std::milli>(Clock::now() - start).count());
    }
    return least;
}

void measure(const char* name, const TransferModel& model, double paper_hz) {
    const std::vector<std::byte> bytes = packTransfer(model, std::vector{diffuseMaterial({1, 1, 1})}, {}, {}, "{}");
    const AssetView asset = openAsset(bytes, name);
    const std::vector<float> coefficients = randomCoefficients(2 * 3 * 36);
    std::array<std::vector<Vec3>, 2> lights;
    for (std::size_t i = 0; i < 72; ++i)
        lights[i / 36].push_back({coefficients[3 * i], coefficients[3 * i + 1], coefficients[3 * i + 2]});
    for (const TransferPath& path : transferPaths()) {
        TransferEvaluator evaluator(asset);
        evaluator.usePath(path);
        evaluator.setLight(lights[0]);
        std::vector<Vec3> out(kVertices);
        const auto shade = [&] {
            evaluator.setPose(model.pose);
            evaluator.irradiance(0, kVertices, out);
        };
        const double fixed = milliseconds(shade);
        std::size_t run = 0;
        const double moving = milliseconds([&] {
            evaluator.setLight(lights[++run % 2]);
            shade();
        });
        std::vector<float> transfer(36 * kVertices);
        const double after = milliseconds([&] {
            evaluator.setPose(model.pose);
            evaluator.transfer(0, kVertices, 36, transfer);
            for (std::size_t v = 0; v < kVertices; ++v) {
                Vec3 sum;
                for (std::size_t c = 0; c < 36; ++c) sum += lights[0][c] * transfer[36 * v + c];
                out[v] = sum;
            }
        });
        std::printf("%-12s %-9s %10zu %9.3f %8.0f %9.3f %8.0f %9.3f %8.0f %8.0f\n", name, path.name, paperBytes(model),
                    fixed, 1000 / fixed, moving, 1000 / moving, after, 1000 / after, paper_hz);
    }
}

}  // namespace

int main() {
    std::printf("%-12s %-9s %10s %18s %18s %18s %8s\n", "", "", "", "light first,", "light first,", "transfer, then",
                "");
    std::printf("%-12s %-9s %10s %9s %8s %9s %8s %9s %8s %8s\n", "model", "path", "bytes", "fixed ms", "Hz",
                "moving ms", "Hz", "light ms", "Hz", "paper Hz");
    measure("PCA(8,22)", randomModel(8, 22), 105);
    measure("PCA(15,500)", randomModel(15, 500), 34);
    measure("L", randomModel(0, 0), 65);
}
