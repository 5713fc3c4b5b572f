#pragma once
// Golden vectors, tests/golden/*.json. Each file says what it holds ("what") and which tolerance it asks for ("tol").
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "sh/vec3.h"

namespace penumbra {

nlohmann::json readGolden(const std::string& name);
std::vector<double> doubles(const nlohmann::json& values);
Vec3d vec3(const nlohmann::json& v);

// Expects each element within `tolerance` of the golden one, absolutely or relative to the largest golden value above
// 1.
void expectNear(std::span<const double> actual, std::span<const double> expected, double tolerance);

// Returns a symmetric n x n matrix from [i, j, value] with i <= j.
std::vector<double> symmetricMatrix(const nlohmann::json& entries, int n);

}  // namespace penumbra
