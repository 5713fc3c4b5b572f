#pragma once
// Writes a light's SH as a sum of zonal lobes (Nowrouzezahrai 2009 eq 15 and section 5.4). A lobe has a direction and,
// for every band and colour channel, a coefficient. To rotate a lobe is to evaluate the basis once, so a light of few
// lobes turns into any vertex' frame cheaply.
#include <span>

#include "formats/common/words.h"
#include "formats/stage/light_file.h"

namespace penumbra {

enum class LobeFit { kGreedy, kJoint, kFixed };
inline constexpr Word<LobeFit> kLobeFitWords[] = {
    {"greedy", LobeFit::kGreedy}, {"joint", LobeFit::kJoint}, {"fixed", LobeFit::kFixed}};

constexpr int kMaxFittedLobes = 7;
constexpr int fixedLobeCount(int order) { return 2 * order - 1; }

// Fits lobes to the light `sh` [order^2, 3].
//
// - kGreedy, the paper's way: takes the best of 1500 directions, refines it by BFGS, solves for its coefficients,
//   subtracts the lobe, and goes on with the next.
// - kJoint: BFGS over all directions at once, with the coefficients eliminated band by band (min-norm least squares).
//   It starts from the greedy directions and from a fixed set of others, and takes the best result.
// - kFixed: fixedLobeCount(order) directions with which every light of this order is exact. `lobes` is not used.
//
// Otherwise 1 <= lobes <= kMaxFittedLobes, and lobes come in descending energy with axes towards the light (the
// luminance of z_1 is >= 0). When there is nothing for a lobe to do (the light has band 0 only, or is black), its
// coefficients are zero.
LightLobesFit fitLobes(int order, std::span<const double> sh, int lobes, LobeFit how);

// Refines `directions` by BFGS over all of them at once, as kJoint does, and keeps their order and their signs. Lights
// that are near one another so have lobes that are near one another. `ridge` weighs the squares of the coefficients
// against that of the light, so that no two lobes grow against each other. Where `towards` is given, [D, order, 3] as
// LightLobesFit::coefficients, it weighs their squared distance from these instead.
LightLobesFit fitLobesFrom(int order, std::span<const double> sh, std::span<const Vec3d> directions, double ridge,
                           std::span<const double> towards = {});

// Returns the SH of the lobes, [order^2, 3].
std::vector<double> lobesToSh(int order, const LightLobesFit& lobes);

// Returns |E - E_truth| / |E_truth| for the irradiance E that two lights of one order give, over all normals and
// channels.
double irradianceDifference(int order, std::span<const double> sh, std::span<const double> truth);

// Returns the directions of kFixed. At every order the condition number of each band's matrix is below 4.
std::span<const Vec3d> fixedLobeDirections(int order);

}  // namespace penumbra
