#include "player/draw/sun_map_painter.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>

#include "formats/common/errors.h"
#include "player_shaders.h"
#include "runtime/sun/sun_map.h"

namespace penumbra {

namespace {

constexpr int kSunBlock = 8;          // texels a side of a block
constexpr int kSunLevels = 5;         // levels of blocks, each with twice the side of the one before
constexpr int kBlocksWorkGroup = 8;   // invocations a side, as sun_blocks.comp has it
constexpr GLuint kBlocksBinding = 0;  // binding of storage blocks while they are made
constexpr int kFramesBinding = 0;     // binding of the uniform block
constexpr int kMaxMaps = kMaxSunMaps * kMaxNestedMaps;

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
    gl::TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    gl::TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
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
    return sunDefine("MAX_SUNS", kMaxSunMaps) + sunDefine("MAX_MAPS", kMaxMaps) +
           sunDefine("FRAMES_BINDING", kFramesBinding) + sunDefine("BIAS", kSunBias) +
           sunDefine("SLOPE_BIAS", kSunSlopeBias) + sunDefine("MIN_COSINE", kSunMinCosine) + sunDefine("BOX", kSunBox) +
           sunDefine("CELLS", kSunCells) + sunDefine("SEARCH_CELLS", kSunSearchCells) +
           sunDefine("PASSES", kSunPasses) + sunDefine("BLOCK", kSunBlock) + sunDefine("LEVELS", kSunLevels) +
           kShaderSunGlsl;
}

SunUniforms sunUniforms(const GlObject& program) {
    const auto at = [&](const char* name) { return gl::GetUniformLocation(program.id(), name); };
    return {at("sun_depths"), at("sun_blocks"), at("sun_maps"), at("sun_block_side"), at("sun_block_count")};
}

SunMapPainter::SunMapPainter(int suns, int size)
    : suns_(suns),
      size_(size),
      framebuffer_(makeDepthFramebuffer()),
      program_(
          makeProgram(std::string("#version 430 core\n") + kShaderSunMapVert, "#version 430 core\nvoid main() {}\n")),
      texel_blocks_(makeComputeProgram(blocksSource(true))),
      block_blocks_(makeComputeProgram(blocksSource(false))),
      frame_at_(gl::GetUniformLocation(program_.id(), "sun_frame")) {
    makeLayers(1);  // refuses what is above this OpenGL's limit
    const std::vector<float> none(kMaxMaps * kFrameFloats);
    frames_block_ = makeBuffer(GL_UNIFORM_BUFFER, std::span<const float>(none));
    assert(suns >= 1 && suns <= kMaxSunMaps && size >= kSmallestSunMap && size <= kLargestSunMap);
    checkGl("making the sun's map");
}

std::array<float, SunMapPainter::kFrameFloats> SunMapPainter::packFrame(const NestedSunMap& map) {
    const SunFrame& frame = map.frame;
    std::array<float, kFrameFloats> out{};
    for (std::size_t i = 0; i < 3; ++i) std::copy_n(frame.rows[i].begin(), 4, out.begin() + std::ptrdiff_t(4 * i));
    out[12] = frame.range;
    out[13] = frame.tan_radius;
    out[14] = frame.texel;
    out[15] = float(frame.size);
    for (int i = 0; i < 3; ++i) out[std::size_t(16 + i)] = frame.origin[i];
    out[19] = map.border;
    return out;
}

// The layers before are lost.
void SunMapPainter::makeLayers(std::size_t count) {
    depths_ = {};
    depths_ = makeDepthLayers(size_, int(count));
    blocks_ = makeTextureStorage(GL_RG32F, count * std::size_t(blocksOf(size_)) * 2 * sizeof(float));
    layers_.clear();
    layers_.resize(count);
    frames_.resize(count * kFrameFloats);
}

SunMapPainter::Mesh SunMapPainter::makeMesh(const SunCaster& caster, ClosedSurfaces surfaces) {
    Mesh mesh{makeVertexArray(), {}, {}, caster.positions.size(), std::move(surfaces)};
    gl::BindVertexArray(mesh.vertex_array.id());
    mesh.positions = makeBuffer(GL_ARRAY_BUFFER, std::as_bytes(caster.positions));
    gl::VertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, 0, nullptr);
    gl::EnableVertexAttribArray(0);
    mesh.triangles = makeBuffer(GL_ELEMENT_ARRAY_BUFFER, std::span<const std::uint32_t>(mesh.surfaces.triangles));
    mesh.drawn = GLsizei(mesh.surfaces.triangles.size());
    return mesh;
}

