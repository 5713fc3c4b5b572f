#include "formats/brdf_file.h"

#include <cassert>

#include "formats/errors.h"
#include "formats/stage_parts.h"
#include "formats/write_file.h"
#include "sh/reflectance.h"

namespace penumbra {

constexpr FileKind kKind{"penumbra.brdf", kBrdfVersion};

void writeBrdf(const std::filesystem::path& path, const BrdfFile& brdf) {
    const hsize_t rows = hsize_t(coefficientCount(brdf.slice_order)), columns = brdf.even_index.size();
    assert(brdf.even_index == evenIndices(brdf.view_order) && brdf.slices.size() == rows * columns * 3);
    PartialFile partial(path);
    Hdf5Handle file = createHdf5(partial.path());
    writeRoot(file, kKind, brdf.slice_order, brdf.provenance);
    writeTextAttribute(file, "/", "name", brdf.name);
    writeIntegerAttribute(file, "/", "view_order", brdf.view_order);
    writeDoubles(file, "/reflectance/slices", brdf.slices, {rows, columns, 3});
    const std::vector<std::int64_t> even(brdf.even_index.begin(), brdf.even_index.end());
    writeIntegers(file, "/reflectance/even_index", even, {columns}, H5T_STD_I32LE);
    makeGroup(file, "/error");
    for (const auto& [name, value] : brdf.errors) writeNumberAttribute(file, "/error", name, value);
    closeHdf5(file);
    partial.commit();
}

static herr_t collectName(hid_t, const char* name, const H5A_info_t*, void* names) {
    static_cast<std::vector<std::string>*>(names)->emplace_back(name);
    return 0;
}

static std::map<std::string, double> readErrors(const Hdf5Reader& in) {
    std::map<std::string, double> errors;
    if (!exists(in, "/error")) return errors;
    std::vector<std::string> names;
    if (H5Aiterate_by_name(in.file, "/error", H5_INDEX_NAME, H5_ITER_INC, nullptr, collectName, &names, H5P_DEFAULT) <
        0)
        throw InvalidInput(in.name + ": /error: damaged");
    for (const std::string& name : names) errors[name] = readNumberAttribute(in, "/error", name);
    return errors;
}

BrdfFile readBrdf(const std::filesystem::path& path) {
    const Hdf5Reader in = openHdf5(path);
    BrdfFile brdf;
    brdf.slice_order = readRoot(in, kKind, brdf.provenance);
    brdf.name = readTextAttribute(in, "/", "name");
    brdf.view_order = int(readIntegerAttribute(in, "/", "view_order", 1, kMaxOrder));
    brdf.even_index = evenIndices(brdf.view_order);
    std::vector<hsize_t> even_shape{brdf.even_index.size()};
    const std::vector<std::int64_t> even =
        readIntegers(in, "/reflectance/even_index", even_shape, 0, coefficientCount(kMaxOrder) - 1);
    if (!std::equal(even.begin(), even.end(), brdf.even_index.begin(), brdf.even_index.end()))
        throw InvalidInput(in.name + ": /reflectance/even_index: not the z-even indices of the view order");
    std::vector<hsize_t> shape{hsize_t(coefficientCount(brdf.slice_order)), brdf.even_index.size(), 3};
    brdf.slices = readDoubles(in, "/reflectance/slices", shape);
    brdf.errors = readErrors(in);
    return brdf;
}

}  // namespace penumbra
