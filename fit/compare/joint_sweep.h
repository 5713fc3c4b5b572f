#pragma once
// Finds the vertex and the joint of a bake that best show how visibility changes as one joint turns (Nowrouzezahrai
// 2009, figure 6).
#include <optional>
#include <string>
#include <vector>

#include "fit/compare/joint_turn.h"
#include "formats/stage/model_file.h"

namespace penumbra {

// The data of figure 6.
struct JointSweep {
    std::uint32_t vertex = 0;
    std::string joint_name;
    JointTurn turn;
    std::vector<double> baked_angles, baked_ambient;  // [F] radians; [F] E of the vertex
    std::vector<bool> baked_held_out;                 // [F]
    double explained = 0;        // share of the variance of E over training frames that the angle explains
    std::vector<double> angles;  // radians, the points of the curves
};
// Chooses among up to 1500 vertices and all joints. It takes the pair with the largest (variance of E that a step
// function of the angle explains)^2 / variance of E. It returns nothing when no joint turns, or when the mesh has no
// skeleton.
std::optional<JointSweep> findJointSweep(const CompareInput& input, const CompareCharacter& character,
                                         const CompareOptions& options);

// Returns E of the vertex at each of sweep.angles, as `model` predicts it.
std::vector<double> sweepAmbient(const CompareInput& input, const JointSweep& sweep, const Model& model);

}  // namespace penumbra
