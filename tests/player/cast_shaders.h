#pragma once
// Runs the GLSL of casters (runtime/glsl/cast_glsl.cpp) in shaders of an engine: a compute shader with storage
// buffers, and a fragment shader with texture buffers.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "player/gl/gl_context.h"
#include "player/gl/gl_objects.h"
#include "player/gl/offscreen_target.h"
#include "tests/capi/packed_asset.h"
#include "tests/difference.h"

namespace penumbra::player_test {

// Holds all that differs between kinds of casters. All shaders have RECEIVER(i) and GIVEN(i).
struct CastShaders {
    const char *storage, *textures;  // declare the two buffers of the casters at bindings 0 and 1
    const char* cast;     // void castAt(vec3 place, mat3 local, inout float result[..], out float mirrored[21])
    const char* count;    // the uniform that counts casters
    std::size_t results;  // numbers of a receiver; those of its vertex follow
};

// One of the two buffers.
struct CasterBuffer {
    const char* name;
    GLenum format;  // format of the texture buffer
    std::span<const std::byte> bytes;
};
template <class T>
std::span<const std::byte> bytesOf(const std::vector<T>& values) {
    return std::as_bytes(std::span(values));
}

struct CastInputs {
    std::vector<Vec3> positions, normals, tangents;
    std::vector<float> coefficients = {0, 0, 0, 0};
    std::size_t stride = 0;  // stride of the numbers
    int left_out[2] = {0, 0};
    std::string texts;  // shader text of the library

    std::size_t count() const { return positions.size(); }
    std::vector<float> receivers() const {
        std::vector<float> texels;
        for (std::size_t r = 0; r < count(); ++r)
            for (const Vec3 v : {positions[r], normals[r], tangents[r]})
                texels.insert(texels.end(), {v.x, v.y, v.z, 0.0f});
        return texels;
    }
    // Adds the vertices of a character at `placed`, whose casters [begin, end) are left out.
    void addVertices(const capi_test::Frame& frame, const penumbra_asset_info& info, const Affine& placed, int begin,
                     int end) {
        for (std::size_t v = 0; v < info.vertex_count; ++v) {
            const auto at = [&](const std::vector<float>& a) { return Vec3{a[3 * v], a[3 * v + 1], a[3 * v + 2]}; };
            positions.push_back(placed.point(at(frame.positions)));
            normals.push_back(placed.linear() * at(frame.normals));
            tangents.push_back(placed.linear() * at(frame.tangents));
        }
        coefficients = frame.coefficients;
        stride = info.stride;
        left_out[0] = begin;
        left_out[1] = end;
    }
};

inline Affine affineOf(const float* rows) {
    Affine out;
    std::copy_n(rows, 12, out.m.begin());
    return out;
}

// Reads a text of the C interface by asking for its length first: get(text, capacity, &length).
template <class Get>
std::string textOf(const Get& get) {
    std::size_t length = 0;
    EXPECT_EQ(get(nullptr, 0, &length), PENUMBRA_OK);
    std::string text(length + 1, '?');
    EXPECT_EQ(get(text.data(), length, &length), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(text[0], '?');
    EXPECT_EQ(get(text.data(), text.size(), &length), PENUMBRA_OK);
    EXPECT_EQ(std::strlen(text.c_str()), length);
    return text.c_str();
}
inline std::string castText(const penumbra_asset* asset) {
    return textOf([&](char* text, std::size_t capacity, std::size_t* length) {
        return penumbra_cast_get_glsl(asset, text, capacity, length, nullptr);
    });
}
// The texts for vertices of an asset, which are not shaded here.
inline std::string castTextOf(const capi_test::Asset& asset) {
    const capi_test::Shading shading = capi_test::shading(asset);
    return "#define PENUMBRA_MATERIAL(i) vec4(0)\n#define PENUMBRA_LIGHT(i) vec4(0)\n" +
           textOf([&](char* text, std::size_t capacity, std::size_t* length) {
               return penumbra_shading_get_glsl(shading.get(), text, capacity, length, nullptr);
           }) +
           castText(asset.get());
}

constexpr char kStorageBuffers[] = R"(#version 430 core
layout(local_size_x = 64) in;
layout(std430, binding = 2) readonly buffer Receivers { vec4 receivers[]; };
layout(std430, binding = 3) readonly buffer Numbers { vec4 given[]; };
layout(std430, binding = 4) writeonly buffer Results { float results[]; };
#define RECEIVER(i) receivers[i]
#define GIVEN(i) given[i]
)";
constexpr char kTextureBuffers[] = R"(#version 430 core
uniform samplerBuffer receivers, given;
layout(location = 0) out vec4 color;
#define RECEIVER(i) texelFetch(receivers, i)
#define GIVEN(i) texelFetch(given, i)
)";
constexpr char kCoefficients[] = R"(
#ifndef PENUMBRA_STRIDE4
#define NUMBERS 0
#else
#define NUMBERS (4 * PENUMBRA_STRIDE4)
#endif
uniform int receiver_count, left_out_begin, left_out_end;
)";
constexpr char kCastOn[] = R"(
void castOn(int r, out float result[RESULTS + NUMBERS]) {
    vec3 normal = RECEIVER(3 * r + 1).xyz, tangent = RECEIVER(3 * r + 2).xyz;
    float mirrored[21];
    castAt(RECEIVER(3 * r).xyz, transpose(mat3(tangent, cross(normal, tangent), normal)), result, mirrored);
#ifdef PENUMBRA_STRIDE4
    vec4 numbers[PENUMBRA_STRIDE4];
    for (int q = 0; q < PENUMBRA_STRIDE4; ++q) numbers[q] = GIVEN(r * PENUMBRA_STRIDE4 + q);
    penumbra_cast_coefficients(numbers, mirrored);
    for (int i = 0; i < NUMBERS; ++i) result[RESULTS + i] = numbers[i / 4][i % 4];
#endif
}
)";
constexpr char kComputeMain[] = R"(
void main() {
    int r = int(gl_GlobalInvocationID.x);
    if (r >= receiver_count) return;
    float result[RESULTS + NUMBERS];
    castOn(r, result);
    for (int i = 0; i < RESULTS + NUMBERS; ++i) results[r * (RESULTS + NUMBERS) + i] = result[i];
}
)";
constexpr char kFragmentMain[] = R"(
void main() {
    float result[RESULTS + NUMBERS];
    castOn(int(gl_FragCoord.x), result);
    int q = 4 * int(gl_FragCoord.y);
    color = vec4(result[q], result[q + 1], result[q + 2], result[q + 3]);
}
)";
constexpr char kWholePicture[] = R"(#version 430 core
void main() { gl_Position = vec4(gl_VertexID == 1 ? 3 : -1, gl_VertexID == 2 ? 3 : -1, 0, 1); }
)";

