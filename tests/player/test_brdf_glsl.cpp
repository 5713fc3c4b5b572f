// Holds the GLSL of BRDF lobes to the CPU.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <numbers>

#include "player/gl/gl_context.h"
#include "player/gl/gl_objects.h"
#include "runtime/glsl/brdf_glsl.h"
#include "sh/brdf/brdf_lobe.h"
#include "sh/quadrature.h"
#include "tests/difference.h"

namespace penumbra::test_brdf_glsl {
namespace {

constexpr char kBuffers[] = R"(#version 430 core
layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Directions { vec4 directions[]; };
layout(std430, binding = 1) writeonly buffer Results { vec4 results[]; };
uniform int model, count;
uniform vec4 parameters;
uniform vec3 color;
)";
constexpr char kMain[] = R"(
void main() {
    int k = int(gl_GlobalInvocationID.x);
    if (k >= count * count) return;
    vec3 wi = directions[k % count].xyz, wo = directions[k / count].xyz;
    results[k] = vec4(penumbra_brdf_lobe(model, parameters, color, wi, wo),
                      penumbra_mirror_reflectance(model, parameters, color, wo).x);
}
)";

struct Pixel {
    Vec3 lobe;
    float mirror;
};

// Directions over the hemisphere, at the horizon and below, and pairs that mirror one another but for small angles, so
// that the narrowest lobes are seen on their peaks and flanks.
std::vector<Vec3> directionsToTest() {
    std::vector<Vec3> directions{{0, 0, 1}, {1, 0, 0}, {0, 0, -1}, {0.6f, 0, -0.8f}};
    for (Vec3d d : fibonacciSphere(40))
        if (d.z > 0) directions.push_back(toFloat(d));
    for (double theta : {0.0, 0.5, 1.2, 1.5, 1.57, 1.5707, 1.570796})
        for (double off : {0.0, 1e-4, 1e-3, 3e-3, 0.01, 0.03})
            for (double phi : {0.7, 0.7 + std::numbers::pi})
                directions.push_back(toFloat({std::sin(theta + off) * std::cos(phi + off),
                                              std::sin(theta + off) * std::sin(phi + off), std::cos(theta + off)}));
    return directions;
}

// Returns [wo, wi].
std::vector<Pixel> onGpu(const BrdfLobe& lobe, const std::vector<Vec3>& directions) {
    const GlObject program = makeComputeProgram(kBuffers + brdfGlsl() + kMain);
    gl::UseProgram(program.id());
    const auto at = [&](const char* name) { return gl::GetUniformLocation(program.id(), name); };
    gl::Uniform1i(at("model"), int(lobe.model));
    gl::Uniform1i(at("count"), int(directions.size()));
    gl::Uniform4fv(at("parameters"), 1, lobe.parameters.data());
    gl::Uniform3f(at("color"), lobe.color.x, lobe.color.y, lobe.color.z);
    std::vector<float> given;
    for (Vec3 d : directions) given.insert(given.end(), {d.x, d.y, d.z, 0.0f});
    std::vector<Pixel> results(directions.size() * directions.size(), {{-7, -7, -7}, -7});
    const GlObject in = makeBuffer(GL_SHADER_STORAGE_BUFFER, std::span<const float>(given)),
                   out = makeBuffer(GL_SHADER_STORAGE_BUFFER, std::span<const Pixel>(results));
    gl::BindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, in.id());
    gl::BindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, out.id());
    gl::DispatchCompute(GLuint((results.size() + 63) / 64), 1, 1);
    gl::MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    const std::size_t size = results.size() * sizeof(Pixel);
    std::memcpy(results.data(), gl::MapBufferRange(GL_SHADER_STORAGE_BUFFER, 0, GLsizeiptr(size), GL_MAP_READ_BIT),
                size);
    checkGl("evaluating lobes");
    return results;
}

