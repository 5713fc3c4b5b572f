// Reads HDF5 files that anybody may have made; see hdf5_handle.h.
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <memory>
#include <mutex>
#include <optional>

#include "formats/common/check_readable.h"
#include "formats/common/errors.h"
#include "formats/common/fp16.h"
#include "formats/stage/hdf5_handle.h"
#include "formats/stage/hdf5_storage.h"
#include "formats/stage/hdf5_text.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;

// No byte of a deflate stream gives more than this (zlib's documentation), and nothing else that we accept expands.
constexpr std::uint64_t kMaxExpansion = 1032;

std::shared_ptr<const std::byte> mapFile(const fs::path& path, std::uint64_t length) {
    const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    void* bytes = file < 0 ? MAP_FAILED : ::mmap(nullptr, length, PROT_READ, MAP_PRIVATE, file, 0);
    const int reason = errno;
    if (file >= 0) ::close(file);
    if (bytes == MAP_FAILED) throw IoError(path.string() + ": cannot read: " + std::strerror(reason));
    return {static_cast<const std::byte*>(bytes),
            [length](const std::byte* address) { ::munmap(const_cast<std::byte*>(address), length); }};
}

// Checks what GlobalHeaps and storedElsewhere() take for granted.
void checkAddresses(const Hdf5Reader& in) {
    const Hdf5Handle creation(H5Fget_create_plist(in.file), H5Pclose, in.name);
    std::size_t address_bytes = 0, length_bytes = 0;
    hsize_t user_block = 0;
    if (H5Pget_sizes(creation, &address_bytes, &length_bytes) < 0 || H5Pget_userblock(creation, &user_block) < 0 ||
        address_bytes != 8 || length_bytes != 8 || user_block != 0)
        throw Unsupported(in.name + ": an HDF5 file with a user block or without 8-byte addresses");
}

}  // namespace

Hdf5Reader openHdf5(const fs::path& path) {
    initHdf5();
    std::error_code error;
    checkReadable(path);
    const std::uint64_t length = fs::file_size(path, error);
    if (error) throw IoError(path.string() + ": cannot read: " + error.message());
    if (length == 0) throw InvalidInput(path.string() + ": empty file");
    const std::shared_ptr<const std::byte> bytes = mapFile(path, length);
    ::madvise(const_cast<std::byte*>(bytes.get()), length, MADV_RANDOM);  // a few pages are read, not their neighbours
    const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, "HDF5 file access");
    H5Pset_file_locking(access, false, true);  // read-only folders and network file systems
    H5Pset_fclose_degree(access, H5F_CLOSE_STRONG);
    const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, access);
    if (file < 0) {
        const std::string reason = hdf5Reason();
        if (!reason.empty()) throw IoError(path.string() + ": cannot read: " + reason);
        throw InvalidInput(path.string() + ": not an HDF5 file, or cut short");
    }
    Hdf5Reader in{Hdf5Handle(file, H5Fclose, path.string()), path.string(), length, bytes};
    checkAddresses(in);
    return in;
}

namespace {

// Makes a handle from a call that fails only when the file is wrong.
Hdf5Handle fromFile(hid_t id, Hdf5Handle::Closer closer, const std::string& label, const char* what) {
    if (id < 0) throw InvalidInput(label + ": " + what);
    return Hdf5Handle(id, closer, label);
}

// The address of the object that the links of `path` lead to; nothing where one of them is missing.
std::optional<haddr_t> addressOf(const Hdf5Reader& in, const std::string& path) {
    for (std::size_t end = path.find('/', 1);; end = path.find('/', end + 1)) {
        const std::string part = path.substr(0, end);
        if (H5Lexists(in.file, part.c_str(), H5P_DEFAULT) <= 0) return std::nullopt;
        H5L_info_t link;
        if (H5Lget_info(in.file, part.c_str(), &link, H5P_DEFAULT) < 0 || link.type != H5L_TYPE_HARD)
            throw InvalidInput(in.name + ": " + part + ": is not a plain link");
        if (end == std::string::npos) return link.u.address;
    }
}

}  // namespace

bool exists(const Hdf5Reader& in, const std::string& path) {
    initHdf5();
    return path == "/" || addressOf(in, path).has_value();
}

// --- Datasets -------------------------------------------------------------------------------------------------------

std::size_t Hdf5Dataset::count() const {
    std::size_t product = 1;
    for (hsize_t n : shape) product *= n;
    return product;
}

