#pragma once
// Sends shaders what the CPU computes anew every frame. Memory is allocated once, in parts that take turns: the CPU
// writes one while the GPU still reads older ones. With buffer storage (OpenGL 4.4) the parts stay mapped, and
// shaders read what is written there; without it the driver copies each part.
#include <array>
#include <memory>
#include <type_traits>
#include <vector>

#include "player/gl/gl_objects.h"

namespace penumbra {

class UploadRing {
public:
    UploadRing() = default;
    // Throws Unsupported when a part is larger than a storage block may be.
    explicit UploadRing(std::size_t floats_per_part);

    std::size_t bytes() const { return kParts * part_bytes_; }  // size in GL memory
    // Returns the next part. Write it from its start to its end and do not read it, since it may be memory that only
    // writing is fast in. Waits while the GPU reads it, which happens when the CPU is ahead by kParts frames.
    std::span<float> next();
    // Binds the part that was written as storage block `binding`.
    void bind(GLuint binding);
    // Call this after the last command that reads the part.
    void release();

private:
    static constexpr std::size_t kParts = 3;
    struct DeleteSync {
        void operator()(GLsync fence) const { gl::DeleteSync(fence); }
    };
    using Fence = std::unique_ptr<std::remove_pointer_t<GLsync>, DeleteSync>;
    GlObject buffer_;
    std::array<Fence, kParts> fences_;
    // sizes of one part; part_bytes_ is a multiple of the alignment of offsets
    std::size_t floats_ = 0, part_bytes_ = 0, part_ = 0;
    float* mapped_ = nullptr;      // all parts; null without buffer storage
    std::vector<float> unmapped_;  // one part
};

}  // namespace penumbra
