#include "player/draw/sun_map_painter.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>

#include "formats/common/errors.h"
#include "player/runtime/sun_map.h"
#include "player_shaders.h"

namespace penumbra {

namespace {

constexpr std::size_t kFrameFloats = 16;
constexpr int kSunBlock = 8;          // texels a side of a block
constexpr int kSunLevels = 5;         // of blocks of twice the side of those before
constexpr int kBlocksWorkGroup = 8;   // invocations a side, as sun_blocks.comp has it
constexpr GLuint kBlocksBinding = 0;  // of storage blocks, while they are made

// Blocks of texels a side, a power of two, so that every level has half the side of the one before.
int blockSide(int size) {
    return int(std::bit_ceil(unsigned(std::max((size + kSunBlock - 1) / kSunBlock, 1 << kSunLevels))));
}

// In the numbers of a sun come the blocks with what is around them, of levels 1 to kSunLevels, then the blocks alone.
int reachedFirst(int side, int level) { return (side * side - (side >> (level - 1)) * (side >> (level - 1))) / 3; }
int ownFirst(int side, int level) {
    return reachedFirst(side, kSunLevels + 1) + 4 * ((side * side - (side >> level) * (side >> level)) / 3);
}
int blocksOf(int size) { return ownFirst(blockSide(size), kSunLevels + 1); }

std::string blocksSource(bool from_texels) {
    return "#version 430 core\n#define SUN_BLOCK " + std::to_string(kSunBlock) + "\n" +
           (from_texels ? "#define SUN_FROM_TEXELS\n" : "") + kShaderSunBlocksComp;
}

std::array<float, kFrameFloats> packFrame(const SunFrame& frame) {
    std::array<float, kFrameFloats> out{};
    for (std::size_t i = 0; i < 3; ++i) std::copy_n(frame.rows[i].begin(), 4, out.begin() + std::ptrdiff_t(4 * i));
    out[12] = frame.range;
    out[13] = frame.tan_radius;
    out[14] = frame.texel;
    out[15] = float(frame.size);
    return out;
}

GlObject makeDepthLayers(int size, int layers) {
    GLint limit = 0;
    gl::GetIntegerv(GL_MAX_TEXTURE_SIZE, &limit);
    if (size > limit)
        throw Unsupported("the size of the sun's map, " + std::to_string(size) + ", is above this OpenGL's limit, " +
                          std::to_string(limit));
    GLuint id = 0;
    gl::GenTextures(1, &id);
    GlObject texture(id, [](GLuint t) { gl::DeleteTextures(1, &t); });
    gl::BindTexture(GL_TEXTURE_2D_ARRAY, id);
    gl::TexStorage3D(GL_TEXTURE_2D_ARRAY, 1, GL_DEPTH_COMPONENT32F, size, size, layers);
    gl::TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl::TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    return texture;
}

GlObject makeDepthFramebuffer() {
    GLuint id = 0;
    gl::GenFramebuffers(1, &id);
    return GlObject(id, [](GLuint f) { gl::DeleteFramebuffers(1, &f); });
}

bool isFinitePoint(Vec3 p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); }

std::string sunDefine(const char* name, float value) {
    return std::string("#define SUN_") + name + " float(" + std::to_string(value) + ")\n";
}

std::string sunDefine(const char* name, int value) {
    return std::string("#define SUN_") + name + " " + std::to_string(value) + "\n";
}

}  // namespace

std::string sunGlsl() {
    return sunDefine("MAX_SUNS", kMaxSunMaps) + sunDefine("BIAS", kSunBias) + sunDefine("SLOPE_BIAS", kSunSlopeBias) +
           sunDefine("LEAST_COSINE", kSunLeastCosine) + sunDefine("BOX", kSunBox) + sunDefine("CELLS", kSunCells) +
           sunDefine("SEARCH_CELLS", kSunSearchCells) + sunDefine("PASSES", kSunPasses) +
           sunDefine("BLOCK", kSunBlock) + sunDefine("LEVELS", kSunLevels) + kShaderSunGlsl;
}