class CastProgram {
public:
    CastProgram(const CastShaders& shaders, const CastInputs& inputs, std::array<CasterBuffer, 2> casters, int count)
        : shaders_(shaders), inputs_(inputs), casters_(casters), count_(count) {}

    std::size_t rowSize() const { return shaders_.results + inputs_.stride; }
    // Return [receivers, rowSize()].
    std::vector<float> computed() const;
    std::vector<float> drawn() const;  // a column for each receiver, 4 numbers a pixel
    // The largest difference of columns [first, first + count) of the results from `expected` [receivers, stride].
    double difference(std::span<const float> results, std::size_t first, std::size_t count,
                      std::span<const float> expected, std::size_t stride) const {
        EXPECT_EQ(results.size(), inputs_.count() * rowSize());
        EXPECT_EQ(expected.size(), inputs_.count() * stride);
        Largest largest;
        for (std::size_t r = 0; r < inputs_.count(); ++r)
            largest.add(
                largestDifference(results.subspan(r * rowSize() + first, count), expected.subspan(r * stride, count)));
        return largest;
    }
    // Expects that receivers that no caster reaches, whose column `seen` is 0, see everything in their first
    // `coefficients`. Returns how many there are.
    std::size_t expectOpen(std::span<const float> results, std::size_t seen, std::size_t coefficients) const {
        std::size_t open = 0;
        for (std::size_t r = 0; r < inputs_.count(); ++r) {
            const std::span<const float> row = results.subspan(r * rowSize(), rowSize());
            if (row[seen] != 0) continue;
            ++open;
            EXPECT_EQ(row[0], 2 * float(std::sqrt(M_PI)));
            for (std::size_t i = 1; i < coefficients; ++i) EXPECT_EQ(row[i], 0.0f);
        }
        return open;
    }

private:
    const CastShaders& shaders_;
    const CastInputs& inputs_;
    std::array<CasterBuffer, 2> casters_;
    int count_;

