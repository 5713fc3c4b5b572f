#pragma once
// Parses the options with which people describe a capture: the mirror ball, the place where light is wanted, and tags.
// Each function throws std::invalid_argument, which says what is wrong. Only the files of verbs include this.
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "formats/camera/tag_detector.h"
#include "formats/common/errors.h"
#include "formats/common/options.h"
#include "sh/key_values.h"
#include "sh/light/mirror_ball.h"

namespace penumbra {

constexpr double kMaxCaptureMetres = 1e6;

// Reads "x/y/z,radius[,reflectance]".
inline MirrorBall parseBall(const std::string& text) {
    std::vector<std::string> parts;
    std::istringstream stream(text);
    for (std::string part; std::getline(stream, part, ',');) parts.push_back(part);
    if (parts.size() < 2 || parts.size() > 3)
        throw std::invalid_argument("must be x/y/z,radius[,reflectance] in metres, not '" + text + "'");
    MirrorBall ball;
    ball.center = parseTriple("the ball's middle", parts[0], -kMaxCaptureMetres, kMaxCaptureMetres);
    ball.radius = parseNumber("the ball's radius", parts[1], 1e-6, kMaxCaptureMetres);
    if (parts.size() == 3) ball.reflectance = parseNumber("the ball's reflectance", parts[2], 0.01, 1);
    return ball;
}

inline Vec3d parsePlace(const std::string& text) {
    const Vec3d place = parseTriple("the place", text, -kMaxCaptureMetres, kMaxCaptureMetres);
    if (!(place.z > 0)) throw std::invalid_argument("must lie above the ground, z > 0, not '" + text + "'");
    return place;
}

inline TagChoice readTag(const std::string& text) {
    try {
        return parseTag(text);
    } catch (const BadOption& error) {
        throw std::invalid_argument(error.problem);
    }
}

// Adds --tag, which may be given again.
inline CLI::Option* addTagOption(CLI::App& app, std::vector<TagChoice>& tags, const std::string& help) {
    const auto take = [&tags](const std::string& text) {
        try {
            const TagChoice tag = readTag(text);
            for (const TagChoice& other : tags)
                if (other.family == tag.family && other.id == tag.id)
                    throw std::invalid_argument("'" + text + "' occurs twice");
            tags.push_back(tag);
        } catch (const std::invalid_argument& error) {
            throw CLI::ValidationError("--tag", error.what());
        }
    };
    return addListOption(app, "--tag", take, help);
}

}  // namespace penumbra
