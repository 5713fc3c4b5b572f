#include "bake/reference/picture_surface.h"

#include <algorithm>
#include <cmath>

#include "formats/common/errors.h"
#include "formats/common/parallel_for.h"
#include "formats/image/image_file.h"
#include "sh/brdf/principled.h"

namespace penumbra {

namespace {

constexpr std::size_t kLobeSteps = 32;  // steps of the roughness

std::int64_t repeated(std::int64_t i, std::int64_t size, TextureWrap wrap) {
    if (wrap == TextureWrap::kClamp) return std::clamp<std::int64_t>(i, 0, size - 1);
    const std::int64_t period = wrap == TextureWrap::kMirror ? 2 * size : size;
    const std::int64_t at = ((i % period) + period) % period;
    return at < size ? at : period - 1 - at;
}

std::array<double, 4> texelOf(const TexturePicture& picture, std::size_t texel, bool srgb) {
    static const std::array<double, 256> linear = [] {
        std::array<double, 256> table;
        for (std::size_t i = 0; i < 256; ++i) table[i] = double(linearFromSrgb(float(i) / 255));
        return table;
    }();
    const std::uint8_t* rgb = picture.rgb.data() + 3 * texel;
    const double alpha = picture.alpha.empty() ? 1 : picture.alpha[texel] / 255.0;
    if (srgb) return {linear[rgb[0]], linear[rgb[1]], linear[rgb[2]], alpha};
    return {rgb[0] / 255.0, rgb[1] / 255.0, rgb[2] / 255.0, alpha};
}

// Interpolates the four texels around a place.
std::array<double, 4> bilinear(const TexturePicture& picture, const TextureUse& use, bool srgb, double u, double v) {
    const double x = u * picture.width - 0.5, y = v * picture.height - 0.5;
    const auto column = std::int64_t(std::floor(x)), row = std::int64_t(std::floor(y));
    const double s = x - double(column), t = y - double(row);
    std::array<double, 4> sum{};
    for (const auto& [i, k, weight] : {std::tuple(0, 0, (1 - s) * (1 - t)), std::tuple(1, 0, s * (1 - t)),
                                       std::tuple(0, 1, (1 - s) * t), std::tuple(1, 1, s * t)}) {
        const std::int64_t at_x = repeated(column + i, picture.width, use.wrapU()),
                           at_y = repeated(row + k, picture.height, use.wrapV());
        const std::array<double, 4> texel = texelOf(picture, std::size_t(at_y * picture.width + at_x), srgb);
        for (std::size_t c = 0; c < 4; ++c) sum[c] += weight * texel[c];
    }
    return sum;
}

TexturePicture openPicture(const SurfaceTexture& texture, const std::filesystem::path& folder,
                           const std::string& name) {
    const std::string where = name + ": " + texture.name;
    if (!texture.bytes.empty()) return decodeTexture(texture.bytes, where);
    try {
        return readTexture(folder / texture.file, where);
    } catch (const IoError& error) {
        throw IoError(where + ": " + error.what());
    }
}

}  // namespace

PictureSurface::PictureSurface(MeshSurface surface, std::vector<std::uint16_t> slot_of_triangle,
                               const std::filesystem::path& folder, const std::string& name)
    : surface_(std::move(surface)),
      slot_of_triangle_(std::move(slot_of_triangle)),
      plain_(surface_.slots.size(), false) {
    for (const SurfaceTexture& texture : surface_.textures) pictures_.push_back(openPicture(texture, folder, name));
}

std::array<double, 4> PictureSurface::look(const SurfacePlace& at, TextureRole role) const {
    const TextureUse& use = slotAt(at).use(role);
    if (!use.any()) return {1, 1, 1, 1};
    double u = 0, v = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const Uv& uv = surface_.uv[use.uv_set][3 * at.triangle + k];
        u += at.weight[k] * double(uv[0]);
        v += at.weight[k] * double(uv[1]);
    }
    const bool srgb = role == TextureRole::kBaseColor || role == TextureRole::kEmissive;
    return bilinear(pictures_[use.texture], use, srgb, u, v);
}

std::array<double, 4> PictureSurface::colorOf(const SurfacePlace& at) const {
    if (surface_.colors.empty()) return {1, 1, 1, 1};
    std::array<double, 4> out{};
    for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t c = 0; c < 4; ++c) out[c] += at.weight[k] * surface_.colors[3 * at.triangle + k][c] / 65535.0;
    return out;
}

bool PictureSurface::isHole(const SurfacePlace& at, double chance) const {
    const SlotSurface& slot = slotAt(at);
    if (slot.alpha_cutoff == 0 || !has(at.triangle)) return false;
    const double alpha = double(slot.alpha) * look(at, TextureRole::kBaseColor)[3] * colorOf(at)[3];
    return slot.blends() ? alpha <= chance : alpha < double(slot.alpha_cutoff);
}

