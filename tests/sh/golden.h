#pragma once
// Golden vectors: tests/golden/*.json, each with what it is ("what") and the tolerance that it asks for ("tol").
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "sh/vec3.h"

namespace penumbra {

inline nlohmann::json readGolden(const std::string& name) {
    std::ifstream in(std::string(PENUMBRA_SOURCE_DIR) + "/tests/golden/" + name);
    return nlohmann::json::parse(in);
}

inline std::vector<double> doubles(const nlohmann::json& values) { return values.get<std::vector<double>>(); }
inline Vec3d vec3(const nlohmann::json& v) { return {v.at(0), v.at(1), v.at(2)}; }

// Each element within `tolerance` of the golden one, absolutely or relative to the largest golden value above 1.
inline void expectNear(std::span<const double> actual, std::span<const double> expected, double tolerance) {
    ASSERT_EQ(actual.size(), expected.size());
    for (std::size_t i = 0; i < actual.size(); ++i)
        EXPECT_NEAR(actual[i], expected[i], tolerance * std::max(1.0, std::abs(expected[i]))) << "element " << i;
}

// A symmetric n x n matrix from [i, j, value] with i <= j.
inline std::vector<double> symmetricMatrix(const nlohmann::json& entries, int n) {
    std::vector<double> matrix(std::size_t(n) * n);
    for (const auto& entry : entries) {
        const int i = entry.at(0), j = entry.at(1);
        matrix[i * n + j] = matrix[j * n + i] = entry.at(2);
    }
    return matrix;
}

}  // namespace penumbra
