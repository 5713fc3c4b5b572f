// Measures how fast the models of paper 002 shade a frame, against the paper's table 1 (Master Pai: 11,534 vertices, 54
// angles): PCA(8,22) 105 Hz, PCA(15,500) 34 Hz, L 65 Hz. One thread, RGB light. The numbers of the models are random,
// which changes no time.
//   bench_transfer
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <random>
#include <vector>

#include "fit/transfer/predict_transfer.h"

namespace {

using namespace penumbra;

constexpr std::size_t kVertices = 11534, kAngles = 54;

std::vector<float> randomNumbers(std::size_t count) {
    std::mt19937 random{7};
    std::uniform_real_distribution<float> uniform(-1, 1);
    std::vector<float> values(count);
    for (float& x : values) x = uniform(random);
    return values;
}

// k 0: the linear model.
TransferModel randomModel(std::size_t k, std::size_t m) {
    TransferModel model;
    model.mesh.rest_positions.resize(kVertices);
    model.pose_size = int(kAngles);
    for (std::size_t i = 0; i < kAngles; ++i) model.angles.push_back(std::uint32_t(i));
    if (k == 0) {
        model.kind = TransferModelKind::kLinear;
        model.weights = randomNumbers(36 * (kAngles + 1) * kVertices);
        return model;
    }
    model.pose_basis = randomNumbers(kAngles * k);
    model.weights = randomNumbers(36 * (k + 1) * m);
    model.basis = randomNumbers(m * kVertices);
    model.mean = randomNumbers(kVertices);
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
    const std::vector<float> pose = randomNumbers(kAngles), light = randomNumbers(3 * 36);
    std::vector<float> out(3 * kVertices);
    const LitTransfer lit = contractLight(model, light);
    const double fixed = milliseconds([&] { shadeTransfer(model, lit, pose, out); });
    const double moving = milliseconds([&] { shadeTransfer(model, contractLight(model, light), pose, out); });
    const double transfer = milliseconds([&] {
        const std::vector<float> t = predictTransfer(model, pose, 1);
        for (std::size_t v = 0; v < kVertices; ++v)
            for (std::size_t channel = 0; channel < 3; ++channel) {
                float sum = 0;
                for (std::size_t c = 0; c < 36; ++c) sum += light[3 * c + channel] * t[36 * v + c];
                out[channel * kVertices + v] = sum;
            }
    });
    std::printf("%-12s %10zu %9.3f %8.0f %9.3f %8.0f %9.3f %8.0f %8.0f\n", name, paperBytes(model), fixed, 1000 / fixed,
                moving, 1000 / moving, transfer, 1000 / transfer, paper_hz);
}

}  // namespace

int main() {
    std::printf("%-12s %10s %18s %18s %18s %8s\n", "", "", "light first,", "light first,", "transfer, then", "");
    std::printf("%-12s %10s %9s %8s %9s %8s %9s %8s %8s\n", "model", "bytes", "fixed ms", "Hz", "moving ms", "Hz",
                "light ms", "Hz", "paper Hz");
    measure("PCA(8,22)", randomModel(8, 22), 105);
    measure("PCA(15,500)", randomModel(15, 500), 34);
    measure("L", randomModel(0, 0), 65);
}
