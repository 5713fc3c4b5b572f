#include "bake/source/textured_surface.h"

#include <algorithm>
#include <cmath>

#include "formats/common/errors.h"
#include "formats/image/image_file.h"

namespace penumbra {

namespace {

std::int64_t wrapped(std::int64_t i, std::int64_t size, TextureWrap wrap) {
    if (wrap == TextureWrap::kClamp) return std::clamp<std::int64_t>(i, 0, size - 1);
    const std::int64_t period = wrap == TextureWrap::kMirror ? 2 * size : size;
    const std::int64_t at = (i % period + period) % period;
    return at < size ? at : period - 1 - at;
}

// Returns the number of a texel in the picture.
std::size_t texelIndex(const TexturedSurface& surface, std::int64_t column, std::int64_t row) {
    const TexturePicture& picture = *surface.picture;
    const MaterialColor& material = surface.part.color.material;
    const std::int64_t x = wrapped(column, picture.width, material.wrap_u);
    const std::int64_t y = wrapped(row, picture.height, material.wrap_v);
    return std::size_t(y * picture.width + x);
}

Vec3d colorOfTexel(const TexturePicture& picture, std::size_t texel) {
    static const std::array<double, 256> linear = [] {
        std::array<double, 256> table;
        for (std::size_t i = 0; i < 256; ++i) table[i] = double(linearFromSrgb(float(i) / 255));
        return table;
    }();
    const std::uint8_t* rgb = picture.rgb.data() + texel * 3;
    return {linear[rgb[0]], linear[rgb[1]], linear[rgb[2]]};
}

double alphaOfTexel(const TexturePicture& picture, std::size_t texel) {
    return picture.alpha.empty() ? 1 : picture.alpha[texel] / 255.0;
}

// Interpolates valueOf(picture, texel) of the four texels around a place.
template <class ValueOf>
auto pictureAt(const TexturedSurface& surface, double u, double v, const ValueOf& valueOf) {
    const double x = u * surface.picture->width - 0.5, y = v * surface.picture->height - 0.5;
    const auto column = std::int64_t(std::floor(x)), row = std::int64_t(std::floor(y));
    const double s = x - double(column), t = y - double(row);
    const auto texel = [&](std::int64_t i, std::int64_t k) {
        return valueOf(*surface.picture, texelIndex(surface, i, k));
    };
    return (1 - t) * ((1 - s) * texel(column, row) + s * texel(column + 1, row)) +
           t * ((1 - s) * texel(column, row + 1) + s * texel(column + 1, row + 1));
}

std::array<double, 2> uvAt(const TexturedSurface& surface, const Triangle& triangle, const std::array<double, 3>& at) {
    std::array<double, 2> uv{0, 0};
    for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t axis = 0; axis < 2; ++axis) uv[axis] += at[k] * surface.part.color.uv[triangle[k]][axis];
    return uv;
}

}  // namespace

Vec3d colorAt(const TexturedSurface& surface, const Triangle& triangle, const std::array<double, 3>& at) {
    const PartColor& color = surface.part.color;
    Vec3d out = toDouble(*color.material.base), tint;
    for (std::size_t k = 0; k < 3 && !color.tints.empty(); ++k) tint += at[k] * toDouble(color.tints[triangle[k]]);
    if (surface.picture) {
        const auto [u, v] = uvAt(surface, triangle, at);
        out = out * pictureAt(surface, u, v, colorOfTexel);
    }
    return color.tints.empty() ? out : out * tint;
}

double alphaAt(const TexturedSurface& surface, const Triangle& triangle, const std::array<double, 3>& at) {
    const PartColor& color = surface.part.color;
    double alpha = double(color.material.alpha);
    if (surface.picture) {
        const auto [u, v] = uvAt(surface, triangle, at);
        alpha *= pictureAt(surface, u, v, alphaOfTexel);
    }
    if (color.alphas.empty()) return alpha;
    double of_vertices = 0;
    for (std::size_t k = 0; k < 3; ++k) of_vertices += at[k] * double(color.alphas[triangle[k]]);
    return alpha * of_vertices;
}

double texelsAlong(const TexturedSurface& surface, const Triangle& triangle) {
    double longest = 0;
    for (std::size_t k = 0; k < 3 && surface.picture; ++k) {
        const std::array<double, 2>&a = surface.part.color.uv[triangle[k]],
                                 &b = surface.part.color.uv[triangle[(k + 1) % 3]];
        longest = std::max(
            {longest, std::abs(b[0] - a[0]) * surface.picture->width, std::abs(b[1] - a[1]) * surface.picture->height});
    }
    return longest;
}

const TexturePicture* TexturePictures::open(const Texture& texture, const std::string& where,
                                            std::vector<std::filesystem::path>& files) {
    if (const auto found = opened_.find(&texture); found != opened_.end()) return &found->second;
    const std::string name = where + ": " + texture.name;
    TexturePicture picture;
    try {
        picture = texture.file.empty() ? decodeTexture(texture.bytes, name) : readTexture(texture.file, name);
    } catch (const IoError& error) {
        throw IoError(name + ": " + error.what());
    }
    if (!texture.file.empty()) files.push_back(texture.file);
    return &opened_.emplace(&texture, std::move(picture)).first->second;
}

}  // namespace penumbra
