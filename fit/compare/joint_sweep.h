#pragma once
// One vertex as one joint turns (paper 000, figure 6): which vertex and joint of a bake show it best.
#include <optional>
#include <string>
#include <vector>

#include "fit/compare/joint_turn.h"
#include "formats/stage/model_file.h"

namespace penumbra {

// What figure 6 shows.
struct JointSweep {
    std::uint32_t vertex = 0;
    std::string joint_name;
    JointTurn turn;
    std::vector<double> baked_angles, baked_ambient;  // [F] radians, E of the vertex
    std::vector<bool> baked_held_out;                 // [F]
    double explained = 0;                             // share of the variance of E over training frames
    std::vector<double> angles;                       // of the curves, radians
};
// Of up to 1500 vertices and all joints the pair of the largest (variance of E that a step function of the angle
// explains)^2 / variance of E. Nothing when nothing turns.
std::optional<JointSweep> findJointSweep(const CompareInput& input, const CompareCharacter& character,
                                         const CompareOptions& options);

// E of the vertex at each of sweep.angles.
std::vector<double> sweepAmbient(const CompareInput& input, const JointSweep& sweep, const Model& model);

}  // namespace penumbra
