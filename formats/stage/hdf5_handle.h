#pragma once
// RAII over HDF5's C API, and the few calls that our files need. Files carry no object time stamps, so that a rerun
// gives the same bytes. Their metadata carries checksums (file format of HDF5 1.10). Only *_file.cpp and the like in
// formats/ include this.
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
    Hdf5Handle(hid_t id, Closer closer, std::string_view what);  // throws IoError "what: reason" if id < 0
    Hdf5Handle(Hdf5Handle&& other) noexcept;
    Hdf5Handle& operator=(Hdf5Handle&& other) noexcept;
    ~Hdf5Handle();
    void close(std::string_view what);  // throws IoError when data did not reach the disk; does nothing when empty
    operator hid_t() const { return id_; }

private:
    hid_t id_ = -1;
    Closer closer_ = nullptr;
};

// Call this before any other HDF5 call of a thread, so that HDF5 neither prints nor does anything at exit.
void initHdf5();
// Returns what the operating system said in the last failed HDF5 call of this thread ("No space left on device"), or
// "".
std::string hdf5Reason();
// Throws IoError "what: reason" if the call failed.
void checkHdf5(herr_t result, std::string_view what);

// --- Reading --------------------------------------------------------------------------------------------------------
// `name` starts every message. Sizes are checked against `expected` and against the file's length before anything is
// allocated. An entry of 0 in `expected` takes any size and is set to it. Non-finite floats are InvalidInput. So is
// anything that would let a file reach into another one (soft and external links, external and virtual storage), and
// data that were never written.
struct Hdf5Reader {
    Hdf5Handle file;
    std::string name;
    std::uint64_t length = 0;  // bytes
    std::shared_ptr<const std::byte> mapped;
    std::span<const std::byte> bytes() const { return {mapped.get(), length}; }
};
// throws IoError when it cannot be read, InvalidInput when it is not HDF5
Hdf5Reader openHdf5(const std::filesystem::path& path);

// An open dataset whose type, shape, storage and filters have been checked.
struct Hdf5Dataset {
    Hdf5Handle id;
    std::string label;                  // "file: /dataset", starts messages
    std::vector<hsize_t> shape, chunk;  // chunk is empty for contiguous storage
    bool half = false;                  // IEEE binary16, which is read as halfType() and which we convert ourselves
    std::size_t count() const;
};
Hdf5Dataset openFloats(const Hdf5Reader& in, const std::string& dataset, std::vector<hsize_t>& expected);
// Opens the dataset again with room for every chunk that crosses one entry of the first axis (a frame). A reader who
// goes frame by frame then decompresses each chunk only once. It costs that much memory.
void cacheOneFrame(const Hdf5Reader& in, const std::string& dataset, Hdf5Dataset& opened);
// Reads the part [begin, begin + count) along each axis. out.size() is the product of `count`.
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
// IoError that names the file. The handle of createHdf5() must be closed with closeHdf5(), because only that reports
// a full disk.
Hdf5Handle createHdf5(const std::filesystem::path& path);
void closeHdf5(Hdf5Handle& file);

Hdf5Handle halfType();
// Creates a dataset that is written in parts. It is compressed by shuffle + deflate 1 when `chunk` is not empty.
// `type` is a type as above, or halfType().
Hdf5Handle createDataset(hid_t file, const std::string& dataset, hid_t type, const std::vector<hsize_t>& shape,
                         const std::vector<hsize_t>& chunk);
// A run of frames for a virtual dataset, whose first axis (frames) comes from datasets of the same name in other
// files. Entries from, from + 1, ... of `file` are entries to, to + stride, ... here. Names are relative to the
// folder of this file. NaN stands for what is missing.
struct Hdf5Run {
    std::string file;
    hsize_t file_frames;  // length of the first axis in that file
    hsize_t from, to, count, stride;
};
void createVirtualDataset(hid_t file, const std::string& dataset, hid_t type, const std::vector<hsize_t>& shape,
                          const std::vector<Hdf5Run>& runs);
void makeGroup(hid_t file, const std::string& path);
void writeFloats(hid_t file, const std::string& dataset, std::span<const float> values,
                 const std::vector<hsize_t>& shape);
void writeDoubles(hid_t file, const std::string& dataset, std::span<const double> values,
                  const std::vector<hsize_t>& shape);
void writeBytes(hid_t file, const std::string& dataset, std::span<const std::int8_t> values,
                const std::vector<hsize_t>& shape, const std::vector<hsize_t>& chunk);
void writeIntegers(hid_t file, const std::string& dataset, std::span<const std::int64_t> values,
                   const std::vector<hsize_t>& shape, hid_t type);
void writeStrings(hid_t file, const std::string& dataset, const std::vector<std::string>& values);
void writeTextAttribute(hid_t file, const std::string& object, const std::string& attribute, const std::string& value);
void writeNumberAttribute(hid_t file, const std::string& object, const std::string& attribute, double value);
void writeIntegerAttribute(hid_t file, const std::string& object, const std::string& attribute, std::int64_t value);

}  // namespace penumbra
