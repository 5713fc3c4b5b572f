#include "formats/stage/stored_size.h"

#include "formats/common/fp16.h"
#include "formats/stage/hdf5_handle.h"

namespace penumbra {

double storedSize(std::span<const float> values, const std::vector<std::size_t>& shape, Precision precision) {
    initHdf5();
    const char* what = "size estimate";
    const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, what);
    checkHdf5(H5Pset_fapl_core(access, std::size_t(1) << 20, false), what);  // in memory
    const Hdf5Handle file(H5Fcreate("penumbra", H5F_ACC_TRUNC, H5P_DEFAULT, access), H5Fclose, what);
    const std::vector<hsize_t> extent(shape.begin(), shape.end());
    const bool half = precision == Precision::kFloat16;
    const Hdf5Handle half_type = halfType();
    const Hdf5Handle dataset = createDataset(file, "/x", half ? hid_t(half_type) : H5T_IEEE_F32LE, extent, extent);
    if (half) {
        std::vector<std::uint16_t> halves(values.size());
        floatToHalf(values, halves);
        checkHdf5(H5Dwrite(dataset, half_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, halves.data()), what);
    } else {
        checkHdf5(H5Dwrite(dataset, H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), what);
    }
    checkHdf5(H5Fflush(file, H5F_SCOPE_GLOBAL), what);
    return double(H5Dget_storage_size(dataset));
}

}  // namespace penumbra
