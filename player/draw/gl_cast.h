#pragma once
// Casts on the GPU, for the GLSL path: what the casters of a scene hide from vertices that stand in a storage buffer.
// It gives what CastShadow (runtime/cast/cast_shadow.h) gives.
#include <map>
#include <span>
#include <vector>

#include "player/draw/shader_source.h"
#include "player/gl/gl_objects.h"
#include "player/gl/upload_ring.h"
#include "runtime/cast/cast_shadow.h"

namespace penumbra {

struct GlCaster {
    const Evaluator* evaluator = nullptr;  // it has the pose
    CasterKind kind = CasterKind::kFields;
    Affine to_scene = {};  // a rotation and a translation
};

// A receiver in its buffer, in vec4: position and the index of its own caster (-1: none), normal, tangent.
constexpr std::size_t kReceiverQuads = 3;
// The result for a receiver: 21 numbers, mirrored in its local frame, and 1 if any caster counts.
constexpr std::size_t kCastQuads = 6;
// Words of an anchor (shaders/cast_anchors.glsl), which has room for 66 parts and spheres that are near.
constexpr std::size_t kCastAnchorWords = 128;

// The anchors of characters of one asset, whose vertices are the receivers (Evaluator::castLayout()).
class GlCastAnchors {
public:
    // Has room for `capacity` characters. Throws Unsupported where they are too many for this OpenGL.
    GlCastAnchors(const FarLayout& layout, std::size_t vertex_count, std::size_t capacity);
    std::size_t bytes() const { return bytes_; }

private:
    friend class GlCast;
    GlObject layout_, values_;
    std::size_t vertex_count_, anchor_count_, bytes_ = 0;
};

class GlHeights;

class GlCast {
public:
    // Uploads the fields of every asset once. Throws Unsupported where they are too many for this OpenGL.
    explicit GlCast(std::span<const GlCaster> casters);

    // Uploads the poses of a frame, of the casters that the constructor had. Allocates nothing.
    void pose(std::span<const GlCaster> casters);
    // A height field hides from vertices of characters as well; null: none does. It outlives this object.
    void setHeights(const GlHeights* heights) { heights_ = heights; }
    // Times kCastQuads that a vertex of a character has: what casters leave visible, then what a height field does.
    std::size_t castSets() const { return heights_ ? 2 : 1; }
    // Casts on the receivers of a buffer: vertices of characters, or with `ground` points of the ground, which have one
    // set. Whatever storage blocks were bound are others afterwards.
    void cast(const GlObject& receivers, const GlObject& casts, std::size_t count, bool ground = false);
    // Casts on all vertices of `characters` at their anchors.
    void castAtAnchors(const GlObject& receivers, const GlObject& casts, const GlCastAnchors& anchors,
                       std::size_t characters);
    bool empty() const { return parts_ == 0 && spheres_ == 0; }  // nobody casts
    // Call this after the last cast of a frame.
    void release() { posed_.release(); }

    std::size_t bytes() const { return bytes_ + posed_.bytes(); }  // size in GL memory

private:
    std::vector<std::uint32_t> first_word_;  // first word of each caster's fields
    std::size_t parts_ = 0, spheres_ = 0, bytes_ = 0;
    GlObject fields_, tables_;
    struct Program {
        GlObject program;
        GLint receiver_count = -1, cast_quads = -1, vertex_count = -1, anchor_count = -1;
    };
    std::map<CastPass, Program> programs_;  // compiled when they are first needed
    UploadRing posed_;
    const GlHeights* heights_ = nullptr;

    const Program& use(CastPass pass);
    void bind(const GlObject& receivers, const GlObject& casts);
    void uploadFields(std::span<const GlCaster> casters);
    void uploadTables(std::span<const GlCaster> casters);
};

}  // namespace penumbra
