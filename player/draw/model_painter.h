#pragma once
// The GLSL path evaluates and draws characters of one asset on the GPU, all of them by one dispatch and one draw. A
// frame uploads a few kilobytes for each character, and allocates nothing, neither in GL nor here.
#include <memory>

#include "player/draw/gl_asset.h"
#include "player/draw/gl_cast.h"
#include "player/gl/upload_ring.h"

namespace penumbra {

// One of the characters, for one frame.
struct PosedCharacter {
    const Evaluator* evaluator = nullptr;  // it has the pose
    Affine to_scene = {};                  // from its model frame: a rotation and a translation
    const ShadingSet* shading = nullptr;   // what is on in it, with the light in its model frame; only for kShaded
    // [V, stride], in the place of the model's; empty: the GPU evaluates the model, unless
    // GlAsset::needsCoefficients().
    std::span<const float> coefficients = {};
    std::span<const float> true_ambient = {};  // [V], only for kError
    std::size_t caster = kNobody;              // which of GlCast's it is
    // Of every slot; empty: no suns shine on it. Either all characters have them or none. Only for kShaded, and then
    // `shading` has its suns on.
    std::span<const SlotLobes> lobes = {};
};

// The place of a character that is not turned.
constexpr Affine placedAt(Vec3 p) { return {{1, 0, 0, p.x, 0, 1, 0, p.y, 0, 0, 1, p.z}}; }

class ModelPainter {
public:
    // Has room for `capacity` characters at once. Throws Unsupported when that many are too many for this OpenGL.
    ModelPainter(std::shared_ptr<GlAsset> asset, std::size_t capacity);

    // Uploads the characters and evaluates them for the channel, as seen from `eye` (in the scene). Their numbers are
    // multiplied by what others leave visible, unless `cast` is null.
    void evaluate(Channel channel, std::span<const PosedCharacter> characters, Vec3 eye, GlCast* cast = nullptr);
    // Draws what was evaluated last, any number of times. `view` is the view of the scene. `suns` are not null where
    // they shine, and stand in the scene.
    void draw(const FrameView& view, const Sunlight* suns = nullptr) const;

    std::size_t bytes() const;  // bytes of GL memory besides the asset's

private:
    std::shared_ptr<GlAsset> asset_;
    std::size_t capacity_, count_ = 0;
    Channel channel_ = Channel::kShaded;
    bool has_coefficients_ = false;        // some character has given numbers
    bool sunlit_ = false;                  // what was evaluated
    std::size_t quads_ = kEvaluatedQuads;  // of a vertex, that evaluated_ has room for
    UploadRing poses_;
    std::optional<UploadRing> coefficients_, true_ambient_, vertices_;  // made when they are first needed
    std::optional<GlObject> anchors_;                                   // values of a composed asset's anchors
    std::optional<GlObject> receivers_, casts_;                         // made when there is a cast
    std::size_t cast_sets_ = 0;                                         // that casts_ has room for
    std::optional<GlCastAnchors> cast_anchors_;                         // of casts
    TextureBuffer evaluated_;

    std::size_t evaluatedBytes() const;
    void makeRoom();
    std::size_t anchorBytes() const;
    void evaluateAnchors();
    void uploadPoses(std::span<const PosedCharacter> characters);
    // Uploads `member`, [of_one] floats each, of the characters that have it.
    void uploadArrays(std::optional<UploadRing>& ring, std::span<const PosedCharacter> characters,
                      std::span<const float> PosedCharacter::*member, std::size_t of_one);
    void uploadVertices(std::span<const PosedCharacter> characters);
    void uploadCoefficients(std::span<const PosedCharacter> characters);
    void bind();
    void castOnVertices(GlCast& cast, const Evaluator& evaluator);
    void dispatch(const GlAsset::Program& program, std::size_t invocations) const;
    void release();
};

}  // namespace penumbra
