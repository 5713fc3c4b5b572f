#include "formats/stage/hdf5_handle.h"

#include <mutex>
#include <utility>

#include "formats/common/errors.h"

namespace penumbra {

void initHdf5() {
    // After a failed write HDF5 would try again at exit, and complain, hang or crash there. We report the failure
    // where it happens. HDF5 must hear this before it starts.
    static std::once_flag once;
    std::call_once(once, [] { H5dont_atexit(); });
    thread_local const herr_t silent = H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // HDF5 has one error stack per
                                                                                     // thread
    (void)silent;
}

std::string hdf5Reason() {
    std::string reason;
    const auto visit = [](unsigned, const H5E_error2_t* error, void* out) -> herr_t {
        // The file driver writes "..., errno = 28, error message = 'No space left on device', ...".
        const std::string text = error->desc ? error->desc : "";
        const std::string mark = "error message = '";
        const std::size_t begin = text.find(mark);
        if (begin == std::string::npos) return 0;
        const std::size_t end = text.find('\'', begin + mark.size());
        *static_cast<std::string*>(out) = text.substr(begin + mark.size(), end - begin - mark.size());
        return 1;
    };
    H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, visit, &reason);
    return reason == "Success" ? "" : reason;  // errno was 0: the file is wrong, not the system
}

namespace {

IoError failed(std::string_view what) {
    const std::string reason = hdf5Reason();
    return IoError(std::string(what) + (reason.empty() ? ": HDF5 failed" : ": " + reason));
}

}  // namespace

void checkHdf5(herr_t result, std::string_view what) {
    if (result < 0) throw failed(what);
}

Hdf5Handle::Hdf5Handle(hid_t id, Closer closer, std::string_view what) : id_(id), closer_(closer) {
    if (id < 0) throw failed(what);
}

Hdf5Handle::Hdf5Handle(Hdf5Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), closer_(other.closer_) {}

Hdf5Handle& Hdf5Handle::operator=(Hdf5Handle&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(closer_, other.closer_);
    return *this;
}

Hdf5Handle::~Hdf5Handle() {
    if (id_ >= 0) closer_(id_);
}

void Hdf5Handle::close(std::string_view what) {
    const hid_t id = std::exchange(id_, -1);
    if (id >= 0 && closer_(id) < 0) throw failed(what);
}

}  // namespace penumbra
