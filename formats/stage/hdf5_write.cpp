// Writes HDF5 files; see hdf5_handle.h.
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "formats/common/errors.h"
#include "formats/common/write_file.h"
#include "formats/stage/hdf5_handle.h"

namespace penumbra {

namespace {

// Returns the start of a message about an open file.
std::string targetOf(hid_t file) {
    char name[4096] = "";
    H5Fget_name(file, name, sizeof name);
    return targetOfPartial(name).string() + ": cannot write";
}

}  // namespace

Hdf5Handle createHdf5(const std::filesystem::path& path) {
    initHdf5();
    const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "HDF5 file access");
    const Hdf5Handle creation(H5Pcreate(H5P_FILE_CREATE), H5Pclose, "HDF5 file creation");
    checkHdf5(H5Pset_file_locking(access, false, true), "HDF5 file locking");  // PartialFile has locked it
    checkHdf5(H5Pset_libver_bounds(access, H5F_LIBVER_V110, H5F_LIBVER_V110), "HDF5 format version");
    checkHdf5(H5Pset_fclose_degree(access, H5F_CLOSE_STRONG), "HDF5 close degree");
    checkHdf5(H5Pset_obj_track_times(creation, false), "HDF5 time stamps");
    return Hdf5Handle(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, creation, access), H5Fclose,
                      targetOfPartial(path).string() + ": cannot write");
}

void closeHdf5(Hdf5Handle& file) {
    const std::string what = targetOf(file);
    checkHdf5(H5Fflush(file, H5F_SCOPE_GLOBAL), what);
    file.close(what);
}

Hdf5Handle halfType() {
    Hdf5Handle type(H5Tcopy(H5T_IEEE_F32LE), H5Tclose, "HDF5 half type");
    // Fields come before precision and size, because they must lie inside the type at each step.
    checkHdf5(H5Tset_fields(type, 15, 10, 5, 0, 10), "HDF5 half type");
    checkHdf5(H5Tset_precision(type, 16), "HDF5 half type");
    checkHdf5(H5Tset_size(type, 2), "HDF5 half type");
    checkHdf5(H5Tset_ebias(type, 15), "HDF5 half type");
    return type;
}

void makeGroup(hid_t file, const std::string& path) {
    const std::string what = targetOf(file);
    for (std::size_t end = path.find('/', 1);; end = path.find('/', end + 1)) {
        const std::string part = path.substr(0, end);
        if (part.size() > 1 && H5Lexists(file, part.c_str(), H5P_DEFAULT) <= 0) {
            const Hdf5Handle creation(H5Pcreate(H5P_GROUP_CREATE), H5Pclose, what);
            checkHdf5(H5Pset_obj_track_times(creation, false), what);
            const Hdf5Handle group(H5Gcreate2(file, part.c_str(), H5P_DEFAULT, creation, H5P_DEFAULT), H5Gclose, what);
        }
        if (end == std::string::npos) return;
    }
}

namespace {

std::size_t elementCount(const std::vector<hsize_t>& shape) {
    std::size_t product = 1;
    for (hsize_t n : shape) product *= n;
    return product;
}

// Returns the chunk of a dataset that is not compressed: all of it, within HDF5's limit of 4 GB a chunk.
std::vector<hsize_t> wholeRows(const std::vector<hsize_t>& shape) {
    constexpr hsize_t kMaxEntries = hsize_t(1) << 26;  // entries of at most 8 bytes; text is shorter than 64 bytes a
                                                       // name
    std::vector<hsize_t> chunk = shape;
    chunk[0] = std::clamp<hsize_t>(kMaxEntries / std::max<hsize_t>(1, elementCount(shape) / shape[0]), 1, shape[0]);
    return chunk;
}

}  // namespace

