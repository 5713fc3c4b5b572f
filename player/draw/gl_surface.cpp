#include "player/draw/gl_surface.h"

#include <algorithm>
#include <numeric>

#include "formats/common/errors.h"
#include "player/frame/asset_texture.h"

namespace penumbra {

namespace {

constexpr GLuint kFirstUnit = 8;  // first texture unit for pictures; painters and suns use the lower ones

bool isSrgb(TextureRole role) { return role == TextureRole::kBaseColor || role == TextureRole::kEmissive; }

GLint wrapOf(TextureWrap wrap) {
    switch (wrap) {
        case TextureWrap::kRepeat:
            return GL_REPEAT;
        case TextureWrap::kMirror:
            return GL_MIRRORED_REPEAT;
        case TextureWrap::kClamp:
            return GL_CLAMP_TO_EDGE;
    }
    return GL_REPEAT;
}

// Uploads RGBA with all its smaller levels, whose texels OpenGL averages in linear light.
GlObject makePicture(const TexturePicture& picture, bool srgb, std::uint8_t wrap) {
    std::vector<std::uint8_t> rgba(picture.rgb.size() / 3 * 4);
    for (std::size_t i = 0; i < rgba.size() / 4; ++i) {
        std::copy_n(picture.rgb.data() + 3 * i, 3, rgba.data() + 4 * i);
        rgba[4 * i + 3] = picture.alpha.empty() ? 255 : picture.alpha[i];
    }
    GLuint id = 0;
    gl::GenTextures(1, &id);
    GlObject texture(id, [](GLuint t) { gl::DeleteTextures(1, &t); });
    gl::ActiveTexture(GL_TEXTURE0 + kFirstUnit);
    gl::BindTexture(GL_TEXTURE_2D, id);
    gl::TexImage2D(GL_TEXTURE_2D, 0, srgb ? GL_SRGB8_ALPHA8 : GL_RGBA8, picture.width, picture.height, 0, GL_RGBA,
                   GL_UNSIGNED_BYTE, rgba.data());
    const TextureUse use{0, 0, wrap};
    gl::TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, wrapOf(use.wrapU()));
    gl::TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, wrapOf(use.wrapV()));
    gl::TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    gl::TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
    gl::GenerateMipmap(GL_TEXTURE_2D);
    return texture;
}

TexturePicture onePixel(std::uint8_t r, std::uint8_t g, std::uint8_t b) { return {1, 1, {r, g, b}, {}}; }

}  // namespace

SurfaceShader surfaceShaderOf(const ShadingSet* shading) {
    if (!shading || !shading->showsSurface()) return {};
    const SurfaceView& surface = *shading->asset().surface;
    const bool blends = std::ranges::any_of(surface.slots, &SlotSurface::blends);
    const SurfaceTerms& terms = shading->surfaceTerms();
    return {true, !surface.colors.empty(), !surface.turns.empty(), blends, terms.slopes, terms.steps};
}

SurfaceUniforms surfaceUniforms(const GlObject& program) {
    const auto at = [&](const char* name) { return gl::GetUniformLocation(program.id(), name); };
    return {at("surface_replaced"),
            at("surface_base"),
            at("surface_emissive"),
            at("surface_f0"),
            at("surface_numbers"),
            at("surface_alpha"),
            at("surface_steps"),
            at("surface_step_roughness"),
            at("surface_uv_set"),
            at("surface_colors"),
            at("surface_turns"),
            {at("base_picture"), at("metal_picture"), at("normal_picture"), at("emissive_picture"),
             at("occlusion_picture")}};
}

GlSurface::GlSurface(const AssetView& asset) : asset_(&asset) {
    drawn_ = asset.mesh.positions.size() + asset.surface->seam_vertices.size();
    sortTriangles();
    uploadPlaces();
    uploadPictures();
    checkGl("uploading the pictures of a surface");
}

std::span<const std::uint32_t> GlSurface::seamVertices() const { return asset_->surface->seam_vertices; }

void GlSurface::sortTriangles() {
    const AssetView& asset = *asset_;
    const MeshView& mesh = asset.mesh;
    const std::vector<std::uint32_t> drawn = asset.surface->drawnTriangles(mesh.triangles, mesh.positions.size());
    const auto slotOf = [&](std::size_t corner) {
        return mesh.slot_of_vertex.empty() ? 0 : std::size_t(mesh.slot_of_vertex[mesh.triangles[corner]]);
    };
    const std::size_t slots = asset.surface->slots.size();
    first_of_slot_.assign(slots + 1, 0);
    for (std::size_t corner = 0; corner < drawn.size(); corner += 3) first_of_slot_[slotOf(corner) + 1] += 3;
    for (std::size_t s = 0; s < slots; ++s) first_of_slot_[s + 1] += first_of_slot_[s];
    std::vector<std::size_t> next = first_of_slot_;
    triangles_.resize(drawn.size());
    for (std::size_t corner = 0; corner < drawn.size(); corner += 3) {
        std::size_t& to = next[slotOf(corner)];
        std::copy_n(drawn.begin() + std::ptrdiff_t(corner), 3, triangles_.begin() + std::ptrdiff_t(to));
        to += 3;
    }
}