namespace {

void readShape(Hdf5Dataset& dataset, std::vector<hsize_t>& expected) {
    const Hdf5Handle space = fromFile(H5Dget_space(dataset.id), H5Sclose, dataset.label, "no shape");
    const int rank = H5Sget_simple_extent_ndims(space);
    if (H5Sget_simple_extent_type(space) != H5S_SIMPLE || rank != int(expected.size()))
        throw InvalidInput(dataset.label + ": has " + std::to_string(rank) + " axes, not " +
                           std::to_string(expected.size()));
    dataset.shape.resize(expected.size());
    H5Sget_simple_extent_dims(space, dataset.shape.data(), nullptr);
    for (std::size_t axis = 0; axis < expected.size(); ++axis) {
        if (expected[axis] != 0 && expected[axis] != dataset.shape[axis])
            throw InvalidInput(dataset.label + ": axis " + std::to_string(axis) + " has " +
                               std::to_string(dataset.shape[axis]) + " entries, not " + std::to_string(expected[axis]));
        expected[axis] = dataset.shape[axis];
    }
}

// Returns the bytes of `shape`, which must be at most `most`.
std::uint64_t checkedBytes(const std::string& label, const std::vector<hsize_t>& shape, std::uint64_t item,
                           std::uint64_t most) {
    std::uint64_t bytes = item;
    for (hsize_t n : shape) {
        if (n == 0) return 0;
        if (bytes > most / n) throw InvalidInput(label + ": larger than the file can hold");
        bytes *= n;
    }
    return bytes;
}

void checkFilters(const Hdf5Dataset& dataset, hid_t properties) {
    for (int i = 0; i < H5Pget_nfilters(properties); ++i) {
        unsigned flags = 0, config = 0;
        std::size_t values = 0;
        const H5Z_filter_t filter =
            H5Pget_filter2(properties, unsigned(i), &flags, &values, nullptr, 0, nullptr, &config);
        if (filter != H5Z_FILTER_DEFLATE && filter != H5Z_FILTER_SHUFFLE && filter != H5Z_FILTER_FLETCHER32)
            throw Unsupported(dataset.label + ": compressed with HDF5 filter " + std::to_string(filter) +
                              ", not with deflate");
    }
}

void checkChunks(Hdf5Dataset& dataset, hid_t properties, std::uint64_t item, std::uint64_t most) {
    dataset.chunk.resize(dataset.shape.size());
    if (H5Pget_chunk(properties, int(dataset.chunk.size()), dataset.chunk.data()) != int(dataset.chunk.size()))
        throw InvalidInput(dataset.label + ": chunks with another number of axes");
    checkedBytes(dataset.label, dataset.chunk, item, most);
    hsize_t needed = 1, present = 0;
    for (std::size_t axis = 0; axis < dataset.shape.size(); ++axis)
        needed *= (dataset.shape[axis] + dataset.chunk[axis] - 1) / dataset.chunk[axis];
    const Hdf5Handle space = fromFile(H5Dget_space(dataset.id), H5Sclose, dataset.label, "no shape");
    if (H5Dget_num_chunks(dataset.id, space, &present) < 0 || present != needed)
        throw InvalidInput(dataset.label + ": parts of it were never written");
}

void checkStorage(Hdf5Dataset& dataset, std::uint64_t item, std::uint64_t file_length) {
    const Hdf5Handle properties =
        fromFile(H5Dget_create_plist(dataset.id), H5Pclose, dataset.label, "no creation properties");
    if (H5Pget_external_count(properties) != 0) throw InvalidInput(dataset.label + ": is stored outside of the file");
    checkFilters(dataset, properties);
    const H5D_layout_t layout = H5Pget_layout(properties);
    const std::uint64_t most = layout == H5D_CHUNKED ? kMaxExpansion * file_length : file_length;
    const std::uint64_t bytes = checkedBytes(dataset.label, dataset.shape, item, most);
    if (layout == H5D_CHUNKED) return checkChunks(dataset, properties, item, most);
    if (layout != H5D_CONTIGUOUS && layout != H5D_COMPACT)
        throw InvalidInput(dataset.label + ": is stored outside of the file");
    if (H5Dget_storage_size(dataset.id) < bytes) throw InvalidInput(dataset.label + ": was never written");
}

Hdf5Dataset openDataset(const Hdf5Reader& in, const std::string& path) {
    initHdf5();
    const std::string label = in.name + ": " + path;
    const std::optional<haddr_t> address = addressOf(in, path);
    if (!address) throw InvalidInput(label + ": missing");
    if (storedElsewhere(in.bytes(), *address, label)) throw InvalidInput(label + ": is stored outside of the file");
    return {fromFile(H5Dopen2(in.file, path.c_str(), H5P_DEFAULT), H5Dclose, label, "is not a dataset"), label, {}, {}};
}

// Opens numbers of `type_class` and checks their type, shape and storage.
Hdf5Dataset openNumbers(const Hdf5Reader& in, const std::string& path, std::vector<hsize_t>& expected,
                        H5T_class_t type_class) {
    Hdf5Dataset dataset = openDataset(in, path);
    const Hdf5Handle type = fromFile(H5Dget_type(dataset.id), H5Tclose, dataset.label, "no type");
    const std::size_t item = H5Tget_size(type);
    if (H5Tget_class(type) != type_class || item > 8)
        throw InvalidInput(dataset.label + (type_class == H5T_FLOAT ? ": is not of floats" : ": is not of integers"));
    if (type_class == H5T_FLOAT) {
        dataset.half = H5Tequal(type, halfType()) > 0;
        bool known = dataset.half;
        for (hid_t standard : {H5T_IEEE_F32LE, H5T_IEEE_F64LE, H5T_IEEE_F32BE, H5T_IEEE_F64BE})
            known = known || H5Tequal(type, standard) > 0;
        if (!known) throw InvalidInput(dataset.label + ": floats of an unknown kind");
    } else if (H5Tget_precision(type) != 8 * item) {
        throw InvalidInput(dataset.label + ": integers of an unknown kind");
    }
    readShape(dataset, expected);
    checkStorage(dataset, item, in.length);
    return dataset;
}

}  // namespace