    std::string source(const char* buffers, const char* casters, const char* main) const {
        return std::string(buffers) + casters + inputs_.texts + kCoefficients + "#define RESULTS " +
               std::to_string(shaders_.results) + "\nuniform int " + shaders_.count + ";\n" + shaders_.cast + kCastOn +
               main;
    }
    void use(const GlObject& program) const {
        gl::UseProgram(program.id());
        for (const auto& [name, value] : {std::pair(shaders_.count, count_),
                                          {"receiver_count", int(inputs_.count())},
                                          {"left_out_begin", inputs_.left_out[0]},
                                          {"left_out_end", inputs_.left_out[1]}})
            gl::Uniform1i(gl::GetUniformLocation(program.id(), name), value);
    }
};

inline std::vector<float> CastProgram::computed() const {
    const auto context = createGlContext(GlBackend::kOsMesa);
    const GlObject program = makeComputeProgram(source(kStorageBuffers, shaders_.storage, kComputeMain));
    use(program);
    std::vector<float> results(inputs_.count() * rowSize(), -7.0f);
    const std::vector<float> receivers = inputs_.receivers();
    std::vector<GlObject> buffers;
    for (const std::span<const std::byte> bytes :
         {casters_[0].bytes, casters_[1].bytes, bytesOf(receivers), bytesOf(inputs_.coefficients), bytesOf(results)}) {
        buffers.push_back(makeBuffer(GL_SHADER_STORAGE_BUFFER, bytes));
        gl::BindBufferBase(GL_SHADER_STORAGE_BUFFER, GLuint(buffers.size() - 1), buffers.back().id());
    }
    gl::DispatchCompute(GLuint((inputs_.count() + 63) / 64), 1, 1);
    gl::MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    const auto size = GLsizeiptr(results.size() * sizeof(float));
    std::memcpy(results.data(), gl::MapBufferRange(GL_SHADER_STORAGE_BUFFER, 0, size, GL_MAP_READ_BIT),
                std::size_t(size));
    checkGl("casting");
    return results;
}

inline std::vector<float> CastProgram::drawn() const {
    const auto context = createGlContext(GlBackend::kOsMesa);
    const GlObject program = makeProgram(kWholePicture, source(kTextureBuffers, shaders_.textures, kFragmentMain));
    use(program);
    const std::vector<float> receivers = inputs_.receivers();
    std::vector<TextureBuffer> buffers;
    for (const CasterBuffer& buffer :
         {casters_[0], casters_[1], CasterBuffer{"receivers", GL_RGBA32F, bytesOf(receivers)},
          CasterBuffer{"given", GL_RGBA32F, bytesOf(inputs_.coefficients)}}) {
        const auto unit = GLint(buffers.size());
        gl::ActiveTexture(GLenum(GL_TEXTURE0 + unit));
        buffers.push_back(makeTextureBuffer(buffer.format, buffer.bytes));
        gl::BindTexture(GL_TEXTURE_BUFFER, buffers.back().texture.id());
        gl::Uniform1i(gl::GetUniformLocation(program.id(), buffer.name), unit);
    }
    const std::size_t rows = rowSize() / 4, count = inputs_.count();
    const OffscreenTarget target(int(count), int(rows), 1);
    target.begin();
    const GlObject vertex_array = makeVertexArray();
    gl::BindVertexArray(vertex_array.id());
    const std::vector<std::uint32_t> triangle = {0, 1, 2};
    const GlObject indices = makeBuffer(GL_ELEMENT_ARRAY_BUFFER, std::span<const std::uint32_t>(triangle));
    gl::DrawElements(GL_TRIANGLES, 3, GL_UNSIGNED_INT, nullptr);
    checkGl("drawing");
    const Image image = target.read();
    std::vector<float> results;
    for (std::size_t r = 0; r < count; ++r)
        for (std::size_t q = 0; q < rows; ++q) {
            const std::size_t pixel = (rows - 1 - q) * count + r;
            for (int c = 0; c < 3; ++c) results.push_back(image.pixels[pixel][c]);
            results.push_back(image.alpha[pixel]);
        }
    return results;
}

}  // namespace penumbra::player_test
