// Tests an engine's own shader around penumbra.glsl and the text of penumbra_shading_get_glsl(): skinning, the
// model's numbers from the asset's packed words, and shading. Everything that it reads comes out of the C interface.
// It gives what the CPU gives.
#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <sstream>

#include "formats/image/texture_file.h"
#include "player/draw/picture_view.h"
#include "player/gl/gl_context.h"
#include "player/gl/gl_objects.h"
#include "player/gl/offscreen_target.h"
#include "player/render/render_offscreen.h"
#include "tests/capi/packed_asset.h"
#include "tests/difference.h"
#include "tests/textured_tube.h"

namespace penumbra::test_engine_glsl {
namespace {

using namespace capi_test;

std::string includeFile() {
    std::ifstream file(PENUMBRA_SOURCE_DIR "/runtime/shaders/penumbra.glsl");
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
}

std::string shadingText(const Shading& shading) {
    std::size_t length = 0;
    EXPECT_EQ(penumbra_shading_get_glsl(shading.get(), nullptr, 0, &length, nullptr), PENUMBRA_OK);
    std::string text(length + 1, '?');
    EXPECT_EQ(penumbra_shading_get_glsl(shading.get(), text.data(), length, &length, nullptr),
              PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(text[0], '?');
    EXPECT_EQ(penumbra_shading_get_glsl(shading.get(), text.data(), text.size(), &length, nullptr), PENUMBRA_OK);
    EXPECT_EQ(std::strlen(text.c_str()), length);
    return text.c_str();
}

constexpr char kVertexShader[] = R"(#version 430 core
void main() { gl_Position = vec4(gl_VertexID == 1 ? 3 : -1, gl_VertexID == 2 ? 3 : -1, 0, 1); }
)";
constexpr char kBuffers[] = R"(#version 430 core
uniform samplerBuffer materials, light;
uniform samplerBuffer positions, normals, tangents;  // 3 texels of one float each
uniform samplerBuffer weights, bones, rotations, scores;
uniform usamplerBuffer joints, words, clusters;      // clusters: of each vertex; material, then what Cluster below has
uniform vec3 eye;
uniform int influences;
ivec4 range, start;  // of this vertex' cluster: first vertex, vertices, components, first score; mean, basis, material
#define PENUMBRA_MATERIAL(i) texelFetch(materials, i)
#define PENUMBRA_LIGHT(i) texelFetch(light, i)
#define PENUMBRA_SCORE(k) texelFetch(scores, range.w + k).x
#define WORD(i) texelFetch(words, i).x
#define PENUMBRA_MEAN(i) penumbra_unpack_f16(uvec2(WORD(start.x + 2 * (i)), WORD(start.x + 2 * (i) + 1)))
#define PENUMBRA_BASIS(i) penumbra_unpack_i8(WORD(start.y + (i)))
)";
constexpr char kVertex[] = R"(
vec3 vectorOf(samplerBuffer b, int v) {
    return vec3(texelFetch(b, 3 * v).x, texelFetch(b, 3 * v + 1).x, texelFetch(b, 3 * v + 2).x);
}
PenumbraSurface surfaceOf(int v, out vec4 numbers[PENUMBRA_STRIDE4]) {
    range = ivec4(texelFetch(clusters, 3 * v));
    start = ivec4(texelFetch(clusters, 3 * v + 1));
    vec4 row[3] = vec4[3](vec4(0), vec4(0), vec4(0));
    for (int k = 0; k < influences; ++k)
        for (int r = 0; r < 3; ++r)
            row[r] += texelFetch(weights, v * influences + k).x *
                      texelFetch(bones, 3 * int(texelFetch(joints, v * influences + k).x) + r);
    int c = int(texelFetch(clusters, 3 * v + 2).x);
    penumbra_coefficients(v - range.x, range.y, range.z, numbers);
    penumbra_clamp_ambient(numbers);
    return penumbra_surface(row[0], row[1], row[2], vectorOf(positions, v), vectorOf(normals, v), vectorOf(tangents, v),
                            vectorOf(rotations, 3 * c), vectorOf(rotations, 3 * c + 1), vectorOf(rotations, 3 * c + 2));
}
)";
constexpr char kMain[] = R"(
layout(location = 0) out vec4 color;
void main() {
    vec4 numbers[PENUMBRA_STRIDE4];
    PenumbraSurface s = surfaceOf(int(gl_FragCoord.x), numbers);
    mat3 local_from_model = penumbra_local_from_model(s);
    color = vec4(penumbra_shade(numbers, penumbra_to_eye(s, eye, local_from_model), local_from_model, start.z),
                 penumbra_ambient(numbers));
}
)";

