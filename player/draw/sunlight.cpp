#include "player/draw/sunlight.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

namespace penumbra {

namespace {

constexpr GLuint kLobeUnit = 1, kMapUnit = 2, kSkyUnit = 4;  // 0 is the painters' own; maps take two
constexpr int kFirstMaps = 3;                                // the painter makes more when a light has more suns

}  // namespace

SunlightUniforms sunlightUniforms(const GlObject& program) {
    const auto at = [&](const char* name) { return gl::GetUniformLocation(program.id(), name); };
    return {at("scene_from_model"), at("scene_eye"),        at("lobes"),         at("sun_count"),
            at("sun_direction"),    at("sun_irradiance"),   at("sun_cosine"),    at("sky"),
            at("sky_size"),         at("light_from_scene"), sunUniforms(program)};
}

Sunlight::Sunlight(const LobeTable& lobes, int map_size) : lobes_(&lobes), maps_(kFirstMaps, map_size) {}

void Sunlight::reflect(const SkyPicture& sky) {
    sky_ = makeTextureBuffer(GL_RGBA16F, std::as_bytes(std::span(sky.texels)));
    sky_width_ = sky.width;
    sky_height_ = sky.height;
}

void Sunlight::updateLobes() {
    const std::span<const BrdfLobe> lobes = lobes_->lobes();
    if (lobe_texels_.texture.id() && std::ranges::equal(uploaded_, lobes)) return;
    std::vector<std::array<float, 4>> texels;
    for (const BrdfLobe& lobe : lobes) {
        texels.push_back(lobe.parameters);
        texels.push_back({lobe.color.x, lobe.color.y, lobe.color.z, float(lobe.model)});
    }
    const std::span<const std::array<float, 4>> all(texels);
    if (!lobe_texels_.texture.id() || lobes.size() > room_) {
        lobe_texels_ = makeTextureBuffer(GL_RGBA32F, all);
        room_ = lobes.size();
    } else {
        gl::BindBuffer(GL_TEXTURE_BUFFER, lobe_texels_.buffer.id());
        gl::BufferSubData(GL_TEXTURE_BUFFER, 0, GLsizeiptr(all.size_bytes()), all.data());
    }
    uploaded_.assign(lobes.begin(), lobes.end());
}

void Sunlight::shine(std::span<const Sun> suns, const SunCasters& casters) {
    assert(suns.size() <= kMaxSuns);
    std::vector<std::size_t> sizes;
    const auto count = [&](const SunCaster& caster) {
        sizes.push_back(caster.positions.size());
        sizes.push_back(caster.triangles.size());
    };
    std::ranges::for_each(casters.members, count);
    count(casters.ground);
    if (sizes != sizes_) maps_.setCasters(casters);
    sizes_ = std::move(sizes);
    suns_.assign(suns.begin(), suns.end());
    nests_.resize(suns.size());
    for (std::size_t s = 0; s < suns.size(); ++s)
        fitSunNest(casters, suns[s].direction, suns[s].radius, maps_.size(), nests_[s]);
    maps_.draw(nests_, casters);
    updateLobes();
}

void Sunlight::bind(const SunlightUniforms& at, const FrameView& view) const {
    const auto& m = view.scene_from_model.m;
    std::array<float, 16> columns{};
    for (std::size_t row = 0; row < 3; ++row)
        for (std::size_t column = 0; column < 4; ++column) columns[4 * column + row] = m[4 * row + column];
    columns[15] = 1;
    gl::UniformMatrix4fv(at.scene_from_model, 1, GL_FALSE, columns.data());
    const Vec3 eye = view.scene_from_model.point(view.eye);
    gl::Uniform3f(at.eye, eye.x, eye.y, eye.z);

    std::array<float, 3 * kMaxSuns> direction{}, irradiance{};
    std::array<float, kMaxSuns> cosine{};
    for (std::size_t s = 0; s < suns_.size(); ++s) {
        cosine[s] = std::cos(suns_[s].radius);
        for (int c = 0; c < 3; ++c) {
            direction[3 * s + std::size_t(c)] = suns_[s].direction[c];
            irradiance[3 * s + std::size_t(c)] = suns_[s].irradiance[c];
        }
    }
    gl::Uniform1i(at.count, GLint(suns_.size()));
    gl::Uniform3fv(at.direction, kMaxSuns, direction.data());
    gl::Uniform3fv(at.irradiance, kMaxSuns, irradiance.data());
    gl::Uniform1fv(at.cosine, kMaxSuns, cosine.data());
    gl::UniformMatrix3fv(at.light_from_scene, 1, GL_FALSE, rotation_.m.data());  // columns: the transposed
    gl::Uniform2i(at.sky_size, sky_width_, sky_height_);

    gl::ActiveTexture(GL_TEXTURE0 + kLobeUnit);
    gl::BindTexture(GL_TEXTURE_BUFFER, lobe_texels_.texture.id());
    gl::Uniform1i(at.lobes, GLint(kLobeUnit));
    gl::ActiveTexture(GL_TEXTURE0 + kSkyUnit);
    gl::BindTexture(GL_TEXTURE_BUFFER, sky_.texture.id());
    gl::Uniform1i(at.sky, GLint(kSkyUnit));
    gl::ActiveTexture(GL_TEXTURE0);
    maps_.bind(at.maps, kMapUnit);
}

}  // namespace penumbra