void cacheOneFrame(const Hdf5Reader& in, const std::string& path, Hdf5Dataset& dataset) {
    if (dataset.chunk.empty() || dataset.count() == 0) return;
    constexpr std::size_t kMaxNumberBytes = std::size_t(256) << 20;
    std::size_t bytes = dataset.half ? 2 : 4;
    for (std::size_t axis = 0; axis < dataset.shape.size(); ++axis) {
        const hsize_t chunk = dataset.chunk[axis];
        const hsize_t entries = axis == 0 ? chunk : (dataset.shape[axis] + chunk - 1) / chunk * chunk;
        if (entries > kMaxNumberBytes / bytes) return;
        bytes *= entries;
    }
    const Hdf5Handle access(H5Pcreate(H5P_DATASET_ACCESS), H5Pclose, dataset.label);
    H5Pset_chunk_cache(access, 12421, std::max<std::size_t>(2 * bytes, 1 << 20), 0.75);
    dataset.id = Hdf5Handle();  // closed first: a second handle on an open dataset shares the first one's cache
    dataset.id = fromFile(H5Dopen2(in.file, path.c_str(), access), H5Dclose, dataset.label, "is not a dataset");
}

Hdf5Dataset openFloats(const Hdf5Reader& in, const std::string& path, std::vector<hsize_t>& expected) {
    return openNumbers(in, path, expected, H5T_FLOAT);
}

namespace {

template <class T>
void checkFinite(const std::string& label, std::span<const T> values) {
    for (T value : values)
        if (!std::isfinite(value)) throw InvalidInput(label + ": not a finite number in it");
}

void readRaw(const Hdf5Dataset& dataset, hid_t type, hid_t memory, hid_t file, void* out) {
    if (H5Dread(dataset.id, type, memory, file, H5P_DEFAULT, out) >= 0) return;
    const std::string reason = hdf5Reason();
    if (!reason.empty()) throw IoError(dataset.label + ": cannot read: " + reason);
    throw InvalidInput(dataset.label + ": damaged");
}

void readFloatsFrom(const Hdf5Dataset& dataset, hid_t memory, hid_t file, std::span<float> out) {
    initHdf5();
    if (out.empty()) return;
    if (dataset.half) {
        std::vector<std::uint16_t> halves(out.size());
        readRaw(dataset, halfType(), memory, file, halves.data());
        halfToFloat(halves, out);
    } else {
        readRaw(dataset, H5T_NATIVE_FLOAT, memory, file, out.data());
    }
    checkFinite<float>(dataset.label, out);
}

}  // namespace

void readPart(const Hdf5Dataset& dataset, const std::vector<hsize_t>& begin, const std::vector<hsize_t>& count,
              std::span<float> out) {
    assert(begin.size() == dataset.shape.size() && count.size() == dataset.shape.size());
    const Hdf5Handle file = fromFile(H5Dget_space(dataset.id), H5Sclose, dataset.label, "no shape");
    const Hdf5Handle memory(H5Screate_simple(int(count.size()), count.data(), nullptr), H5Sclose, dataset.label);
    checkHdf5(H5Sselect_hyperslab(file, H5S_SELECT_SET, begin.data(), nullptr, count.data(), nullptr), dataset.label);
    readFloatsFrom(dataset, memory, file, out);
}