// Every cluster's packed arrays one after the other, the [V, 3] texels that lead a vertex to them, and the scores
// with their scale.
struct Model {
    std::vector<std::uint32_t> words, clusters;
    std::vector<float> scores, rotations;

    Model(const Asset& asset, const Character& character, const Shading& shading, const penumbra_asset_info& info)
        : scores(info.score_count), rotations(9 * info.cluster_count) {
        penumbra_character_get_scores(character.get(), scores.data(), rotations.data());
        for (std::size_t c = 0; c < info.cluster_count; ++c) {
            penumbra_cluster cluster;
            EXPECT_EQ(penumbra_asset_get_cluster(asset.get(), c, &cluster), PENUMBRA_OK);
            EXPECT_EQ(cluster.mean_precision, PENUMBRA_F16);
            EXPECT_EQ(cluster.basis_precision, PENUMBRA_I8);
            const std::size_t count = cluster.vertex_count * info.stride;
            const std::size_t mean = append(cluster.mean, 2 * count);
            const std::size_t basis = append(cluster.basis, cluster.component_count * count);
            for (std::size_t k = 0; k < cluster.component_count; ++k)
                scores[cluster.first_score + k] *= cluster.basis_scale[k];
            for (std::size_t v = cluster.first_vertex; v < cluster.first_vertex + cluster.vertex_count; ++v)
                for (const std::size_t n :
                     {cluster.first_vertex, cluster.vertex_count, cluster.component_count, cluster.first_score, mean,
                      basis,
                      penumbra_shading_material_of(shading.get(), info.slot_of_vertex ? info.slot_of_vertex[v] : 0),
                      std::size_t(0), c, c, c, c})
                    clusters.push_back(std::uint32_t(n));
        }
    }

private:
    std::size_t append(const void* bytes, std::size_t size) {
        const std::size_t first = words.size();
        words.resize(first + size / 4);
        std::memcpy(words.data() + first, bytes, size);
        return first;
    }
};

// Texture buffers bound to the samplers of their names.
class Textures {
public:
    explicit Textures(const GlObject& program) : program_(&program) {}
    template <class T>
    void add(const char* name, GLenum format, const T* values, std::size_t count) {
        const auto unit = GLint(buffers_.size());
        gl::ActiveTexture(GLenum(GL_TEXTURE0 + unit));  // before it is made, which binds it
        buffers_.push_back(makeTextureBuffer(format, std::span<const T>(values, count)));
        gl::BindTexture(GL_TEXTURE_BUFFER, buffers_.back().texture.id());
        gl::Uniform1i(gl::GetUniformLocation(program_->id(), name), unit);
    }

private:
    const GlObject* program_;
    std::vector<TextureBuffer> buffers_;
};

// Everything that the shader reads, bound to the program in use.
struct EngineArrays {
    Textures textures;