void SunMapPainter::setCasters(const SunCasters& casters) {
    meshes_.clear();
    for (const SunCaster& caster : casters.members)
        meshes_.push_back(makeMesh(caster, findClosedSurfaces(caster.triangles)));
    const std::span<const std::uint32_t> ground = casters.ground.triangles;  // open: both of its sides are drawn
    ground_ = makeMesh(casters.ground, {{ground.begin(), ground.end()}, {}});
    ground_version_ = 0;
    for (Layer& layer : layers_) layer.ground_version = 0;
    checkGl("uploading the sun's casters");
}

void SunMapPainter::upload(Mesh& mesh, const SunCaster& caster) {
    const std::span<const std::uint32_t> triangles(mesh.surfaces.triangles);
    assert(caster.positions.size() == mesh.vertices && caster.triangles.size() == triangles.size());
    gl::BindVertexArray(mesh.vertex_array.id());
    gl::BindBuffer(GL_ELEMENT_ARRAY_BUFFER, mesh.triangles.id());
    gl::BindBuffer(GL_ARRAY_BUFFER, mesh.positions.id());
    gl::BufferSubData(GL_ARRAY_BUFFER, 0, GLsizeiptr(caster.positions.size_bytes()), caster.positions.data());
    const bool finite = std::all_of(caster.positions.begin(), caster.positions.end(), isFinitePoint);
    mesh.outward = finite && allOutward(mesh.surfaces, caster.positions) ? GLsizei(mesh.surfaces.closedIndices()) : 0;
    if (finite && !mesh.skipping) return;

    // GL does not say what becomes of a triangle with a vertex that is not finite.
    finite_triangles_.clear();
    for (std::size_t t = 0; t + 2 < triangles.size(); t += 3) {
        const auto corners = triangles.subspan(t, 3);
        if (std::all_of(corners.begin(), corners.end(), [&](auto v) { return isFinitePoint(caster.positions[v]); }))
            finite_triangles_.insert(finite_triangles_.end(), corners.begin(), corners.end());
    }
    gl::BufferSubData(GL_ELEMENT_ARRAY_BUFFER, 0, GLsizeiptr(finite_triangles_.size() * sizeof(std::uint32_t)),
                      finite_triangles_.data());
    mesh.drawn = GLsizei(finite_triangles_.size());
    mesh.skipping = !finite;
}

void SunMapPainter::uploadGround(const SunCasters& casters) {
    if (casters.ground_version != 0 && casters.ground_version == ground_version_) return;
    upload(ground_, casters.ground);
    ground_version_ = casters.ground_version;
}

void SunMapPainter::draw(std::span<const SunNest> nests, const SunCasters& casters) {
    assert(casters.members.size() == meshes_.size() && nests.size() <= std::size_t(suns_));
    std::size_t count = 0, layer = 0;
    for (const SunNest& nest : nests) count += nest.maps.size();
    if (count > layers_.size()) makeLayers(count);
    for (std::size_t i = 0; i < meshes_.size(); ++i) upload(meshes_[i], casters.members[i]);
    uploadGround(casters);
    for (std::size_t sun = 0; sun < nests.size(); ++sun) {
        maps_[2 * sun] = GLint(layer);
        for (const NestedSunMap& map : nests[sun].maps) drawLayer(layer++, map, casters.ground_version);
        maps_[2 * sun + 1] = GLint(layer);
    }
    gl::BindBuffer(GL_UNIFORM_BUFFER, frames_block_.id());
    gl::BufferSubData(GL_UNIFORM_BUFFER, 0, GLsizeiptr(layer * kFrameFloats * sizeof(float)), frames_.data());
    checkGl("drawing the sun's map");
}

