#pragma once
// The sums that a check adds up over frames, and the figures that follow from them.
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "pack/check/check_asset.h"
#include "pack/check/check_far.h"
#include "sh/error_tail.h"

namespace penumbra {

// Sums over the vertices of a cluster and over frames. All but `ambient` add up squares.
struct CheckSums {
    double error = 0, truth_squares = 0, outside = 0, ambient = 0, prediction = 0;
    double sh_outside = 0, noise = 0, unpacked = 0, unpacked_outside = 0, packing = 0;
    double without_residual = 0, split = 0, local = 0, local_outside = 0, local_regression = 0;

    void add(const CheckSums& other) {
        sh_outside += other.sh_outside;
        noise += other.noise;
        unpacked += other.unpacked;
        unpacked_outside += other.unpacked_outside;
        packing += other.packing;
        without_residual += other.without_residual;
        split += other.split;
        local += other.local;
        local_outside += other.local_outside;
        local_regression += other.local_regression;
        error += other.error;
        truth_squares += other.truth_squares;
        outside += other.outside;
        ambient += other.ambient;
        prediction += other.prediction;
    }
};

// Sums over one clip of the truth. `truth_sum` adds up each number, for the mean over training frames.
struct ClipSums {
    std::string name;
    bool held_out = true;
    std::size_t frames = 0, second_frames = 0;  // frames of the truth, and how many of these the second bake has
    std::vector<CheckSums> of_cluster;
    std::vector<double> truth_sum;  // [V * stride], asset order
    FarSums far = {};
    std::size_t far_frames = 0;  // frames in which `far` was measured
    ErrorTail tail{};            // tail of the errors of E
};

// Inputs that were available beside the error itself. Figures that need a missing one are NaN.
struct CheckMeasured {
    bool composed = false;      // the asset's model is a composed one
    bool true_local = false;    // the truth has the local moments that such a model stands for
    bool unpacked = false;      // the unpacked model was given
    std::size_t vertices = 0;   // vertices of the asset
    bool spanned = true;        // every vertex has components: none of them follows points
    bool local_spanned = true;  // the local components span what `true_local` has: there are no near parts
};

// Returns the figures of every clip, of all training clips and of all held-out ones; `frames` stays empty. The mean
// is that of the training frames, or `stored_mean` where the truth has no such frame.
CheckResult figuresOf(std::span<const ClipSums> clips, std::span<const float> stored_mean,
                      const CheckMeasured& measured);

}  // namespace penumbra