    EngineArrays(const GlObject& program, const Asset& asset, const Character& character, const Shading& shading,
                 std::size_t frame)
        : textures(program) {
        const penumbra_asset_info info = infoOf(asset);
        const std::size_t v = info.vertex_count;
        std::vector<float> materials(4 * penumbra_shading_material_count(shading.get()) *
                                     penumbra_shading_gpu_material_texels(shading.get())),
            light(4 * penumbra_shading_gpu_light_texels(shading.get()));
        EXPECT_EQ(penumbra_shading_get_gpu_materials(shading.get(), materials.data(), nullptr), PENUMBRA_OK);
        EXPECT_EQ(penumbra_shading_get_gpu_light(shading.get(), light.data(), nullptr), PENUMBRA_OK);
        penumbra_frame stored;
        EXPECT_EQ(penumbra_asset_get_frame(asset.get(), frame, &stored), PENUMBRA_OK);
        const Model model(asset, character, shading, info);
        textures.add("materials", GL_RGBA32F, materials.data(), materials.size());
        textures.add("light", GL_RGBA32F, light.data(), light.size());
        textures.add("positions", GL_R32F, info.rest_positions, 3 * v);
        textures.add("normals", GL_R32F, info.rest_normals, 3 * v);
        textures.add("tangents", GL_R32F, info.rest_tangents, 3 * v);
        textures.add("weights", GL_R32F, info.skin_weights, info.influence_count * v);
        textures.add("joints", GL_R16UI, info.skin_joints, info.influence_count * v);
        textures.add("bones", GL_RGBA32F, stored.matrices, 12 * info.joint_count);
        textures.add("rotations", GL_R32F, model.rotations.data(), model.rotations.size());
        textures.add("scores", GL_R32F, model.scores.data(), model.scores.size());
        textures.add("words", GL_R32UI, model.words.data(), model.words.size());
        textures.add("clusters", GL_RGBA32UI, model.clusters.data(), model.clusters.size());
        gl::Uniform1i(gl::GetUniformLocation(program.id(), "influences"), GLint(info.influence_count));
    }
};

// Returns the radiance and the ambient term of every vertex, computed by the shader.
Image drawn(const std::string& source, const Asset& asset, const Character& character, const Shading& shading,
            const penumbra_asset_info& info, std::size_t frame, const float* eye) {
    const auto context = createGlContext(GlBackend::kOsMesa);
    const GlObject program = makeProgram(kVertexShader, source);
    gl::UseProgram(program.id());
    const EngineArrays arrays(program, asset, character, shading, frame);
    gl::Uniform3f(gl::GetUniformLocation(program.id(), "eye"), eye[0], eye[1], eye[2]);
    const OffscreenTarget target(int(info.vertex_count), 1, 1);
    target.begin();
    const GlObject vertex_array = makeVertexArray();
    gl::BindVertexArray(vertex_array.id());
    const std::vector<std::uint32_t> triangle = {0, 1, 2};
    const GlObject indices = makeBuffer(GL_ELEMENT_ARRAY_BUFFER, std::span<const std::uint32_t>(triangle));
    gl::DrawElements(GL_TRIANGLES, 3, GL_UNSIGNED_INT, nullptr);
    checkGl("drawing");
    return target.read();
}

// Measured: 5.4e-7 of radiance about 1 and of the ambient term, because the processor rounds the weights of bytes to
// 16 bits and the shader does not. 2 and 3 times as much is allowed.
TEST(EngineGlsl, GivesWhatTheCpuGives) {
    const float turn[9] = {0.6f, 0, 0.8f, 0, 1, 0, -0.8f, 0, 0.6f};
    for (const char* convention : {"D5", "A4", "B3"})
        for (const int form : {0, 1, 2}) {
            if (form > 0 && std::string(convention) != "D5") continue;
            Recipe recipe{.tube = {.rings = 12, .segments = 9}};
            recipe.tube.convention = parseConvention(convention);
            const std::vector<std::byte> bytes = packed(recipe);
            const Asset asset = open(bytes);
            const penumbra_asset_info info = infoOf(asset);
            const Character character = capi_test::character(asset);
            const Shading shading = capi_test::shading(asset, {PENUMBRA_SLICES, penumbra_light_form(form), 0});
            ASSERT_EQ(penumbra_shading_set_light(shading.get(), 1, nullptr), PENUMBRA_OK);
            EXPECT_EQ(penumbra_shading_light(shading.get()), 1u);
            ASSERT_EQ(penumbra_shading_set_light_rotation(shading.get(), turn, nullptr), PENUMBRA_OK);
            ASSERT_EQ(penumbra_character_set_frame(character.get(), 1, nullptr), PENUMBRA_OK);
            Frame frame(info);
            frame.evaluate(character.get(), info);
            frame.shade(shading.get(), 0, info.vertex_count);
            const std::string source = kBuffers + shadingText(shading) + includeFile() + kVertex + kMain;
            const Image image = drawn(source, asset, character, shading, info, 1, frame.eye);
            Largest radiance, ambient;
            for (std::size_t v = 0; v < info.vertex_count; ++v) {
                ambient.add(std::abs(double(image.alpha[v]) - frame.ambient[v]));
                for (int c = 0; c < 3; ++c)
                    radiance.add(std::abs(double(image.pixels[v][c]) - frame.radiance[3 * v + std::size_t(c)]));
            }
            EXPECT_LT(radiance, 1e-6) << convention << " form " << form;
            EXPECT_LT(ambient, 1.5e-6) << convention << " form " << form;
            std::printf("%s form %d: radiance within %.1e, ambient within %.1e\n", convention, form, radiance.value(),
                        ambient.value());
        }
}