PointMaterial PictureSurface::materialAt(const SurfacePlace& at) const {
    const SlotSurface& slot = slotAt(at);
    const auto color = [&](Vec3 factor, TextureRole role) {
        const std::array<double, 4> texel = look(at, role);
        return toDouble(factor) * Vec3d{texel[0], texel[1], texel[2]};
    };
    PointMaterial out;
    const std::array<double, 4> tint = colorOf(at);
    const Vec3d base = color(slot.base, TextureRole::kBaseColor) * Vec3d{tint[0], tint[1], tint[2]};
    const std::array<double, 4> metal = look(at, TextureRole::kMetallicRoughness);
    const double metallic = double(slot.metallic) * metal[2];
    out.roughness = std::max(double(slot.roughness) * metal[1], kMinRoughness);
    out.diffuse = base * (1 - metallic);
    out.f0 = toDouble(slot.f0) * (1 - metallic) + base * metallic;
    const double f90 = double(slot.f90) * (1 - metallic) + metallic;
    out.f90 = {f90, f90, f90};
    out.emissive = color(slot.emissive, TextureRole::kEmissive);
    const double strength = double(slot.occlusion_strength);
    out.occlusion = 1 - strength + strength * look(at, TextureRole::kOcclusion)[0];
    out.dielectric.name = nameOf(BrdfModel::kPrincipledDiffuse);
    out.dielectric.parameters = {{"f0", double(std::max({slot.f0.x, slot.f0.y, slot.f0.z}))},
                                 {"f90", double(slot.f90)}};
    if (!slot.use(TextureRole::kNormal).any()) return out;
    const std::array<double, 4> n = look(at, TextureRole::kNormal);
    const double scale = double(slot.normal_scale);
    out.picture_normal = Vec3d{scale * (2 * n[0] - 1), scale * (2 * n[1] - 1), 2 * n[2] - 1};
    return out;
}

// Turns what a picture has along tangent and bitangent from the file's to those of the texture coordinates.
Vec3d PictureSurface::turned(const SurfacePlace& at, Vec3d along) const {
    if (surface_.turns.empty()) return along;
    double cosine = 0, sine = 0, side = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const TangentTurn& turn = surface_.turns[3 * at.triangle + k];
        cosine += at.weight[k] * turn[0];
        sine += at.weight[k] * turn[1];
        side += at.weight[k] * turn[2];
    }
    const double size = std::hypot(cosine, sine), y = side < 0 ? -along.y : along.y;
    if (!(size > 0)) return {along.x, y, 0};
    return Vec3d{along.x * cosine - y * sine, along.x * sine + y * cosine, 0} * (1 / size);
}

Vec3d PictureSurface::bentNormal(const SurfacePlace& at, const std::array<Vec3d, 3>& corners, Vec3d level,
                                 Vec3d picture) const {
    const std::vector<Uv>& uv = surface_.uv[slotAt(at).use(TextureRole::kNormal).uv_set];
    const auto place = [&](std::size_t k, std::size_t axis) { return double(uv[3 * at.triangle + k][axis]); };
    const double u1 = place(1, 0) - place(0, 0), u2 = place(2, 0) - place(0, 0), v1 = place(1, 1) - place(0, 1),
                 v2 = place(2, 1) - place(0, 1), turn = u1 * v2 - u2 * v1;
    const Vec3d first = corners[1] - corners[0], second = corners[2] - corners[0];
    Vec3d tangent = (first * v2 - second * v1) * turn;
    tangent = tangent - level * dot(level, tangent);
    if (!(dot(tangent, tangent) > 0)) return level;
    tangent = normalized(tangent);
    const double up = dot(level, cross(first, second)) * turn > 0 ? -1 : 1;
    const Vec3d side = turned(at, {picture.x, picture.y, 0});
    const Vec3d bent = tangent * side.x + cross(level, tangent) * (up * side.y) + level * picture.z;
    return dot(bent, bent) > 0 ? normalized(bent) : level;
}

PointBrdfs::PointBrdfs(int threads) : lobes_(kLobeSteps) {
    parallelFor(kLobeSteps, threads, [&](std::size_t step) {
        PointMaterial material;
        material.roughness = kMinRoughness + (1 - kMinRoughness) * double(step) / double(kLobeSteps - 1);
        material.diffuse = {0.3, 0.3, 0.3};
        material.f0 = {0.3, 0.3, 0.3};
        material.f90 = {1, 1, 1};
        material.dielectric = principledDiffuse({});
        lobes_[step] = fitLobe(brdfOf(material).brdf);
    });
}

SampledBrdf PointBrdfs::brdfOf(const PointMaterial& material) const {
    const BrdfFunction diffuse = brdfFunction(material.dielectric), f0 = brdfFunction(principledF0(material.roughness)),
                       f90 = brdfFunction(principledF90(material.roughness));
    SampledBrdf out;
    out.brdf.eval = [=, k = material.diffuse, a = material.f0, b = material.f90](Vec3d wi, Vec3d wo) {
        return k * diffuse(wi, wo) + a * f0(wi, wo) + b * f90(wi, wo);
    };
    if (!(dot(material.f0, material.f0) + dot(material.f90, material.f90) > 0)) return out;
    const double at = (material.roughness - kMinRoughness) / (1 - kMinRoughness) * double(kLobeSteps - 1);
    out.lobe = lobes_[std::min(std::size_t(std::max(at, 0.0) + 0.5), kLobeSteps - 1)];
    return out;
}

}  // namespace penumbra