void GlSurface::uploadPlaces() {
    const SurfaceView& surface = *asset_->surface;
    std::vector<std::array<Uv, kMaxUvSets>> places(drawn_);
    for (std::size_t set = 0; set < surface.uv_sets; ++set) {
        const std::span<const Uv> uv = surface.uvOf(set);
        for (std::size_t v = 0; v < drawn_; ++v) places[v][set] = uv[v];
    }
    places_ = makeBuffer(GL_ARRAY_BUFFER, std::span<const std::array<Uv, kMaxUvSets>>(places));
    std::vector<std::uint32_t> sources(drawn_ - surface.seam_vertices.size());
    std::iota(sources.begin(), sources.end(), 0u);
    sources.insert(sources.end(), surface.seam_vertices.begin(), surface.seam_vertices.end());
    sources_ = makeBuffer(GL_ARRAY_BUFFER, std::span<const std::uint32_t>(sources));
    colors_ = makeTextureBuffer(GL_RGBA16, surface.colors);
    turns_ = makeTextureBuffer(GL_RGBA8I, surface.turns);
    bytes_ +=
        drawn_ * (sizeof places[0] + sizeof sources[0]) + surface.colors.size_bytes() + surface.turns.size_bytes();
}

void GlSurface::uploadPictures() {
    const AssetView& asset = *asset_;
    GLint largest = 0;
    gl::GetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
    none_ = {makePicture(onePixel(255, 255, 255), false, 0), makePicture(onePixel(128, 128, 255), false, 0)};
    std::map<std::uint16_t, TexturePicture> opened;
    for (const SlotSurface& slot : asset.surface->slots)
        for (std::size_t role = 0; role < kTextureRoles; ++role) {
            const TextureUse& use = slot.uses[role];
            if (!use.any()) continue;
            GlObject& made = pictures_[{use.texture, isSrgb(TextureRole(role)), use.wrap}];
            if (made.id()) continue;
            TexturePicture& picture = opened[use.texture];
            if (picture.width == 0) picture = openTexture(asset, asset.surface->textures[use.texture]);
            if (std::max(picture.width, picture.height) > largest)
                throw Unsupported(asset.name + ": " + std::string(asset.surface->textures[use.texture].name) +
                                  " has more than " + std::to_string(largest) + " pixels on a side, for this OpenGL");
            made = makePicture(picture, isSrgb(TextureRole(role)), use.wrap);
            bytes_ += picture.rgb.size() / 3 * 4 * 4 / 3;
        }
}

GLuint GlSurface::pictureOf(const TextureUse& use, TextureRole role) const {
    if (!use.any()) return none_[role == TextureRole::kNormal ? 1 : 0].id();
    return pictures_.at({use.texture, isSrgb(role), use.wrap}).id();
}

void GlSurface::bind(const SurfaceUniforms& at, std::size_t slot) const {
    const SlotSurface& look = asset_->surface->slots[slot];
    const SurfaceMaterials& materials = look.materials;
    gl::Uniform3fv(at.base, 1, &look.base.x);
    gl::Uniform3fv(at.emissive, 1, &look.emissive.x);
    const float f0[4] = {look.f0.x, look.f0.y, look.f0.z, look.f90};
    gl::Uniform4fv(at.f0, 1, f0);
    const bool bumpy = look.use(TextureRole::kNormal).any();
    const float numbers[4] = {look.metallic, look.roughness, bumpy ? look.normal_scale : 0, look.occlusion_strength};
    gl::Uniform4fv(at.numbers, 1, numbers);
    const float alpha[4] = {look.alpha, look.alpha_cutoff, float(slot), 0};
    gl::Uniform4fv(at.alpha, 1, alpha);
    gl::Uniform1i(at.steps, GLint(materials.steps));
    gl::Uniform3fv(at.step_roughness, 1, materials.roughness.data());
    for (std::size_t role = 0; role < kTextureRoles; ++role) {
        gl::ActiveTexture(GL_TEXTURE0 + kFirstUnit + GLuint(role));
        gl::BindTexture(GL_TEXTURE_2D, pictureOf(look.uses[role], TextureRole(role)));
        gl::Uniform1i(at.textures[role], GLint(kFirstUnit + role));
        gl::Uniform1i(at.uv_set + GLint(role), look.uses[role].uv_set);
    }
    GLuint unit = kFirstUnit + GLuint(kTextureRoles);
    for (const auto& [uniform, buffer] : {std::pair(at.colors, &colors_), std::pair(at.turns, &turns_)}) {
        if (uniform >= 0) {
            gl::ActiveTexture(GL_TEXTURE0 + unit);
            gl::BindTexture(GL_TEXTURE_BUFFER, buffer->texture.id());
            gl::Uniform1i(uniform, GLint(unit));
        }
        ++unit;
    }
    gl::ActiveTexture(GL_TEXTURE0);
}

void GlSurface::draw(const SurfaceUniforms& at, const ShadingSet* shading, std::size_t instances) const {
    for (std::size_t slot = 0; slot + 1 < first_of_slot_.size(); ++slot) {
        const std::size_t first = first_of_slot_[slot], count = first_of_slot_[slot + 1] - first;
        if (count == 0) continue;
        bind(at, slot);
        if (shading) gl::Uniform1i(at.replaced, shading->showsSurface(slot) ? 0 : 1);
        const auto* offset = reinterpret_cast<const void*>(first * sizeof(std::uint32_t));
        gl::DrawElementsInstanced(GL_TRIANGLES, GLsizei(count), GL_UNSIGNED_INT, offset, GLsizei(instances));
    }
}

}  // namespace penumbra