constexpr char kTexturedVertex[] = R"(
layout(location = 0) in uint source;  // a vertex of the mesh, which seams draw several times
layout(location = 1) in vec2 uv;
uniform mat4 clip_from_model;
uniform int parts[3];  // the materials of D, A and B
out vec3 d, a, b;
out vec2 place;
void main() {
    vec4 numbers[PENUMBRA_STRIDE4];
    PenumbraSurface s = surfaceOf(int(source), numbers);
    mat3 local_from_model = penumbra_local_from_model(s);
    vec3 to_eye = penumbra_to_eye(s, eye, local_from_model);
    vec3 term[3];
    for (int i = 0; i < 3; ++i) term[i] = max(penumbra_shade(numbers, to_eye, local_from_model, parts[i]), 0.0);
    d = term[0];
    a = term[1];
    b = term[2];
    place = uv;
    gl_Position = clip_from_model * vec4(s.position, 1.0);
}
)";
constexpr char kTexturedFragment[] = R"(
in vec3 d, a, b;
in vec2 place;
uniform sampler2D base_color, metallic_roughness, emissive, occlusion;
uniform vec3 base, glow, f0;
uniform float f90, metallic, strength;
layout(location = 0) out vec4 color;
void main() {
    vec3 joined = penumbra_join_terms(d, a, b, base * texture(base_color, place).rgb,
                                      metallic * texture(metallic_roughness, place).b, f0, f90);
    float open = mix(1.0, texture(occlusion, place).r, strength);
    color = vec4(joined * open + glow * texture(emissive, place).rgb, 1.0);
}
)";

// The vertices that are drawn of a textured mesh, as an engine has them from its own copy of the model.
struct EngineMesh {
    GlObject array = makeVertexArray(), sources, places, indices;
    std::size_t count = 0;

    explicit EngineMesh(const AssetView& asset) {
        const SurfaceView& surface = *asset.surface;
        std::vector<std::uint32_t> source(asset.mesh.positions.size());
        for (std::size_t v = 0; v < source.size(); ++v) source[v] = std::uint32_t(v);
        source.insert(source.end(), surface.seam_vertices.begin(), surface.seam_vertices.end());
        const std::vector<std::uint32_t> triangles =
            surface.drawnTriangles(asset.mesh.triangles, asset.mesh.positions.size());
        gl::BindVertexArray(array.id());
        sources = makeBuffer(GL_ARRAY_BUFFER, std::span<const std::uint32_t>(source));
        gl::VertexAttribIPointer(0, 1, GL_UNSIGNED_INT, 0, nullptr);
        gl::EnableVertexAttribArray(0);
        places = makeBuffer(GL_ARRAY_BUFFER, surface.uvOf(0));
        gl::VertexAttribPointer(1, 2, GL_FLOAT, GL_FALSE, 0, nullptr);
        gl::EnableVertexAttribArray(1);
        indices = makeBuffer(GL_ELEMENT_ARRAY_BUFFER, std::span<const std::uint32_t>(triangles));
        count = triangles.size();
    }
};

