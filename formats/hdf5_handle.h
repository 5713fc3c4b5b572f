#pragma once
// RAII over HDF5's C API, and the few calls that our files need. Files are byte-identical on a rerun: no object time
// stamps. Included by formats/*_file.cpp only.
#include <hdf5.h>

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace penumbra {

class Hdf5Handle {
public:
    using Closer = herr_t (*)(hid_t);
    Hdf5Handle() = default;
    Hdf5Handle(hid_t id, Closer closer, std::string_view what);  // IoError "HDF5: what" if id < 0
    Hdf5Handle(Hdf5Handle&& other) noexcept;
    Hdf5Handle& operator=(Hdf5Handle&& other) noexcept;
    ~Hdf5Handle();
    operator hid_t() const { return id_; }

private:
    hid_t id_ = -1;
    Closer closer_ = nullptr;
};

// Reading: `file` names the file in messages. Sizes are checked against `expected` (and the file's length) before
// anything is allocated; an entry of 0 in `expected` takes any size and is set. Non-finite floats are InvalidInput.
struct Hdf5Reader {
    Hdf5Handle file;
    std::string name;
};
Hdf5Reader openHdf5(const std::filesystem::path& path);  // IoError when it cannot be read, InvalidInput when not HDF5
Hdf5Handle createHdf5(const std::filesystem::path& path);

bool exists(const Hdf5Reader& in, const std::string& path);
std::vector<float> readFloats(const Hdf5Reader& in, const std::string& dataset, std::vector<hsize_t>& expected);
std::vector<double> readDoubles(const Hdf5Reader& in, const std::string& dataset, std::vector<hsize_t>& expected);
std::vector<std::int64_t> readIntegers(const Hdf5Reader& in, const std::string& dataset, std::vector<hsize_t>& expected,
                                       std::int64_t least, std::int64_t most);
std::vector<std::string> readStrings(const Hdf5Reader& in, const std::string& dataset);
std::string readTextAttribute(const Hdf5Reader& in, const std::string& object, const std::string& attribute);
double readNumberAttribute(const Hdf5Reader& in, const std::string& object, const std::string& attribute);
bool hasAttribute(const Hdf5Reader& in, const std::string& object, const std::string& attribute);

// Writing; groups in the path are made. `type` is the type in the file (H5T_STD_U32LE, H5T_IEEE_F32LE, ...).
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
