#pragma once
// Computes the visibility past the characters of a scene at points with normals, and the light that arrives there.
#include <array>
#include <string>
#include <vector>

#include "player/scene/received_light.h"
#include "player/scene/scene_suns.h"

namespace penumbra {

struct ProbePoint {
    Vec3 position, normal;  // in the frame of the scene's file; the normal is unit
};

// A caster matters to a point where it alone takes this away from E.
constexpr float kCasterMatters = 0.002f;
constexpr int kProbeOrder = 5;

struct ProbeValue {
    double ambient = 1;                                       // E: 1/pi integral over the hemisphere of V cos
    Vec3d irradiance;                                         // integral of L V cos by the scene's light; 0 without one
    Vec3d received;                                           // irradiance of what the ground and members send
    std::array<float, kMaxSuns> sun_visibility{};             // share of each sun that reaches the front of the point
    std::array<double, kProbeOrder * kProbeOrder> moments{};  // integral over the hemisphere of V y_i, in the scene
    std::vector<std::size_t> casters;                         // members of the scene that matter
};

// Parses lines "x,y,z,nx,ny,nz" below a header of these words. Normals are made unit. Throws InvalidInput with the
// name, the line and what is wrong with it.
std::vector<ProbePoint> parseProbePoints(const std::string& text, const std::string& name);

// All casters count, and a ground that casts, but not what the point lies on. A level ground hides what is below the
// point's level, also from points below it. V is that of PosedScene::castWay(). In the modes that compare the points
// have free sight of their own, and where the light is folded, irradiance is that of the light's own bands. Where there
// are suns, V shadows the remainder L_g of the light alone, and the suns' maps shadow the suns: irradiance = integral
// of L_g V cos + sum of E_d v(d) max(n . d, 0).
// Points receive what is sent as vertices do: pi times what casters hide of a white sky times their mean radiance, and
// the same of the ground (docs/formulas.md, section 8). The modes that compare receive nothing.
std::vector<ProbeValue> probe(const PosedScene& scene, std::span<const ProbePoint> points, int threads,
                              const SceneSuns& suns = {}, const SentLight& sent = {});

// Rows of the points' six columns, E, irradiance_r, irradiance_g, irradiance_b, casters (names with semicolons between,
// quoted where a comma is in one), sh_0 to sh_24, the moments, sun_visibility_1 to the number of suns, and received_r,
// received_g, received_b.
std::string probeCsv(const PosedScene& scene, std::span<const ProbePoint> points, std::span<const ProbeValue> values,
                     std::size_t suns = 0);

}  // namespace penumbra