// An engine's own textures, on the units behind those of its arrays.
struct EnginePictures {
    std::vector<GlObject> all;

    void add(const GlObject& program, const AssetView& asset, const char* name, const TextureUse& use) {
        const bool srgb = std::string(name) == "base_color" || std::string(name) == "emissive";
        const TexturePicture picture = decodeTexture(asset.surface->textures[use.texture].bytes, name);
        const auto unit = GLint(12 + all.size());
        GLuint id = 0;
        gl::GenTextures(1, &id);
        all.emplace_back(id, [](GLuint t) { gl::DeleteTextures(1, &t); });
        gl::ActiveTexture(GLenum(GL_TEXTURE0 + unit));
        gl::BindTexture(GL_TEXTURE_2D, id);
        gl::PixelStorei(GL_UNPACK_ALIGNMENT, 1);
        gl::TexImage2D(GL_TEXTURE_2D, 0, srgb ? GL_SRGB8 : GL_RGB8, picture.width, picture.height, 0, GL_RGB,
                       GL_UNSIGNED_BYTE, picture.rgb.data());
        const GLint wraps[] = {GL_REPEAT, GL_MIRRORED_REPEAT, GL_CLAMP_TO_EDGE};
        gl::TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, wraps[int(use.wrapU())]);
        gl::TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, wraps[int(use.wrapV())]);
        gl::TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
        gl::TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
        gl::GenerateMipmap(GL_TEXTURE_2D);
        gl::Uniform1i(gl::GetUniformLocation(program.id(), name), unit);
    }
};

// What fragments join: the slot's factors and its textures.
EnginePictures setLook(const GlObject& program, const AssetView& view, const penumbra_slot_surface& slot) {
    const auto uniform = [&](const char* name) { return gl::GetUniformLocation(program.id(), name); };
    gl::Uniform1i(uniform("parts[0]"), GLint(slot.diffuse));
    gl::Uniform1i(uniform("parts[1]"), GLint(slot.step_f0[0]));
    gl::Uniform1i(uniform("parts[2]"), GLint(slot.step_f90[0]));
    gl::Uniform3fv(uniform("base"), 1, slot.base);
    gl::Uniform3fv(uniform("glow"), 1, slot.emissive);
    gl::Uniform3fv(uniform("f0"), 1, slot.f0);
    gl::Uniform1f(uniform("f90"), slot.f90);
    gl::Uniform1f(uniform("metallic"), slot.metallic);
    gl::Uniform1f(uniform("strength"), slot.occlusion_strength);
    EnginePictures pictures;
    const SlotSurface& look = view.surface->slots[0];
    pictures.add(program, view, "base_color", look.use(TextureRole::kBaseColor));
    pictures.add(program, view, "metallic_roughness", look.use(TextureRole::kMetallicRoughness));
    pictures.add(program, view, "emissive", look.use(TextureRole::kEmissive));
    pictures.add(program, view, "occlusion", look.use(TextureRole::kOcclusion));
    return pictures;
}