Hdf5Handle createDataset(hid_t file, const std::string& path, hid_t type, const std::vector<hsize_t>& shape,
                         const std::vector<hsize_t>& chunk) {
    const std::string what = targetOf(file);
    if (const std::size_t slash = path.rfind('/'); slash > 0) makeGroup(file, path.substr(0, slash));
    const Hdf5Handle space(H5Screate_simple(int(shape.size()), shape.data(), nullptr), H5Sclose, what);
    const Hdf5Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, what);
    checkHdf5(H5Pset_fill_time(creation, H5D_FILL_TIME_NEVER), what);
    checkHdf5(H5Pset_obj_track_times(creation, false), what);
    if (elementCount(shape) > 0) {  // checksums are of chunks
        const std::vector<hsize_t> rows = chunk.empty() ? wholeRows(shape) : chunk;
        checkHdf5(H5Pset_chunk(creation, int(rows.size()), rows.data()), what);
        if (!chunk.empty()) checkHdf5(H5Pset_shuffle(creation), what);
        if (!chunk.empty()) checkHdf5(H5Pset_deflate(creation, 1), what);
        checkHdf5(H5Pset_fletcher32(creation), what);  // last: of the bytes as they are stored
    }
    return Hdf5Handle(H5Dcreate2(file, path.c_str(), type, space, H5P_DEFAULT, creation, H5P_DEFAULT), H5Dclose, what);
}

namespace {

// HDF5 takes "%b" in the names of virtual sources for the number of a block, so percent signs are doubled.
std::string escapePercent(const std::string& name) {
    std::string out;
    for (char c : name) out += c == '%' ? "%%" : std::string(1, c);
    return out;
}

}  // namespace

void createVirtualDataset(hid_t file, const std::string& path, hid_t type, const std::vector<hsize_t>& shape,
                          const std::vector<Hdf5Run>& runs) {
    const std::string what = targetOf(file);
    makeGroup(file, path.substr(0, path.rfind('/')));
    const Hdf5Handle space(H5Screate_simple(int(shape.size()), shape.data(), nullptr), H5Sclose, what);
    const Hdf5Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, what);
    checkHdf5(H5Pset_obj_track_times(creation, false), what);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    checkHdf5(H5Pset_fill_value(creation, H5T_NATIVE_FLOAT, &nan), what);
    for (const Hdf5Run& run : runs) {
        std::vector<hsize_t> source_shape(shape), begin(shape.size(), 0), count(shape), stride(shape.size(), 1);
        source_shape[0] = run.file_frames;
        const Hdf5Handle source(H5Screate_simple(int(shape.size()), source_shape.data(), nullptr), H5Sclose, what);
        count[0] = run.count;
        begin[0] = run.from;
        checkHdf5(H5Sselect_hyperslab(source, H5S_SELECT_SET, begin.data(), nullptr, count.data(), nullptr), what);
        begin[0] = run.to;
        stride[0] = run.stride;
        checkHdf5(H5Sselect_hyperslab(space, H5S_SELECT_SET, begin.data(), stride.data(), count.data(), nullptr), what);
        checkHdf5(H5Pset_virtual(creation, space, escapePercent(run.file).c_str(), path.c_str(), source), what);
    }
    checkHdf5(H5Sselect_all(space), what);
    Hdf5Handle dataset(H5Dcreate2(file, path.c_str(), type, space, H5P_DEFAULT, creation, H5P_DEFAULT), H5Dclose, what);
    dataset.close(what);
}

namespace {

void writeDataset(hid_t file, const std::string& path, hid_t type, hid_t memory_type, const void* values,
                  const std::vector<hsize_t>& shape, const std::vector<hsize_t>& chunk = {}) {
    Hdf5Handle dataset = createDataset(file, path, type, shape, chunk);
    const std::string what = targetOf(file);
    if (elementCount(shape) > 0) checkHdf5(H5Dwrite(dataset, memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values), what);
    dataset.close(what);
}

// Refuses numbers that the readers would refuse: a mistake in our own numbers must show where it is made.
template <class T>
void checkOwnNumbers(const std::string& path, std::span<const T> values) {
    for (T value : values)
        if (!std::isfinite(value)) throw std::runtime_error(path + ": the result is not a finite number");
}

}  // namespace