SunUniforms sunUniforms(const GlObject& program) {
    return {gl::GetUniformLocation(program.id(), "sun_depths"), gl::GetUniformLocation(program.id(), "sun_blocks"),
            gl::GetUniformLocation(program.id(), "sun_frames"), gl::GetUniformLocation(program.id(), "sun_block_side"),
            gl::GetUniformLocation(program.id(), "sun_block_count")};
}

SunMapPainter::SunMapPainter(int suns, int size)
    : suns_(suns),
      size_(size),
      depths_(makeDepthLayers(size, suns)),
      framebuffer_(makeDepthFramebuffer()),
      program_(
          makeProgram(std::string("#version 430 core\n") + kShaderSunMapVert, "#version 430 core\nvoid main() {}\n")),
      texel_blocks_(makeComputeProgram(blocksSource(true))),
      block_blocks_(makeComputeProgram(blocksSource(false))),
      blocks_(makeTextureStorage(GL_RG32F, std::size_t(suns * blocksOf(size)) * 2 * sizeof(float))),
      frame_at_(gl::GetUniformLocation(program_.id(), "sun_frame")),
      frames_(std::size_t(suns) * kFrameFloats) {
    assert(suns >= 1 && suns <= kMaxSunMaps && size >= kSmallestSunMap && size <= kLargestSunMap);
    checkGl("making the sun's map");
}

void SunMapPainter::setCasters(std::span<const SunCaster> casters) {
    meshes_.clear();
    for (const SunCaster& caster : casters) {
        Mesh mesh{makeVertexArray(), {}, {}, caster.positions.size(), caster.triangles.size()};
        gl::BindVertexArray(mesh.vertex_array.id());
        mesh.positions = makeBuffer(GL_ARRAY_BUFFER, std::as_bytes(caster.positions));
        gl::VertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, 0, nullptr);
        gl::EnableVertexAttribArray(0);
        mesh.triangles = makeBuffer(GL_ELEMENT_ARRAY_BUFFER, caster.triangles);
        mesh.drawn = GLsizei(mesh.indices);
        meshes_.push_back(std::move(mesh));
    }
    checkGl("uploading the sun's casters");
}

void SunMapPainter::upload(Mesh& mesh, const SunCaster& caster) {
    assert(caster.positions.size() == mesh.vertices && caster.triangles.size() == mesh.indices);
    gl::BindVertexArray(mesh.vertex_array.id());
    gl::BindBuffer(GL_ARRAY_BUFFER, mesh.positions.id());
    gl::BufferSubData(GL_ARRAY_BUFFER, 0, GLsizeiptr(caster.positions.size_bytes()), caster.positions.data());
    const bool finite = std::all_of(caster.positions.begin(), caster.positions.end(), isFinitePoint);
    if (finite && !mesh.skipping) return;

    // GL does not say what becomes of a triangle with a vertex that is not finite.
    finite_triangles_.clear();
    for (std::size_t t = 0; t + 2 < caster.triangles.size(); t += 3) {
        const auto corners = caster.triangles.subspan(t, 3);
        if (std::all_of(corners.begin(), corners.end(), [&](auto v) { return isFinitePoint(caster.positions[v]); }))
            finite_triangles_.insert(finite_triangles_.end(), corners.begin(), corners.end());
    }
    gl::BufferSubData(GL_ELEMENT_ARRAY_BUFFER, 0, GLsizeiptr(finite_triangles_.size() * sizeof(std::uint32_t)),
                      finite_triangles_.data());
    mesh.drawn = GLsizei(finite_triangles_.size());
    mesh.skipping = !finite;
}

