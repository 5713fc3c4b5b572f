#pragma once
// The caps and spheres of golden files.
#include <vector>

#include "sh/cast/cap_visibility.h"
#include "tests/sh/golden.h"

namespace penumbra {

inline std::vector<Cap> goldenCaps(const nlohmann::json& axes, const nlohmann::json& angles) {
    std::vector<Cap> caps;
    for (std::size_t k = 0; k < angles.size(); ++k) caps.push_back({vec3(axes.at(k)), angles.at(k)});
    return caps;
}

inline std::vector<CasterSphereD> goldenSpheres(const nlohmann::json& centers, const nlohmann::json& radii) {
    std::vector<CasterSphereD> spheres;
    for (std::size_t k = 0; k < radii.size(); ++k) spheres.push_back({vec3(centers.at(k)), radii.at(k)});
    return spheres;
}

// 15 spheres of a standing person, z up, feet at 0.
inline std::vector<CasterSphereD> goldenPerson() {
    const nlohmann::json person = readGolden("sphere_set.json").at("proxies").at("15");
    return goldenSpheres(person.at("C"), person.at("R"));
}

inline std::vector<CasterSphere> inFloats(const std::vector<CasterSphereD>& spheres) {
    std::vector<CasterSphere> out;
    for (const CasterSphereD& s : spheres) out.push_back({toFloat(s.center), float(s.radius)});
    return out;
}

inline std::vector<double> netLogOf(int order, const std::vector<Cap>& caps) {
    std::vector<double> log(std::size_t(coefficientCount(order)));
    netLog(capLogTableD(order), caps, log);
    return log;
}

inline std::vector<double> netLogAt(int order, const std::vector<CasterSphereD>& spheres, Vec3d position) {
    std::vector<double> log(std::size_t(coefficientCount(order)));
    netLog(capLogTableD(order), spheres, position, log);
    return log;
}

inline std::vector<float> netLogAt(int order, const std::vector<CasterSphere>& spheres, Vec3 position) {
    std::vector<float> log(std::size_t(coefficientCount(order)));
    netLog(capLogTable(order), spheres, position, log);
    return log;
}

}  // namespace penumbra
