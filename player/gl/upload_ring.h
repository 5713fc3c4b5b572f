#pragma once
// What the CPU sends to shaders anew every frame. Allocated once, in parts that take turns: one is written while the
// GPU still reads older ones. With buffer storage (OpenGL 4.4) the parts are mapped for good, and what is written there
// is what shaders read; without it the driver copies each part.
#include <array>
#include <memory>
#include <type_traits>
#include <vector>

#include "player/gl/gl_objects.h"

namespace penumbra {

class UploadRing {
public:
    UploadRing() = default;
    // Unsupported when a part is larger than a storage block may be.
    explicit UploadRing(std::size_t floats_per_part);

    std::size_t bytes() const { return kParts * part_bytes_; }  // of GL memory
    // The next part, to be written from its start to its end and not to be read: it may be memory that only writing is
    // fast in. Waits while the GPU reads it, which is when the CPU is ahead by kParts frames.
    std::span<float> next();
    // The part that was written, as storage block `binding`.
    void bind(GLuint binding);
    // After the last command that reads the part.
    void release();

private:
    static constexpr std::size_t kParts = 3;
    struct DeleteSync {
        void operator()(GLsync fence) const { gl::DeleteSync(fence); }
    };
    using Fence = std::unique_ptr<std::remove_pointer_t<GLsync>, DeleteSync>;
    GlObject buffer_;
    std::array<Fence, kParts> fences_;
    std::size_t floats_ = 0, part_bytes_ = 0, part_ = 0;  // of one part; part_bytes_ is a multiple of what offsets are
    float* mapped_ = nullptr;                             // all parts; null without buffer storage
    std::vector<float> unmapped_;                         // one part
};

}  // namespace penumbra