std::vector<float> readFloats(const Hdf5Reader& in, const std::string& path, std::vector<hsize_t>& expected) {
    const Hdf5Dataset dataset = openFloats(in, path, expected);
    std::vector<float> values(dataset.count());
    readFloatsFrom(dataset, H5S_ALL, H5S_ALL, values);
    return values;
}

std::vector<double> readDoubles(const Hdf5Reader& in, const std::string& path, std::vector<hsize_t>& expected) {
    const Hdf5Dataset dataset = openFloats(in, path, expected);
    std::vector<double> values(dataset.count());
    if (dataset.half) {
        const std::vector<float> floats = readFloats(in, path, expected);
        values.assign(floats.begin(), floats.end());
    } else if (!values.empty()) {
        readRaw(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, values.data());
    }
    checkFinite<double>(dataset.label, values);
    return values;
}

namespace {

std::string rangeMessage(std::int64_t value, std::int64_t least, std::int64_t most) {
    return ": " + std::to_string(value) + " is not in [" + std::to_string(least) + " - " + std::to_string(most) + "]";
}

}  // namespace

std::vector<std::int64_t> readIntegers(const Hdf5Reader& in, const std::string& path, std::vector<hsize_t>& expected,
                                       std::int64_t least, std::int64_t most) {
    const Hdf5Dataset dataset = openNumbers(in, path, expected, H5T_INTEGER);
    std::vector<std::int64_t> values(dataset.count());
    if (!values.empty()) readRaw(dataset, H5T_NATIVE_INT64, H5S_ALL, H5S_ALL, values.data());
    for (std::int64_t value : values)
        if (value < least || value > most) throw InvalidInput(dataset.label + rangeMessage(value, least, most));
    return values;
}

// --- Text -----------------------------------------------------------------------------------------------------------

namespace {

// Cuts `bytes` into strings of `size` bytes, each of which ends at a zero or at its full length.
std::vector<std::string> fixedStrings(const std::vector<char>& bytes, std::size_t size, std::size_t count) {
    std::vector<std::string> strings(count);
    for (std::size_t i = 0; i < count; ++i) strings[i].assign(&bytes[i * size], ::strnlen(&bytes[i * size], size));
    return strings;
}

// HDF5 gives no creation properties of such a dataset without reading its fill value, a text, from a global heap.
std::vector<std::string> variableStrings(const Hdf5Reader& in, const Hdf5Dataset& dataset) {
    const std::uint64_t bytes = checkedBytes(dataset.label, dataset.shape, kTextReferenceBytes, in.length);
    if (bytes == 0) return {};
    const hsize_t stored = H5Dget_storage_size(dataset.id);
    const haddr_t begin = H5Dget_offset(dataset.id);  // only contiguous storage has one
    if (stored > 0 && begin == HADDR_UNDEF) throw Unsupported(dataset.label + ": text of variable length in chunks");
    if (stored < bytes) throw InvalidInput(dataset.label + ": was never written");
    if (begin > in.length || bytes > in.length - begin) throw InvalidInput(dataset.label + ": damaged");
    GlobalHeaps heaps(in.bytes(), dataset.label);
    std::vector<std::string> strings;
    for (std::size_t i = 0; i < dataset.count(); ++i)
        strings.push_back(heaps.text(in.bytes().subspan(begin + i * kTextReferenceBytes).first<kTextReferenceBytes>()));
    return strings;
}

}  // namespace

std::vector<std::string> readStrings(const Hdf5Reader& in, const std::string& path) {
    Hdf5Dataset dataset = openDataset(in, path);
    const Hdf5Handle type = fromFile(H5Dget_type(dataset.id), H5Tclose, dataset.label, "no type");
    if (H5Tget_class(type) != H5T_STRING) throw InvalidInput(dataset.label + ": is not of text");
    std::vector<hsize_t> any{0};
    readShape(dataset, any);
    if (H5Tis_variable_str(type) > 0) return variableStrings(in, dataset);
    const std::size_t size = H5Tget_size(type);
    checkStorage(dataset, size, in.length);
    if (dataset.count() == 0) return {};
    std::vector<char> bytes(size * dataset.count());
    readRaw(dataset, type, H5S_ALL, H5S_ALL, bytes.data());
    return fixedStrings(bytes, size, dataset.count());
}

namespace {

struct Attribute {
    Hdf5Handle id, type;
    std::string label;
};

}  // namespace

bool hasAttribute(const Hdf5Reader& in, const std::string& object, const std::string& attribute) {
    return exists(in, object) && H5Aexists_by_name(in.file, object.c_str(), attribute.c_str(), H5P_DEFAULT) > 0;
}

