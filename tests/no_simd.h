#pragma once
// Sets PENUMBRA_NO_SIMD while it lives and then restores what was there, for the tests that follow in the process.
#include <cstdlib>
#include <optional>
#include <string>

namespace penumbra {

class NoSimd {
public:
    NoSimd() {
        if (const char* value = std::getenv("PENUMBRA_NO_SIMD")) before_ = value;
        ::setenv("PENUMBRA_NO_SIMD", "1", 1);
    }
    ~NoSimd() {
        if (before_) {
            ::setenv("PENUMBRA_NO_SIMD", before_->c_str(), 1);
        } else {
            ::unsetenv("PENUMBRA_NO_SIMD");
        }
    }
    NoSimd(const NoSimd&) = delete;
    NoSimd& operator=(const NoSimd&) = delete;

private:
    std::optional<std::string> before_;
};

}  // namespace penumbra