// The difference of f cos from the CPU's, as a share of the largest f cos of any direction at this view, or of 1/pi
// where that is larger: of white, at an exposure that shows the peak of the lobe.
double worstDifference(const BrdfLobe& lobe, const std::vector<Vec3>& directions) {
    const std::vector<Pixel> gpu = onGpu(lobe, directions);
    const std::size_t count = directions.size();
    Largest worst;
    for (std::size_t o = 0; o < count; ++o) {
        Largest white, difference;
        white.add(1 / std::numbers::pi);
        for (std::size_t i = 0; i < count; ++i) {
            const Vec3 cpu = evalLobes({&lobe, 1}, directions[i], directions[o]), ours = gpu[o * count + i].lobe;
            const double cosine = std::max(0.0f, directions[i].z);
            for (int c = 0; c < 3; ++c) {
                EXPECT_TRUE(std::isfinite(ours[c])) << nameOf(lobe.model) << " " << o << " " << i;
                white.add(cpu[c] * cosine);
                difference.add(std::abs(double(ours[c]) - cpu[c]) * cosine);
            }
            EXPECT_NEAR(gpu[o * count + i].mirror, mirrorReflectance({&lobe, 1}, directions[o]).x, 1e-6);
        }
        worst.add(difference / white);
    }
    return worst;
}

// Measured: 4e-4 of white for the narrowest lobes, 1e-3 for the power 1e5, 1e-4 for all others.
TEST(BrdfGlsl, GivesWhatTheCpuGives) {
    const auto context = createGlContext(GlBackend::kOsMesa);
    const std::vector<Vec3> directions = directionsToTest();
    for (const char* text : {"lambert:color=0.5/0.2/0.1",
                             "oren-nayar",
                             "oren-nayar:sigma=0",
                             "oren-nayar:sigma=1.5708",
                             "phong",
                             "phong:exponent=0",
                             "phong:exponent=0.001",
                             "phong:exponent=1e5,color=0.3/1/1",
                             "blinn-phong",
                             "blinn-phong:exponent=0",
                             "blinn-phong:exponent=1e5",
                             "ward",
                             "ward:ax=0.01,ay=0.01",
                             "ward:ax=10,ay=0.01",
                             "ward-gmd",
                             "ward-gmd:ax=0.01,ay=0.01",
                             "ward-gmd:ax=10,ay=10",
                             "ashikhmin-shirley",
                             "ashikhmin-shirley:nu=1e5,nv=1e5",
                             "ashikhmin-shirley:nu=0,nv=1e5,rs=1",
                             "ggx",
                             "ggx:alpha=0.01,f0=0.04",
                             "ggx:alpha=1,f0=1",
                             "cook-torrance",
                             "cook-torrance:m=0.01,ior=1",
                             "cook-torrance:m=0.01,ior=100",
                             "cook-torrance:m=1",
                             "principled-diffuse:f0=0.2,f90=0.7",
                             "ggx-f0:roughness=0.1",
                             "ggx-f90:roughness=0.3",
                             "mirror:f0=0.3"}) {
        const double worst = worstDifference(lobeOf(parseBrdf(text)), directions);
        std::printf("%s: %.2g of white\n", text, worst);
        EXPECT_LT(worst, 0.5 / 255) << text;
    }
}

TEST(BrdfGlsl, CompilesAsGlsl330AndIgnoresUnknownModels) {
    const auto context = createGlContext(GlBackend::kOsMesa);
    EXPECT_NO_THROW(makeProgram("#version 330 core\nvoid main() { gl_Position = vec4(0.0); }\n",
                                "#version 330 core\nout vec4 color;\n" + brdfGlsl() +
                                    "void main() { color = vec4(penumbra_brdf_lobe(0, vec4(0.0), vec3(1.0), "
                                    "vec3(0.0, 0.0, 1.0), gl_FragCoord.xyz), 1.0); }\n"));
    for (const Pixel& pixel : onGpu({BrdfModel(77), {}, {1, 1, 1}}, {{0, 0, 1}, {0.6f, 0, 0.8f}}))
        EXPECT_EQ(pixel.lobe, Vec3{});
}

}  // namespace
}  // namespace penumbra::test_brdf_glsl