void writeFloats(hid_t file, const std::string& path, std::span<const float> values,
                 const std::vector<hsize_t>& shape) {
    assert(values.size() == elementCount(shape));
    checkOwnNumbers(path, values);
    writeDataset(file, path, H5T_IEEE_F32LE, H5T_NATIVE_FLOAT, values.data(), shape);
}

void writeDoubles(hid_t file, const std::string& path, std::span<const double> values,
                  const std::vector<hsize_t>& shape) {
    assert(values.size() == elementCount(shape));
    checkOwnNumbers(path, values);
    writeDataset(file, path, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, values.data(), shape);
}

void writeBytes(hid_t file, const std::string& path, std::span<const std::int8_t> values,
                const std::vector<hsize_t>& shape, const std::vector<hsize_t>& chunk) {
    assert(values.size() == elementCount(shape));
    writeDataset(file, path, H5T_STD_I8LE, H5T_NATIVE_INT8, values.data(), shape, chunk);
}

void writeIntegers(hid_t file, const std::string& path, std::span<const std::int64_t> values,
                   const std::vector<hsize_t>& shape, hid_t type) {
    assert(values.size() == elementCount(shape));
    writeDataset(file, path, type, H5T_NATIVE_INT64, values.data(), shape);
}

namespace {

Hdf5Handle textType(std::size_t size, const std::string& what) {
    Hdf5Handle type(H5Tcopy(H5T_C_S1), H5Tclose, what);
    checkHdf5(H5Tset_size(type, size), what);
    checkHdf5(H5Tset_cset(type, H5T_CSET_UTF8), what);
    if (size != H5T_VARIABLE) checkHdf5(H5Tset_strpad(type, H5T_STR_NULLPAD), what);
    return type;
}

}  // namespace

// Writes text of fixed length, padded with zeros, so that no text lies in HDF5's global heap, which has no checksums.
void writeStrings(hid_t file, const std::string& path, const std::vector<std::string>& values) {
    std::size_t longest = 1;
    for (const std::string& value : values) longest = std::max(longest, value.size());
    std::vector<char> bytes(longest * values.size(), '\0');
    for (std::size_t i = 0; i < values.size(); ++i)
        std::copy(values[i].begin(), values[i].end(), bytes.begin() + long(i * longest));
    const Hdf5Handle type = textType(longest, targetOf(file));
    writeDataset(file, path, type, type, bytes.data(), {values.size()});
}

namespace {

void writeAttribute(hid_t file, const std::string& object, const std::string& name, hid_t type, hid_t memory_type,
                    const void* value) {
    const std::string what = targetOf(file);
    const Hdf5Handle space(H5Screate(H5S_SCALAR), H5Sclose, what);
    const Hdf5Handle attribute(
        H5Acreate_by_name(file, object.c_str(), name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
        H5Aclose, what);
    checkHdf5(H5Awrite(attribute, memory_type, value), what);
}

}  // namespace

// Writes text of variable length: h5py shows such attributes as str, and a header may hold no more than 64 KiB of the
// other kind.
void writeTextAttribute(hid_t file, const std::string& object, const std::string& name, const std::string& value) {
    const Hdf5Handle type = textType(H5T_VARIABLE, targetOf(file));
    const char* text = value.c_str();
    writeAttribute(file, object, name, type, type, &text);
}

void writeNumberAttribute(hid_t file, const std::string& object, const std::string& name, double value) {
    writeAttribute(file, object, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &value);
}

void writeIntegerAttribute(hid_t file, const std::string& object, const std::string& name, std::int64_t value) {
    writeAttribute(file, object, name, H5T_STD_I64LE, H5T_NATIVE_INT64, &value);
}

}  // namespace penumbra
