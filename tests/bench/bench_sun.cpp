// bench_sun [PREFIX]: processor time, summed over all cores, of drawing the sun's map (1024 texels a side) and of
// looking it up, on the CPU and in GL. The picture has 800 x 600 pixels and shows a lumpy ball of 13,041 vertices on a
// ground. The last ratio is to the same picture without the sun. With PREFIX it writes the pictures, PREFIX<radius in
// 1/100 degree>.png. On a GPU the times are those of the driver alone.
#include <algorithm>
#include <cstdio>
#include <ctime>

#include "formats/image/image_file.h"
#include "player/draw/sun_map_painter.h"
#include "player/gl/gl_context.h"
#include "player/gl/offscreen_target.h"
#include "tests/runtime/sun_scenes.h"

namespace penumbra {
namespace {

using player_test::SunMesh;

constexpr int kWidth = 800, kHeight = 600, kRounds = 9;
constexpr double kRadians = std::numbers::pi / 180;

constexpr const char* kVertex = R"(#version 430 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 vertex_normal;
uniform mat4 clip_from_model;
out vec3 place, normal;
void main() {
    place = position;
    normal = vertex_normal;
    gl_Position = clip_from_model * vec4(position, 1.0);
}
)";

std::string fragmentSource(const char* visibility) {
    return "#version 430 core\n" + sunGlsl() + R"(
in vec3 place, normal;
layout(location = 0) out vec4 color;
void main() {
    vec3 n = normalize(normal);
    color = vec4(vec3(0.2 + 0.8 * max(dot(n, vec3(0.48, 0.36, 0.8)), 0.0) * )" +
           visibility + R"(), 1.0);
}
)";
}

// A mesh with normals, in GL.
struct BenchMesh {
    GlObject vertex_array, positions, normals, triangles;
    GLsizei indices;
    BenchMesh(const SunMesh& mesh, std::span<const Vec3> mesh_normals)
        : vertex_array(makeVertexArray()), indices(GLsizei(mesh.triangles.size())) {
        gl::BindVertexArray(vertex_array.id());
        positions = makeBuffer(GL_ARRAY_BUFFER, std::as_bytes(std::span(mesh.positions)));
        gl::VertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, 0, nullptr);
        normals = makeBuffer(GL_ARRAY_BUFFER, std::as_bytes(mesh_normals));
        gl::VertexAttribPointer(1, 3, GL_FLOAT, GL_FALSE, 0, nullptr);
        gl::EnableVertexAttribArray(0);
        gl::EnableVertexAttribArray(1);
        triangles = makeBuffer(GL_ELEMENT_ARRAY_BUFFER, std::span<const std::uint32_t>(mesh.triangles));
    }
    void draw() const {
        gl::BindVertexArray(vertex_array.id());
        gl::DrawElements(GL_TRIANGLES, indices, GL_UNSIGNED_INT, nullptr);
    }
};

template <class Work>
double medianMilliseconds(Work work) {
    std::vector<double> times;
    for (int i = 0; i < kRounds; ++i) {
        const auto start = std::clock();
        work();
        times.push_back(1000.0 * double(std::clock() - start) / CLOCKS_PER_SEC);
    }
    std::nth_element(times.begin(), times.begin() + kRounds / 2, times.end());
    return times[kRounds / 2];
}

SunMesh lumpyBall() {
    SunMesh ball = player_test::sunSphere(80);  // 13,041 vertices
    for (Vec3& p : ball.positions)
        p = p * (0.8f + 0.1f * std::sin(7 * p.x) + 0.1f * std::sin(9 * p.y) * std::sin(5 * p.z)) + Vec3{0, 0, 0.8f};
    return ball;
}

// Normals of the vertices, weighted by the areas of the triangles. The seam's two sides differ slightly.
std::vector<Vec3> normalsOf(const SunMesh& mesh) {
    std::vector<Vec3> normals(mesh.positions.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
        const auto at = [&](std::size_t i) { return mesh.positions[mesh.triangles[t + i]]; };
        const Vec3 area = cross(at(1) - at(0), at(2) - at(0));
        for (std::size_t i = 0; i < 3; ++i) normals[mesh.triangles[t + i]] += area;
    }
    for (Vec3& n : normals) n = normalized(n);
    return normals;
}

