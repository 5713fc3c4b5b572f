#pragma once
// Holds the fields of far parts to rays. Fields are tables of few points, and a composed model is no better than they
// are; rays from the receivers themselves through the same rigid parts tell what the tables cost.
#include <array>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "formats/common/mesh.h"
#include "formats/common/part_table.h"
#include "sh/far/far_visibility.h"
#include "sh/visibility_convention.h"

namespace penumbra {

// How many receivers a comparison takes: vertices, and frames of each kind, all spread evenly.
constexpr std::size_t kComparedVertices = 128, kComparedFrames = 12;
constexpr int kComparedRays = 512;  // that each part is traced with from a receiver

// A field that is farther than this rms V from rays, over receivers in poses of the character's clips, is worth a
// warning.
constexpr double kMaxFieldRms = 0.1;
// Returns the words of that warning.
std::string fieldWarning(const std::string& part, double rms);

// The parts of a character in their rest frames, to be traced. Any number of threads may call sample().
class PartRays {
public:
    // `skin` tells which triangles lie back to back; only one of the two is kept.
    PartRays(const Mesh& mesh, const Skin& skin, const PartTable& table);
    ~PartRays();
    std::size_t partCount() const { return parts_.size(); }
    // Writes V - 1 of a part as `point` of its rest frame sees it, [kFieldCoefficients]. Inside a part everything is
    // blocked.
    void sample(std::size_t part, Vec3 point, std::span<float> out) const;

private:
    struct Part;
    std::vector<Vec3> positions_;  // of the mesh at rest
    std::vector<std::unique_ptr<Part>> parts_;
    std::vector<Vec3> cone_;  // cosine and sine of the azimuth, and the share of the cone's solid angle
};

// The far visibility of a receiver in both ways, as farVisibility() has it.
struct FarComparison {
    std::array<float, kFarCoefficients> by_fields{}, by_rays{};
    // [P] of what each part alone leaves visible: |by fields - by rays|^2 / 4 pi, a square of V; 0 of others
    std::vector<double> squares;
};
struct ComparedParts {
    const FarFields& fields;
    const PartRays& rays;  // of the first parts; others, occluders, have their fields in both ways
    std::span<const PosedPart> posed;
};
// `parts` are those that the receiver sees, by ascending index.
FarComparison compareFar(const ComparedParts& compared, std::span<const std::uint16_t> parts, const Receiver& receiver);

// Multiplies true local numbers in convention D by a far visibility [kFarCoefficients], moves the product to where E
// lies in [0, 1], as models do, and returns its squared distance from the true numbers.
double composedError(const Convention& convention, std::span<const float> local, std::span<const float> far,
                     std::span<const float> truth);

}  // namespace penumbra