void SunMapPainter::begin(int sun, const SunFrame& frame) {
    assert(sun >= 0 && sun < suns_ && (frame.size == 0 || frame.size == size_));
    const std::array<float, kFrameFloats> packed = packFrame(frame);
    std::copy(packed.begin(), packed.end(), frames_.begin() + std::ptrdiff_t(std::size_t(sun) * kFrameFloats));
    gl::BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    gl::FramebufferTextureLayer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, depths_.id(), 0, sun);
    gl::Viewport(0, 0, size_, size_);
    gl::Enable(GL_DEPTH_TEST);
    gl::Disable(GL_CULL_FACE);  // both sides cast
    gl::Clear(GL_DEPTH_BUFFER_BIT);
    gl::UseProgram(program_.id());
    gl::Uniform4fv(frame_at_, 4, packed.data());
}

void SunMapPainter::draw(std::span<const SunFrame> frames, std::span<const SunCaster> casters) {
    assert(casters.size() == meshes_.size());
    for (std::size_t i = 0; i < meshes_.size(); ++i) upload(meshes_[i], casters[i]);
    for (std::size_t sun = 0; sun < frames.size(); ++sun) {
        begin(int(sun), frames[sun]);
        if (frames[sun].size > 0) drawMeshes();
        finish(int(sun));
    }
    checkGl("drawing the sun's map");
}

void SunMapPainter::drawMeshes() const {
    for (const Mesh& mesh : meshes_) {
        gl::BindVertexArray(mesh.vertex_array.id());
        gl::DrawElements(GL_TRIANGLES, mesh.drawn, GL_UNSIGNED_INT, nullptr);
    }
}

void SunMapPainter::finish(int sun) const {
    const int side = blockSide(size_), first = sun * blocksOf(size_);
    gl::ActiveTexture(GL_TEXTURE0);
    gl::BindTexture(GL_TEXTURE_2D_ARRAY, depths_.id());
    gl::BindBufferBase(GL_SHADER_STORAGE_BUFFER, kBlocksBinding, blocks_.buffer.id());
    gl::UseProgram(texel_blocks_.id());
    gl::Uniform1i(gl::GetUniformLocation(texel_blocks_.id(), "sun"), sun);
    reduce(texel_blocks_, {0, size_}, {first + ownFirst(side, 0), side}, 0);
    gl::UseProgram(block_blocks_.id());
    for (int level = 1; level <= kSunLevels; ++level)
        reduce(block_blocks_, {first + ownFirst(side, level - 1), side >> (level - 1)},
               {first + ownFirst(side, level), side >> level}, first + reachedFirst(side, level));
}

void SunMapPainter::reduce(const GlObject& program, Square from, Square to, int reached_first) {
    gl::Uniform1i(gl::GetUniformLocation(program.id(), "read_first"), from.first);
    gl::Uniform1i(gl::GetUniformLocation(program.id(), "read_side"), from.side);
    gl::Uniform1i(gl::GetUniformLocation(program.id(), "own_first"), to.first);
    gl::Uniform1i(gl::GetUniformLocation(program.id(), "reached_first"), reached_first);
    gl::Uniform1i(gl::GetUniformLocation(program.id(), "write_side"), to.side);
    const auto groups = GLuint((to.side + kBlocksWorkGroup - 1) / kBlocksWorkGroup);
    gl::DispatchCompute(groups, groups, 1);
    gl::MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT);
}

void SunMapPainter::bind(const SunUniforms& at, GLuint unit) const {
    gl::ActiveTexture(GL_TEXTURE0 + unit);
    gl::BindTexture(GL_TEXTURE_2D_ARRAY, depths_.id());
    gl::Uniform1i(at.depths, GLint(unit));
    gl::ActiveTexture(GL_TEXTURE0 + unit + 1);
    gl::BindTexture(GL_TEXTURE_BUFFER, blocks_.texture.id());
    gl::Uniform1i(at.blocks, GLint(unit) + 1);
    gl::Uniform1i(at.block_side, blockSide(size_));
    gl::Uniform1i(at.block_count, blocksOf(size_));
    gl::Uniform4fv(at.frames, GLsizei(frames_.size() / 4), frames_.data());
    gl::ActiveTexture(GL_TEXTURE0);
}

}  // namespace penumbra