namespace {

// Opens an attribute with a single value (or an array of one, as other writers make them).
Attribute openAttribute(const Hdf5Reader& in, const std::string& object, const std::string& attribute) {
    const std::string label = in.name + ": " + (object == "/" ? "" : object + " ") + "attribute " + attribute;
    if (!hasAttribute(in, object, attribute)) throw InvalidInput(label + ": missing");
    Attribute opened{fromFile(H5Aopen_by_name(in.file, object.c_str(), attribute.c_str(), H5P_DEFAULT, H5P_DEFAULT),
                              H5Aclose, label, "cannot be opened"),
                     {},
                     label};
    opened.type = fromFile(H5Aget_type(opened.id), H5Tclose, label, "no type");
    const Hdf5Handle space = fromFile(H5Aget_space(opened.id), H5Sclose, label, "no shape");
    if (H5Sget_simple_extent_npoints(space) != 1) throw InvalidInput(label + ": is not one value");
    return opened;
}

void readRawAttribute(const Attribute& attribute, hid_t type, void* out) {
    if (H5Aread(attribute.id, type, out) < 0) throw InvalidInput(attribute.label + ": damaged");
}

// Our conversion from text of variable length to opaque bytes: it leaves the references as they stand in the file,
// where HDF5's own conversion to text would follow them.
herr_t keepReferences(hid_t from, hid_t, H5T_cdata_t* data, std::size_t, std::size_t, std::size_t, void*, void*,
                      hid_t) {
    if (data->command != H5T_CONV_INIT) return 0;
    data->need_bkg = H5T_BKG_NO;
    return H5Tget_size(from) == kTextReferenceBytes ? 0 : -1;
}

Hdf5Handle textReferenceType() {
    Hdf5Handle opaque(H5Tcreate(H5T_OPAQUE, kTextReferenceBytes), H5Tclose, "HDF5 reference type");
    static std::once_flag once;
    std::call_once(once, [&] {
        const Hdf5Handle text(H5Tcopy(H5T_C_S1), H5Tclose, "HDF5 text type");
        checkHdf5(H5Tset_size(text, H5T_VARIABLE), "HDF5 text type");
        checkHdf5(H5Tregister(H5T_PERS_SOFT, "references of text", text, opaque, keepReferences), "HDF5 conversion");
    });
    return opaque;
}

std::string variableText(const Hdf5Reader& in, const Attribute& attribute) {
    std::array<std::byte, kTextReferenceBytes> reference;
    readRawAttribute(attribute, textReferenceType(), reference.data());
    return GlobalHeaps(in.bytes(), attribute.label).text(reference);
}

}  // namespace

std::string readTextAttribute(const Hdf5Reader& in, const std::string& object, const std::string& name) {
    const Attribute attribute = openAttribute(in, object, name);
    if (H5Tget_class(attribute.type) != H5T_STRING) throw InvalidInput(attribute.label + ": is not text");
    if (H5Tis_variable_str(attribute.type) > 0) return variableText(in, attribute);
    const std::size_t size = H5Tget_size(attribute.type);
    if (size > in.length) throw InvalidInput(attribute.label + ": larger than the file can hold");
    std::vector<char> bytes(size);
    readRawAttribute(attribute, attribute.type, bytes.data());
    return fixedStrings(bytes, size, 1)[0];
}

double readNumberAttribute(const Hdf5Reader& in, const std::string& object, const std::string& name) {
    const Attribute attribute = openAttribute(in, object, name);
    const H5T_class_t type_class = H5Tget_class(attribute.type);
    if ((type_class != H5T_FLOAT && type_class != H5T_INTEGER) || H5Tget_size(attribute.type) > 8)
        throw InvalidInput(attribute.label + ": is not a number");
    double value = 0;
    readRawAttribute(attribute, H5T_NATIVE_DOUBLE, &value);
    checkFinite<double>(attribute.label, std::span(&value, 1));
    return value;
}

std::int64_t readIntegerAttribute(const Hdf5Reader& in, const std::string& object, const std::string& name,
                                  std::int64_t least, std::int64_t most) {
    const Attribute attribute = openAttribute(in, object, name);
    if (H5Tget_class(attribute.type) != H5T_INTEGER || H5Tget_size(attribute.type) > 8)
        throw InvalidInput(attribute.label + ": is not an integer");
    std::int64_t value = 0;
    readRawAttribute(attribute, H5T_NATIVE_INT64, &value);
    if (value < least || value > most) throw InvalidInput(attribute.label + rangeMessage(value, least, most));
    return value;
}

}  // namespace penumbra
