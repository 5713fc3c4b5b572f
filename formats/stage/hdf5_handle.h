#pragma once
// RAII over HDF5's C API, and the few calls that our files need. Files are byte-identical on a rerun: no object time
// stamps. Their metadata carries checksums (file format of HDF5 1.10). Included by formats/*_file.cpp and the like
// only.
#include <hdf5.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace penumbra {

class Hdf5Handle {
public:
    using Closer = herr_t (*)(hid_t);
    Hdf5Handle() = default;
    Hdf5Handle(hid_t id, Closer closer, std::string_view what);  // IoError "what: reason" if id < 0
    Hdf5Handle(Hdf5Handle&& other) noexcept;
    Hdf5Handle& operator=(Hdf5Handle&& other) noexcept;
    ~Hdf5Handle();
    void close(std::string_view what);  // IoError when what was written does not reach the disk; no-op when empty
    operator hid_t() const { return id_; }

private:
    hid_t id_ = -1;
    Closer closer_ = nullptr;
};

// Before any other HDF5 call of a thread: HDF5 shall neither print nor do anything at exit.
void initHdf5();
// What the operating system said in the last failed HDF5 call of this thread ("No space left on device"), else "".
std::string hdf5Reason();
// IoError "what: reason" if the call failed.
void checkHdf5(herr_t result, std::string_view what);

// --- Reading --------------------------------------------------------------------------------------------------------
// `name` starts every message. Sizes are checked against `expected` and the file's length before anything is allocated;
// an entry of 0 in `expected` takes any size and is set. Non-finite floats are InvalidInput. So is whatever would let a
// file reach into another one (soft and external links, external and virtual storage), and what was never written.
struct Hdf5Reader {
    Hdf5Handle file;
    std::string name;
    std::uint64_t length = 0;  // bytes
    std::shared_ptr<const std::byte> mapped;
    std::span<const std::byte> bytes() const { return {mapped.get(), length}; }
};
Hdf5Reader openHdf5(const std::filesystem::path& path);  // IoError when it cannot be read, InvalidInput when not HDF5

// An open dataset whose type, shape, storage and filters have been checked.
struct Hdf5Dataset {
    Hdf5Handle id;
    std::string label;                  // "file: /dataset", starts messages
    std::vector<hsize_t> shape, chunk;  // chunk is empty for contiguous storage
    bool half = false;                  // IEEE binary16, to be read as halfType() and converted by us
    std::size_t count() const;
};
Hdf5Dataset openFloats(const Hdf5Reader& in, const std::string& dataset, std::vector<hsize_t>& expected);
// Opens it again with room for every chunk that crosses one entry of the first axis (a frame), so that a reader who
// goes frame by frame decompresses each chunk once. Costs that much memory.
void cacheOneFrame(const Hdf5Reader& in, const std::string& dataset, Hdf5Dataset& opened);
// The part [begin, begin + count) along each axis; out.size() is the product of `count`.
void readPart(const Hdf5Dataset& dataset, const std::vector<hsize_t>& begin, const std::vector<hsize_t>& count,
              std::span<float> out);

bool exists(const Hdf5Reader& in, const std::string& path);
std::vector<float> readFloats(const Hdf5Reader& in, const std::string& dataset, std::vector<hsize_t>& expected);
std::vector<double> readDoubles(const Hdf5Reader& in, const std::string& dataset, std::vector<hsize_t>& expected);
std::vector<std::int64_t> readIntegers(const Hdf5Reader& in, const std::string& dataset, std::vector<hsize_t>& expected,
                                       std::int64_t least, std::int64_t most);
std::vector<std::string> readStrings(const Hdf5Reader& in, const std::string& dataset);
std::string readTextAttribute(const Hdf5Reader& in, const std::string& object, const std::string& attribute);
double readNumberAttribute(const Hdf5Reader& in, const std::string& object, const std::string& attribute);
std::int64_t readIntegerAttribute(const Hdf5Reader& in, const std::string& object, const std::string& attribute,
                                  std::int64_t least, std::int64_t most);
bool hasAttribute(const Hdf5Reader& in, const std::string& object, const std::string& attribute);

// --- Writing --------------------------------------------------------------------------------------------------------
// Groups in the path are made. `type` is the type in the file (H5T_STD_U32LE, H5T_IEEE_F32LE, ...). A failure is an
// IoError that names the file. The handle of createHdf5() must be closed with closeHdf5(): only that tells of a full
// disk.
Hdf5Handle createHdf5(const std::filesystem::path& path);
void closeHdf5(Hdf5Handle& file);

Hdf5Handle halfType();
// A dataset to be written in parts; shuffle + deflate 1 when `chunk` is not empty. `type` as above or halfType().
Hdf5Handle createDataset(hid_t file, const std::string& dataset, hid_t type, const std::vector<hsize_t>& shape,
                         const std::vector<hsize_t>& chunk);
// A dataset whose first axis (frames) is taken from others of the same name: entries from, from + 1, ... of `file` are
// entries to, to + stride, ... here. Names are relative to the folder of this file. NaN stands for what is missing.
struct Hdf5Run {
    std::string file;
    hsize_t file_frames;  // length of the first axis there
    hsize_t from, to, count, stride;
};
void createVirtualDataset(hid_t file, const std::string& dataset, hid_t type, const std::vector<hsize_t>& shape,
                          const std::vector<Hdf5Run>& runs);
void makeGroup(hid_t file, const std::string& path);
void writeFloats(hid_t file, const std::string& dataset, std::span<const float> values,
                 const std::vector<hsize_t>& shape);
void writeDoubles(hid_t file, const std::string& dataset, std::span<const double> values,
                  const std::vector<hsize_t>& shape);
void writeIntegers(hid_t file, const std::string& dataset, std::span<const std::int64_t> values,
                   const std::vector<hsize_t>& shape, hid_t type);
void writeStrings(hid_t file, const std::string& dataset, const std::vector<std::string>& values);
void writeTextAttribute(hid_t file, const std::string& object, const std::string& attribute, const std::string& value);
void writeNumberAttribute(hid_t file, const std::string& object, const std::string& attribute, double value);
void writeIntegerAttribute(hid_t file, const std::string& object, const std::string& attribute, std::int64_t value);

}  // namespace penumbra