Image drawnWithTextures(const std::vector<std::byte>& bytes, const AssetView& view, const RenderOptions& options) {
    const Asset asset = open(bytes);
    const Character character = capi_test::character(asset);
    EXPECT_EQ(penumbra_character_set_frame(character.get(), std::size_t(options.frame), nullptr), PENUMBRA_OK);
    const Shading shading = capi_test::shading(asset);
    penumbra_slot_surface slot{};
    EXPECT_EQ(penumbra_asset_slot_surface(asset.get(), 0, &slot), 1);
    const auto context = createGlContext(GlBackend::kOsMesa);
    const GlObject program = makeProgram(kBuffers + shadingText(shading) + includeFile() + kVertex + kTexturedVertex,
                                         "#version 430 core\n" + includeFile() + kTexturedFragment);
    gl::UseProgram(program.id());
    const EngineArrays arrays(program, asset, character, shading, std::size_t(options.frame));
    Frame frame(infoOf(asset));
    frame.evaluate(character.get(), infoOf(asset));
    std::vector<Vec3> positions;
    for (std::size_t at = 0; at < frame.positions.size(); at += 3)
        positions.push_back({frame.positions[at], frame.positions[at + 1], frame.positions[at + 2]});
    const FrameView camera = makePictureView(options, view, positions);
    gl::UniformMatrix4fv(gl::GetUniformLocation(program.id(), "clip_from_model"), 1, GL_FALSE,
                         camera.clip_from_model.data());
    gl::Uniform3fv(gl::GetUniformLocation(program.id(), "eye"), 1, &camera.eye.x);
    const EnginePictures pictures = setLook(program, view, slot);
    const OffscreenTarget target(options.width, options.height, 1);
    target.begin();
    const EngineMesh mesh(view);
    gl::DrawElements(GL_TRIANGLES, GLsizei(mesh.count), GL_UNSIGNED_INT, nullptr);
    checkGl("drawing");
    return target.read();
}

// An engine draws a textured character with the published include and the numbers of penumbra_asset_slot_surface(), and
// its picture is that of `render`, of the CPU path. Measured: 0.014 of a step of 255 of the brightest.
TEST(EngineGlsl, DrawsTexturesAsRenderDoes) {
    const std::vector<std::byte> bytes = synthetic::texturedTube(
        synthetic::TexturedSlots::kLevel, synthetic::light(4, 0.3), {.rings = 16, .segments = 12}, AssetPrecision::kI8);
    const AssetView view = openAsset(bytes);
    RenderOptions options;
    options.width = options.height = 96;
    options.samples = 1;
    options.frame = 1;
    options.camera = "pitch=10,yaw=30";
    options.textures = true;
    options.path = EvaluationPath::kCpu;
    const Image expected = renderOffscreen(options, view, nullptr, 1).image,
                image = drawnWithTextures(bytes, view, options);
    Largest brightest, worst;
    std::size_t covered = 0;
    for (std::size_t p = 0; p < image.pixels.size(); ++p) {
        EXPECT_EQ(image.alpha[p], expected.alpha[p]);
        if (image.alpha[p] == 0) continue;
        ++covered;
        for (int c = 0; c < 3; ++c) {
            brightest.add(expected.pixels[p][c]);
            worst.add(std::abs(double(image.pixels[p][c]) - double(expected.pixels[p][c])));
        }
    }
    std::printf("textures: within %.1e of a step over %zu pixels\n", 255 * worst / brightest, covered);
    EXPECT_LT(255 * worst / brightest, 0.5);
    EXPECT_GT(covered, 500u);
}

TEST(EngineGlsl, WrongCallsAreRefused) {
    const std::vector<std::byte> bytes = packed();
    const Asset asset = open(bytes);
    const Shading shading = capi_test::shading(asset);
    std::size_t length = 7;
    float texel[4];
    EXPECT_EQ(penumbra_shading_get_glsl(nullptr, nullptr, 0, &length, nullptr), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_shading_get_glsl(shading.get(), nullptr, 0, nullptr, nullptr), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_shading_get_gpu_materials(nullptr, texel, nullptr), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_shading_get_gpu_materials(shading.get(), nullptr, nullptr), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_shading_get_gpu_light(nullptr, texel, nullptr), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_shading_get_gpu_light(shading.get(), nullptr, nullptr), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_shading_gpu_material_texels(nullptr) + penumbra_shading_gpu_light_texels(nullptr), 0u);
    EXPECT_EQ(penumbra_shading_material_of(nullptr, 0), PENUMBRA_NONE);
    EXPECT_EQ(penumbra_shading_material_of(shading.get(), 2), PENUMBRA_NONE);
    EXPECT_EQ(penumbra_shading_light(nullptr), PENUMBRA_NONE);
    EXPECT_EQ(length, 7u);
}

}  // namespace
}  // namespace penumbra::test_engine_glsl
