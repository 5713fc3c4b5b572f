#include "sh/light/light_rotation.h"

#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>

#include "sh/angles.h"
#include "sh/key_values.h"

namespace penumbra {

namespace {

// Returns the rotation about the unit axis a by Rodrigues' formula, R = cos I + (1 - cos) a a^T + sin [a]x.
Mat3d turnAbout(Vec3d a, double degrees) {
    const double angle = radians(degrees), c = std::cos(angle), s = std::sin(angle);
    Mat3d r;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) r(i, j) = (1 - c) * a[i] * a[j] + (i == j ? c : 0);
    r(0, 1) -= s * a.z, r(1, 0) += s * a.z;
    r(0, 2) += s * a.y, r(2, 0) -= s * a.y;
    r(1, 2) -= s * a.x, r(2, 1) += s * a.x;
    return r;
}

}  // namespace

Mat3d parseLightRotation(std::string_view text) {
    double yaw = 0, pitch = 0, roll = 0;
    bool has_angles = false;
    std::optional<Vec3d> axis;
    std::optional<double> angle;
    const auto degrees = [&](const KeyValue& item) {
        return parseNumber("light rotation " + std::string(item.key), item.value, -360, 360);
    };
    for (const KeyValue& item : splitKeyValues(text)) {
        if (item.key == "axis")
            axis = parseTriple("light rotation axis", item.value, -1e6, 1e6);
        else if (item.key == "angle")
            angle = degrees(item);
        else if (item.key == "yaw" || item.key == "pitch" || item.key == "roll")
            (item.key == "yaw" ? yaw : item.key == "pitch" ? pitch : roll) = degrees(item), has_angles = true;
        else
            throw std::invalid_argument("light rotation has no '" + std::string(item.key) +
                                        "': use yaw, pitch, roll, or axis and angle");
    }
    if (axis.has_value() != angle.has_value() || (axis && has_angles))
        throw std::invalid_argument("light rotation is either yaw, pitch, roll, or axis and angle, both");
    if (!axis) return turnAbout({0, 1, 0}, yaw) * turnAbout({1, 0, 0}, -pitch) * turnAbout({0, 0, 1}, roll);
    if (!(length(*axis) > 0)) throw std::invalid_argument("light rotation axis must not be 0/0/0");
    return turnAbout(normalized(*axis), *angle);
}

}  // namespace penumbra