std::array<float, 16> cameraMatrix() {  // from (0, -4, 2.5) to (0, 0, .5)
    const Vec3 eye{0, -4, 2.5f}, forward = normalized(Vec3{0, 0, 0.5f} - eye);
    const Vec3 right{1, 0, 0}, up = cross(right, forward);
    const float f = 2.2f, near = 0.1f, far = 20;
    const float a = (far + near) / (far - near), b = -2 * far * near / (far - near);
    const auto row = [&](Vec3 v, float s, float w) {
        return std::array<float, 4>{s * v.x, s * v.y, s * v.z, w - s * dot(v, eye)};
    };
    const std::array<std::array<float, 4>, 4> rows{row(right, f * kHeight / kWidth, 0), row(up, f, 0),
                                                   row(forward, a, b), row(forward, 1, 0)};
    std::array<float, 16> out;
    for (std::size_t i = 0; i < 16; ++i) out[i] = rows[i % 4][i / 4];
    return out;
}

void runSunBench(const char* picture) {
    const auto context = createGlContext(GlBackend::kAuto);
    std::printf("%s\n", context->description.c_str());
    const SunMesh ball = lumpyBall();
    SunMesh ground = player_test::sunSquare({0, 0, 1}, 6);
    const std::vector<Vec3> up(4, {0, 0, 1});
    const std::vector<Vec3> normals = normalsOf(ball);
    const BenchMesh meshes[] = {BenchMesh(ball, normals), BenchMesh(ground, up)};
    const GlObject plain = makeProgram(kVertex, fragmentSource("1.0"));
    const GlObject sunny = makeProgram(kVertex, fragmentSource("sunVisibility(0, place, n)"));
    const SunUniforms at = sunUniforms(sunny);
    const OffscreenTarget target(kWidth, kHeight, 1, GL_RGBA8);
    const std::array<float, 16> camera = cameraMatrix();
    SunMapPainter maps;
    const SunCasters casters{{ball}};
    maps.setCasters(casters);

    const auto drawScene = [&](const GlObject& program) {
        target.begin();
        gl::UseProgram(program.id());
        gl::UniformMatrix4fv(gl::GetUniformLocation(program.id(), "clip_from_model"), 1, GL_FALSE, camera.data());
        if (&program == &sunny) maps.bind(at, 0);
        for (const BenchMesh& mesh : meshes) mesh.draw();
        gl::Finish();
    };
    SunMap map;
    for (const double degrees : {0.0, 0.27, 1.0, 5.0}) {
        const Vec3 direction{0.48f, 0.36f, 0.8f};
        const SunNest nests[] = {player_test::sunNestOf(casters, direction, float(degrees * kRadians))};
        const double fit = medianMilliseconds([&] { player_test::sunNestOf(casters, direction, 0.01f); });
        const double cpu = medianMilliseconds([&] {
            map.begin(nests[0].maps[0].frame);
            map.draw(casters.members);
        });
        const double vertices = medianMilliseconds([&] {
            for (std::size_t i = 0; i < ball.positions.size(); ++i) map.visibility(ball.positions[i], normals[i]);
        });
        const double draw = medianMilliseconds([&] {
            maps.draw(nests, casters);
            gl::Finish();
        });
        drawScene(plain), drawScene(sunny);
        const double without = medianMilliseconds([&] { drawScene(plain); });
        const double with = medianMilliseconds([&] { drawScene(sunny); });
        std::printf(
            "radius %4.2f deg, ms: fit %.2f, map on the CPU %.1f, 13k lookups there %.1f, map in GL %.1f, "
            "picture %.1f, without the sun %.1f, ratio %.2f\n",
            degrees, fit, cpu, vertices, draw, with, without, (draw + with) / without);
        if (picture) writeImage(std::string(picture) + std::to_string(int(100 * degrees)) + ".png", target.read(), 1);
    }
}

}  // namespace
}  // namespace penumbra

int main(int argc, char** argv) { penumbra::runSunBench(argc > 1 ? argv[1] : nullptr); }
