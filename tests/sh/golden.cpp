#include "tests/sh/golden.h"

#include <gtest/gtest.h>

#include <fstream>

namespace penumbra {

nlohmann::json readGolden(const std::string& name) {
    std::ifstream in(std::string(PENUMBRA_SOURCE_DIR) + "/tests/golden/" + name);
    return nlohmann::json::parse(in);
}

std::vector<double> doubles(const nlohmann::json& values) { return values.get<std::vector<double>>(); }

Vec3d vec3(const nlohmann::json& v) { return {v.at(0), v.at(1), v.at(2)}; }

void expectNear(std::span<const double> actual, std::span<const double> expected, double tolerance) {
    ASSERT_EQ(actual.size(), expected.size());
    for (std::size_t i = 0; i < actual.size(); ++i)
        EXPECT_NEAR(actual[i], expected[i], tolerance * std::max(1.0, std::abs(expected[i]))) << "element " << i;
}

std::vector<double> symmetricMatrix(const nlohmann::json& entries, int n) {
    std::vector<double> matrix(std::size_t(n) * n);
    for (const auto& entry : entries) {
        const int i = entry.at(0), j = entry.at(1);
        matrix[i * n + j] = matrix[j * n + i] = entry.at(2);
    }
    return matrix;
}

}  // namespace penumbra
