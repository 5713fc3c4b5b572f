#include "formats/stage/brdf_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <functional>
#include <utility>

#include "formats/common/errors.h"
#include "formats/common/write_file.h"
#include "formats/stage/stage_parts.h"
#include "sh/brdf/brdf_range.h"
#include "sh/brdf/mirror_lobe.h"
#include "sh/reflectance.h"

namespace penumbra {

namespace {

void writeOperators(hid_t file, const BrdfOperators& operators) {
    const hsize_t count = hsize_t(operators.count), columns = operators.view_index.size();
    const hsize_t rows = hsize_t(coefficientCount(operators.order));
    assert(count <= kMaxOperators && operators.u.size() == count * rows * 3 &&
           operators.w.size() == count * columns * 3);
    writeDoubles(file, "/operators/u", operators.u, {count, rows, 3});
    writeDoubles(file, "/operators/w", operators.w, {count, columns, 3});
    const std::vector<std::int64_t> index(operators.view_index.begin(), operators.view_index.end());
    writeIntegers(file, "/operators/view_index", index, {columns}, H5T_STD_I32LE);
    writeIntegerAttribute(file, "/operators", "order", operators.order);
    writeTextAttribute(file, "/operators", "source", operators.source);
}

void writeLobes(hid_t file, const BrdfFile& brdf) {
    std::vector<std::int64_t> models;
    std::vector<double> parameters, colors;
    for (const BrdfLobe& lobe : brdf.lobes) {
        models.push_back(std::int64_t(lobe.model));
        parameters.insert(parameters.end(), lobe.parameters.begin(), lobe.parameters.end());
        colors.insert(colors.end(), {lobe.color.x, lobe.color.y, lobe.color.z});
    }
    const hsize_t count = brdf.lobes.size();
    writeIntegers(file, "/lobes/model", models, {count}, H5T_STD_I32LE);
    writeDoubles(file, "/lobes/parameters", parameters, {count, 4});
    writeDoubles(file, "/lobes/color", colors, {count, 3});
    writeNumberAttribute(file, "/lobes", "error", brdf.lobe_error);
}

void writeSlices(hid_t file, const BrdfFile& brdf) {
    const hsize_t rows = hsize_t(coefficientCount(brdf.slice_order)), columns = brdf.even_index.size();
    assert(brdf.even_index == evenIndices(brdf.view_order) && brdf.slices.size() == rows * columns * 3);
    writeDoubles(file, "/reflectance/slices", brdf.slices, {rows, columns, 3});
    const std::vector<std::int64_t> even(brdf.even_index.begin(), brdf.even_index.end());
    writeIntegers(file, "/reflectance/even_index", even, {columns}, H5T_STD_I32LE);
}

void writeMembrane(hid_t file, const Membrane& membrane) {
    for (const auto& [name, value] : {std::pair("/membrane/rho", membrane.rho), {"/membrane/tau", membrane.tau}}) {
        const std::array<double, 3> numbers = {double(value.x), double(value.y), double(value.z)};
        writeDoubles(file, name, numbers, {3});
    }
    writeIntegerAttribute(file, "/membrane", "open_back", membrane.open_back);
}

void writeSteps(hid_t file, const BrdfFile& brdf) {
    const BrdfSteps& steps = *brdf.steps;
    const hsize_t count = steps.values.size(), rows = hsize_t(coefficientCount(brdf.slice_order)),
                  columns = brdf.even_index.size();
    assert(steps.slices.size() == count * rows * columns * 3);
    writeDoubles(file, "/steps/values", steps.values, {count});
    writeDoubles(file, "/steps/slices", steps.slices, {count, rows, columns, 3});
    writeIntegerAttribute(file, "/steps", "parameter", std::int64_t(steps.parameter));
    writeNumberAttribute(file, "/steps", "error", steps.error);
    if (steps.lobes != 1) writeIntegerAttribute(file, "/steps", "lobes", steps.lobes);
}

}  // namespace

void writeBrdf(const std::filesystem::path& path, const BrdfFile& brdf) {
    assert(!brdf.isLive() || (brdf.lobes.size() == 1 && isMirrorLobe(brdf.lobes[0].model)));
    PartialFile partial(path);
    Hdf5Handle file = createHdf5(partial.path());
    writeRoot(file, kBrdfFormat, brdf.slice_order, brdf.provenance);
    writeTextAttribute(file, "/", "name", brdf.name);
    writeIntegerAttribute(file, "/", "view_order", brdf.view_order);
    if (!brdf.isLive()) writeSlices(file, brdf);
    makeGroup(file, "/error");
    for (const auto& [name, value] : brdf.errors) writeNumberAttribute(file, "/error", name, value);
    if (brdf.operators.count > 0) writeOperators(file, brdf.operators);
    writeLobes(file, brdf);
    if (brdf.membrane) writeMembrane(file, *brdf.membrane);
    if (brdf.steps) writeSteps(file, brdf);
    if (brdf.emission != Vec3{}) {
        makeGroup(file, "/emission");
        const std::vector<double> radiance = {brdf.emission.x, brdf.emission.y, brdf.emission.z};
        writeDoubles(file, "/emission/radiance", radiance, {3});
    }
    closeHdf5(file);
    partial.commit();
}

namespace {

herr_t collectName(hid_t, const char* name, const H5A_info_t*, void* names) {
    static_cast<std::vector<std::string>*>(names)->emplace_back(name);
    return 0;
}

std::map<std::string, double> readErrors(const Hdf5Reader& in) {
    if (!exists(in, "/error")) throw InvalidInput(in.name + ": /error: missing");
    std::map<std::string, double> errors;
    std::vector<std::string> names;
    if (H5Aiterate_by_name(in.file, "/error", H5_INDEX_NAME, H5_ITER_INC, nullptr, collectName, &names, H5P_DEFAULT) <
        0)
        throw InvalidInput(in.name + ": /error: damaged");
    for (const std::string& name : names) errors[name] = readNumberAttribute(in, "/error", name);
    return errors;
}

BrdfOperators readOperators(const Hdf5Reader& in, const std::vector<int>& even_index) {
    BrdfOperators operators;
    operators.source = readTextAttribute(in, "/operators", "source");
    const bool literal = operators.source == "literal";
    if (!literal && operators.source != "table" && operators.source != "slices")
        throw InvalidInput(in.name + ": /operators: source \"" + operators.source +
                           "\" is not table, slices or literal");
    operators.order = int(readIntegerAttribute(in, "/operators", "order", 1, kMaxOrder));
    std::vector<hsize_t> index_shape{literal ? 0 : even_index.size()};
    for (std::int64_t index :
         readIntegers(in, "/operators/view_index", index_shape, 0, coefficientCount(kMaxOrder) - 1)) {
        if (!operators.view_index.empty() && index <= operators.view_index.back())
            throw InvalidInput(in.name + ": /operators/view_index: not ascending");
        operators.view_index.push_back(int(index));
    }
    if (!literal && operators.view_index != even_index)
        throw InvalidInput(in.name + ": /operators/view_index: not that of the slices");
    std::vector<hsize_t> shape{0, hsize_t(coefficientCount(operators.order)), 3};
    operators.u = readDoubles(in, "/operators/u", shape);
    if (shape[0] < 1 || shape[0] > kMaxOperators)
        throw InvalidInput(in.name + ": /operators/u: " + std::to_string(shape[0]) + " operators; 1.." +
                           std::to_string(kMaxOperators) + " are possible");
    operators.count = int(shape[0]);
    std::vector<hsize_t> w_shape{shape[0], operators.view_index.size(), 3};
    operators.w = readDoubles(in, "/operators/w", w_shape);
    return operators;
}

void readLobes(const Hdf5Reader& in, BrdfFile& brdf) {
    std::vector<hsize_t> count{0};
    const std::vector<std::int64_t> models = readIntegers(in, "/lobes/model", count, 0, kBrdfModels - 1);
    if (models.empty() || models.size() > kMaxBrdfLobes)
        throw InvalidInput(in.name + ": /lobes/model: " + std::to_string(models.size()) + " lobes; 1.." +
                           std::to_string(kMaxBrdfLobes) + " are possible");
    std::vector<hsize_t> parameter_shape{count[0], 4}, color_shape{count[0], 3};
    const std::vector<double> parameters = readDoubles(in, "/lobes/parameters", parameter_shape),
                              colors = readDoubles(in, "/lobes/color", color_shape);
    for (std::size_t i = 0; i < models.size(); ++i) {
        BrdfLobe lobe{BrdfModel(models[i]), {}, {}};
        for (std::size_t k = 0; k < 4; ++k) lobe.parameters[k] = float(parameters[4 * i + k]);
        for (std::size_t c = 0; c < 3; ++c) lobe.color[int(c)] = float(colors[3 * i + c]);
        if (!isValid(lobe))
            throw InvalidInput(in.name + ": /lobes: lobe " + std::to_string(i) + " (" + nameOf(lobe.model) +
                               ") has a parameter or a colour out of range");
        brdf.lobes.push_back(lobe);
    }
    brdf.lobe_error = readNumberAttribute(in, "/lobes", "error");
    if (!(std::isfinite(brdf.lobe_error) && brdf.lobe_error >= 0))
        throw InvalidInput(in.name + ": /lobes: error is not a number of 0 or more");
}

void readSlices(const Hdf5Reader& in, BrdfFile& brdf) {
    std::vector<hsize_t> even_shape{brdf.even_index.size()};
    const std::vector<std::int64_t> even =
        readIntegers(in, "/reflectance/even_index", even_shape, 0, coefficientCount(kMaxOrder) - 1);
    if (!std::equal(even.begin(), even.end(), brdf.even_index.begin(), brdf.even_index.end()))
        throw InvalidInput(in.name + ": /reflectance/even_index: not the z-even indices of the view order");
    std::vector<hsize_t> shape{hsize_t(coefficientCount(brdf.slice_order)), brdf.even_index.size(), 3};
    brdf.slices = readDoubles(in, "/reflectance/slices", shape);
}

// Without slices, a lobe about the mirror direction is all that there is.
void checkLive(const Hdf5Reader& in, const BrdfFile& brdf) {
    if (brdf.lobes.size() != 1 || !isMirrorLobe(brdf.lobes[0].model))
        throw InvalidInput(in.name + ": /reflectance: missing, and /lobes is not one lobe about the mirror direction");
    if (brdf.operators.count > 0) throw InvalidInput(in.name + ": /operators: a material without slices has none");
}

Membrane readMembrane(const Hdf5Reader& in) {
    Membrane membrane;
    for (const auto& [name, value] : {std::pair("/membrane/rho", &membrane.rho), {"/membrane/tau", &membrane.tau}}) {
        std::vector<hsize_t> shape{3};
        const std::vector<double> numbers = readDoubles(in, name, shape);
        for (int c = 0; c < 3; ++c) (*value)[c] = float(numbers[std::size_t(c)]);
    }
    membrane.open_back = readIntegerAttribute(in, "/membrane", "open_back", 0, 1) == 1;
    if (const std::string problem = findProblem(membrane); !problem.empty())
        throw InvalidInput(in.name + ": /membrane: " + problem);
    return membrane;
}

Vec3 readEmission(const Hdf5Reader& in) {
    std::vector<hsize_t> shape{3};
    const std::vector<double> values = readDoubles(in, "/emission/radiance", shape);
    Vec3 emission;
    for (int c = 0; c < 3; ++c) emission[c] = float(values[std::size_t(c)]);
    for (int c = 0; c < 3; ++c)
        if (!(emission[c] >= 0 && std::isfinite(emission[c])))
            throw InvalidInput(in.name + ": /emission/radiance: is not 0 or more");
    return emission;
}

// Finds a fault of which lobes a step changes, and of the parameter's place; empty: there is none.
std::string problemOfChange(const BrdfFile& brdf, const BrdfSteps& steps) {
    if (steps.lobes == 0 || steps.lobes >> brdf.lobes.size() != 0) return ": lobes names lobes that do not exist";
    const char* name = nullptr;
    float value = 0;
    for (std::size_t i = 0; i < brdf.lobes.size(); ++i) {
        if (!(steps.lobes >> i & 1)) continue;
        const std::span<const BrdfParameter> known = parametersOf(brdf.lobes[i].model);
        if (known.empty()) return std::string(": ") + nameOf(brdf.lobes[i].model) + " has no parameter";
        if (steps.parameter >= known.size()) return ": parameter is not one of the lobe's";
        const float own = brdf.lobes[i].parameters[steps.parameter];
        if (name && (std::string_view(name) != known[steps.parameter].name || own != value))
            return ": the lobes have no parameter in common";
        name = known[steps.parameter].name;
        value = own;
    }
    return "";
}

// The steps are those of lobes that the material is.
BrdfSteps readSteps(const Hdf5Reader& in, const BrdfFile& brdf) {
    const auto require = [&](bool holds, const std::string& what) {
        if (!holds) throw InvalidInput(in.name + ": /steps" + what);
    };
    require(brdf.lobe_error == 0 && !brdf.slices.empty() && !brdf.membrane && brdf.operators.count == 0,
            ": the material is not one lobe or more, all exact, with slices, without operators or a membrane");
    BrdfSteps steps;
    if (hasAttribute(in, "/steps", "lobes"))
        steps.lobes = std::uint8_t(readIntegerAttribute(in, "/steps", "lobes", 0, 255));
    steps.parameter = std::size_t(readIntegerAttribute(in, "/steps", "parameter", 0, 3));
    const std::string problem = problemOfChange(brdf, steps);
    require(problem.empty(), problem);
    const BrdfLobe& lobe = brdf.lobes[std::size_t(std::countr_zero(steps.lobes))];
    std::vector<hsize_t> count{0};
    steps.values = readDoubles(in, "/steps/values", count);
    require(count[0] >= 2 && count[0] <= kMaxBrdfSteps,
            "/values: " + std::to_string(count[0]) + " steps; 2.." + std::to_string(kMaxBrdfSteps) + " are possible");
    const BrdfParameter& parameter = parametersOf(lobe.model)[steps.parameter];
    require(steps.values.front() >= parameter.least && steps.values.back() <= parameter.most,
            std::string("/values: out of the range of ") + parameter.name);
    require(std::ranges::adjacent_find(steps.values, std::greater_equal()) == steps.values.end(),
            "/values: not ascending");
    const float now = lobe.parameters[steps.parameter];
    require(now >= float(steps.values.front()) && now <= float(steps.values.back()),
            "/values: do not enclose the parameter of the lobe");
    std::vector<hsize_t> shape{count[0], hsize_t(coefficientCount(brdf.slice_order)), brdf.even_index.size(), 3};
    steps.slices = readDoubles(in, "/steps/slices", shape);
    steps.error = readNumberAttribute(in, "/steps", "error");
    require(std::isfinite(steps.error) && steps.error >= 0, ": error is not a number of 0 or more");
    return steps;
}

}  // namespace

BrdfFile readBrdf(const std::filesystem::path& path) {
    const Hdf5Reader in = openHdf5(path);
    BrdfFile brdf;
    brdf.slice_order = readRoot(in, kBrdfFormat, brdf.provenance);
    brdf.name = readTextAttribute(in, "/", "name");
    brdf.view_order = int(readIntegerAttribute(in, "/", "view_order", 1, kMaxOrder));
    brdf.even_index = evenIndices(brdf.view_order);
    const bool has_slices = exists(in, "/reflectance");
    if (has_slices) readSlices(in, brdf);
    brdf.errors = readErrors(in);
    if (exists(in, "/operators")) brdf.operators = readOperators(in, brdf.even_index);
    readLobes(in, brdf);
    if (!has_slices) checkLive(in, brdf);
    if (exists(in, "/membrane")) brdf.membrane = readMembrane(in);
    if (exists(in, "/steps")) brdf.steps = readSteps(in, brdf);
    if (exists(in, "/emission")) brdf.emission = readEmission(in);
    if (brdf.membrane && brdf.emission != Vec3{}) throw InvalidInput(in.name + ": /emission: a membrane has none");
    return brdf;
}

}  // namespace penumbra
