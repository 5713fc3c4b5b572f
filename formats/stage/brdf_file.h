#pragma once
// m.brdf.h5: a material as reflectance slices (HDF5, format "penumbra.brdf"), with the operators of Nowrouzezahrai 2009
// beside them where the user asked for these.
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "formats/common/file_format.h"
#include "formats/common/provenance.h"
#include "sh/brdf/brdf_lobe.h"
#include "sh/brdf/membrane.h"
#include "sh/brdf/reflection_operator.h"

namespace penumbra {

constexpr FileFormat kBrdfFormat{"penumbra.brdf", 1};

// f_i(o) ~= sum_b u^b_i (w^b . y(o)); sh/brdf/reflection_operator.h makes M^b of the u. count 0: there are no
// operators.
struct BrdfOperators {
    int count = 0;                // k, the same in every channel
    int order = 0;                // order of u
    std::vector<double> u;        // [k, order^2, 3], colour included
    std::vector<int> view_index;  // [E'] SH index of each view function: the file's even_index, or any for "literal"
    std::vector<double> w;        // [k, E', 3]
    std::string source;           // "table", "slices" or "literal" (fit/papers/operators/brdf_operators.h)
    bool operator==(const BrdfOperators&) const = default;
};

// Slices at steps of a parameter of some of the material's lobes. The run time interpolates them between two steps.
struct BrdfSteps {
    std::size_t parameter = 0;   // index into parametersOf() of the model of each of these, which call it alike
    std::vector<double> values;  // 2..kMaxBrdfSteps, ascending
    std::vector<double> slices;  // [steps, J^2, E, 3], colour included
    double error = 0;            // largest relative error of interpolated slices in the middle between two steps
    std::uint8_t lobes = 1;      // bit i: lobe i has the parameter
    bool operator==(const BrdfSteps&) const = default;
};

struct BrdfFile {
    std::string name;     // "ggx:alpha=0.3,f0=0.9"
    int slice_order = 5;  // J
    int view_order = 5;
    std::vector<double> slices;            // [J^2, E, 3], colour included
    std::vector<int> even_index;           // [E], SH index of each view function
    std::map<std::string, double> errors;  // measured at fit time: "fit" (relative, cos-weighted), "albedo", ...
    Provenance provenance;
    BrdfOperators operators;
    std::vector<BrdfLobe> lobes;  // 1..kMaxBrdfLobes that add up to the material, for light from one direction
    double lobe_error = 0;        // error of that sum (fit/reflectance/shading_error.h); 0: exact
    // Set: the slices and lobes are those of a white Lambertian surface, and the membrane says what it makes of them.
    std::optional<Membrane> membrane;
    std::optional<BrdfSteps> steps;  // set: `slices` are those of the parameter that the lobes have
    Vec3 emission{};                 // radiance of the surface itself, linear Rec.709; neither slices nor lobes have it

    // A live material is one lobe about the mirror direction (sh/brdf/mirror_lobe.h) and has no slices.
    bool isLive() const { return slices.empty(); }
};

void writeBrdf(const std::filesystem::path& path, const BrdfFile& brdf);
BrdfFile readBrdf(const std::filesystem::path& path);  // throws IoError and InvalidInput

}  // namespace penumbra
