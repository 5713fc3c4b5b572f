#pragma once
// The GLSL path: evaluates and draws characters of one asset on the GPU, all of them by one dispatch and one draw. A
// frame is one upload of a few kilobytes a character; nothing is allocated, in GL or here.
#include <memory>

#include "player/draw/gl_asset.h"
#include "player/gl/upload_ring.h"

namespace penumbra {

// One of the characters, for one frame.
struct PosedCharacter {
    const Evaluator* evaluator = nullptr;      // has the pose
    Vec3 offset = {};                          // of its model frame in the scene
    const ShadingSet* shading = nullptr;       // what is on in it; for kShaded
    std::span<const float> numbers = {};       // [V, stride], in the place of the model's, or empty
    std::span<const float> true_ambient = {};  // [V], for kError
};

class ModelPainter {
public:
    // For at most `capacity` characters at once. Unsupported when that many are too many for this OpenGL.
    ModelPainter(std::shared_ptr<GlAsset> asset, std::size_t capacity);

    // Uploads and evaluates the characters for the channel, as seen from `eye` (in the scene).
    void evaluate(Channel channel, std::span<const PosedCharacter> characters, Vec3 eye);
    // Draws what was evaluated last; any number of times. `view` is of the scene.
    void draw(const FrameView& view) const;

    std::size_t bytes() const;  // of GL memory, beside the asset's

private:
    std::shared_ptr<GlAsset> asset_;
    std::size_t capacity_, count_ = 0;
    Channel channel_ = Channel::kShaded;
    bool has_numbers_ = false;  // any of them, given
    UploadRing poses_;
    std::optional<UploadRing> numbers_, true_ambient_, vertices_;  // made when they are first needed
    TextureBuffer evaluated_;

    std::size_t evaluatedBytes() const;
    void uploadPoses(std::span<const PosedCharacter> characters);
    // `member` of the characters that have it, [of_one] floats each.
    void uploadArrays(std::optional<UploadRing>& ring, std::span<const PosedCharacter> characters,
                      std::span<const float> PosedCharacter::*member, std::size_t of_one);
    void uploadVertices(std::span<const PosedCharacter> characters);
    void uploadNumbers(std::span<const PosedCharacter> characters);
    void release();
};

}  // namespace penumbra
