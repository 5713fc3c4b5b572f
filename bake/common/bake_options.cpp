#include "bake/common/bake_options.h"

#include <cmath>

#include "bake/common/out_of_range.h"
#include "formats/common/errors.h"
#include "sh/sh_basis.h"

namespace penumbra {

namespace {

std::string findProblem(const TransferOptions& options) {
    if (options.bounces < 0 || options.bounces > kMaxBounces)
        return outOfRange("--bounces", "0..16 reflections", options.bounces);
    if (options.bounces == 0 && (options.albedo.any() || options.transmission.any()))
        return "--albedo and --transmission go with --bounces";
    return "";
}

}  // namespace

std::string findProblem(const BakeOptions& options) {
    // Each test asks for "not inside", so that NaN is a problem too.
    if (!(options.fps >= 0 && options.fps <= 1000)) return outOfRange("--fps", "0..1000 samples a second", options.fps);
    if (options.poses && options.fps > 0 && options.clips.empty())
        return "--fps goes with --clips when there is --poses, which has times of its own";
    if (options.blocks < 1 || options.blocks > 10000)
        return outOfRange("--blocks", "1..10000 blocks of every clip", options.blocks);
    if (const std::string problem = findProblem(options.cache); !problem.empty()) return problem;
    if (options.order < 1 || options.order > kMaxOrder) return outOfRange("--order", "1..8 bands", options.order);
    if (options.rays < 16 || options.rays > 1 << 16)
        return outOfRange("--rays", "16..65536 directions above the horizon", options.rays);
    if (!(options.bias >= 1e-7 && options.bias <= 0.1))
        return outOfRange("--bias", "1e-7..0.1 diagonals of the rest pose", options.bias);
    if (options.ground_y && !(std::isfinite(*options.ground_y) && options.ground))
        return outOfRange("--ground", "a height in metres", *options.ground_y);
    if (options.local && (options.local->steps < 1 || options.local->steps > kMaxLocalSteps))
        return outOfRange("--local-steps", "1..8 bones with a part", options.local->steps);
    if (options.local && (options.local->order < kMinLocalOrder || options.local->order > kMaxLocalOrder))
        return outOfRange("--local-order", "5..6 bands", options.local->order);
    if (options.transfer && options.local) return "--local goes with --quantity visibility";
    return options.transfer ? findProblem(*options.transfer) : "";
}

}  // namespace penumbra