void SunMapPainter::drawLayer(std::size_t at, const NestedSunMap& map, std::uint64_t ground_version) {
    assert(map.frame.size == size_);
    Layer& layer = layers_[at];
    const std::array<float, kFrameFloats> frame = packFrame(map);
    if (!map.isGroundAlone()) ground_version = 0;
    if (ground_version != 0 && layer.ground_version == ground_version && layer.frame == frame) return;
    layer.ground_version = ground_version;
    layer.frame = frame;
    std::ranges::copy(frame, frames_.begin() + std::ptrdiff_t(at * kFrameFloats));
    begin(at);
    for (const std::uint32_t m : map.members) drawMember(meshes_[m]);
    if (!ground_.surfaces.triangles.empty()) drawGround(layer, map);
    finish(at);
}

// Both sides cast. Of a closed surface the front is always nearer to the sun, so that its backs, half of the work of
// software GL, are left out.
void SunMapPainter::drawMember(const Mesh& mesh) {
    gl::BindVertexArray(mesh.vertex_array.id());
    if (mesh.outward > 0) {
        gl::Enable(GL_CULL_FACE);
        gl::DrawElements(GL_TRIANGLES, mesh.outward, GL_UNSIGNED_INT, nullptr);
        gl::Disable(GL_CULL_FACE);
    }
    if (mesh.outward < mesh.drawn)
        gl::DrawElements(GL_TRIANGLES, mesh.drawn - mesh.outward, GL_UNSIGNED_INT,
                         reinterpret_cast<const void*>(sizeof(std::uint32_t) * std::size_t(mesh.outward)));
}

void SunMapPainter::drawGround(Layer& layer, const NestedSunMap& map) const {
    gl::BindVertexArray(ground_.vertex_array.id());
    if (map.whole_ground) {
        gl::BindBuffer(GL_ELEMENT_ARRAY_BUFFER, ground_.triangles.id());
        gl::DrawElements(GL_TRIANGLES, ground_.drawn, GL_UNSIGNED_INT, nullptr);
        return;
    }
    const std::span<const std::uint32_t> triangles(map.ground);
    if (triangles.size() > layer.ground_room) {
        layer.ground_room = triangles.size() + triangles.size() / 2;
        std::vector<std::uint32_t> room(triangles.begin(), triangles.end());
        room.resize(layer.ground_room);
        layer.ground = makeBuffer(GL_ELEMENT_ARRAY_BUFFER, std::span<const std::uint32_t>(room));
    } else if (!triangles.empty()) {
        gl::BindBuffer(GL_ELEMENT_ARRAY_BUFFER, layer.ground.id());
        gl::BufferSubData(GL_ELEMENT_ARRAY_BUFFER, 0, GLsizeiptr(triangles.size_bytes()), triangles.data());
    }
    if (!triangles.empty()) gl::DrawElements(GL_TRIANGLES, GLsizei(triangles.size()), GL_UNSIGNED_INT, nullptr);
}

void SunMapPainter::begin(std::size_t layer) const {
    gl::BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    gl::FramebufferTextureLayer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, depths_.id(), 0, GLint(layer));
    gl::Viewport(0, 0, size_, size_);
    gl::Enable(GL_DEPTH_TEST);
    gl::Disable(GL_CULL_FACE);
    gl::Clear(GL_DEPTH_BUFFER_BIT);
    gl::UseProgram(program_.id());
    gl::Uniform4fv(frame_at_, kFrameFloats / 4, layers_[layer].frame.data());
}

void SunMapPainter::finish(std::size_t layer) const {
    const int side = blockSide(size_), first = int(layer) * blocksOf(size_);
    gl::ActiveTexture(GL_TEXTURE0);
    gl::BindTexture(GL_TEXTURE_2D_ARRAY, depths_.id());
    gl::BindBufferBase(GL_SHADER_STORAGE_BUFFER, kBlocksBinding, blocks_.buffer.id());
    gl::UseProgram(texel_blocks_.id());
    gl::Uniform1i(gl::GetUniformLocation(texel_blocks_.id(), "layer"), int(layer));
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
    gl::Uniform2iv(at.maps, kMaxSunMaps, maps_.data());
    gl::BindBufferBase(GL_UNIFORM_BUFFER, GLuint(kFramesBinding), frames_block_.id());
    gl::ActiveTexture(GL_TEXTURE0);
}

}  // namespace penumbra
