#pragma once
// A light's SH as a sum of zonal lobes (paper 000 eq 15 and section 5.4): directions and, per band and colour channel,
// coefficients. Rotating a lobe is evaluating the basis once, so a light of few lobes turns into any vertex' frame
// cheaply.
#include <span>
#include <string_view>

#include "formats/stage/light_file.h"

namespace penumbra {

enum class LobeFit { kGreedy, kJoint, kFixed };
LobeFit parseLobeFit(std::string_view name);  // greedy, joint, fixed; std::invalid_argument

constexpr int kMaxFittedLobes = 7;
constexpr int fixedLobeCount(int order) { return 2 * order - 1; }

// `sh` is [order^2, 3]. Lobes come in descending energy with axes towards the light (luminance of z_1 >= 0), but for
// kFixed.
// kGreedy, the paper's way: the best of 1500 directions, refined by BFGS, coefficients in closed form; subtract; again.
// kJoint: BFGS over all directions at once, coefficients eliminated band by band (min-norm least squares), from the
//     greedy directions and from a fixed set of others; the best.
// kFixed: fixedLobeCount(order) directions with which every light of this order is exact; `lobes` is not used.
// What no lobe can do (band 0 only, black) leaves lobes of zeros. 1 <= lobes <= kMaxFittedLobes.
LightLobesFit fitLobes(int order, std::span<const double> sh, int lobes, LobeFit how);

// The SH of the lobes, [order^2, 3].
std::vector<double> lobesToSh(int order, const LightLobesFit& lobes);

// |E - E_truth| / |E_truth| of the irradiance that two lights of one order give, over all normals and channels.
double irradianceDifference(int order, std::span<const double> sh, std::span<const double> truth);

// The directions of kFixed: conditions of every band's matrix are below 4 at each order.
std::span<const Vec3d> fixedLobeDirections(int order);

}  // namespace penumbra
