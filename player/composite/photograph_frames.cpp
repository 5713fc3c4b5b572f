#include "player/composite/photograph_frames.h"

#include <algorithm>
#include <chrono>
#include <future>

#include "formats/common/errors.h"
#include "formats/common/parallel_for.h"
#include "player/composite/characters_drawing.h"
#include "sh/bounding_box.h"

namespace penumbra {

namespace {

class Stopwatch {
public:
    double lap() {
        const auto now = std::chrono::steady_clock::now();
        const double ms = std::chrono::duration<double, std::milli>(now - start_).count();
        start_ = now;
        return ms;
    }

private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

const PosedScene& checked(const PosedScene& scene) {
    const SceneDescription& file = scene.file();
    if (!file.photograph) throw InvalidInput(file.at + ": /camera: must be the camera of a photograph (docs/scene.md)");
    if (!scene.light())
        throw InvalidInput(file.at + ": has no light, so nothing can be lit or shadowed as in the photograph");
    if (file.ground && file.ground->heights)
        throw InvalidInput(file.at + ": /ground/heights: shadows on photographs fall on a level ground alone");
    return scene;
}

RenderOptions shadedOptions(RenderOptions options, const PinholeCamera& camera) {
    options.channel = Channel::kShaded;
    options.width = camera.width;
    options.height = camera.height;
    options.camera.clear();
    return options;
}

}  // namespace

struct PhotographFrames::Drawing {
    CharactersDrawing characters;
    LensResampler lens;
};

PhotographFrames::PhotographFrames(PosedScene& scene, const RenderOptions& options, int threads, bool draws)
    : scene_(scene),
      threads_(threads),
      cameras_(checked(scene).file()),
      frames_(scene, options_ = shadedOptions(options, cameras_.camera()), threads),
      ratio_(cameras_.camera()) {
    std::vector<const Evaluator*> casters;
    std::vector<CasterKind> kinds;
    for (const std::unique_ptr<SceneMember>& member : scene.members()) {
        if (!member->file->real || member->caster == kNobody) continue;
        casters.push_back(&member->evaluator);
        kinds.push_back(*casterKindOf(*member->file, member->evaluator));
    }
    if (!casters.empty()) real_cast_ = std::make_unique<CastShadow>(casters, kinds);
    makeSurfaces();
    draws_ = draws && std::ranges::any_of(scene.members(), [](const auto& m) { return !m->file->real; });
    if (!draws_ && surfaces_.empty()) return;
    LensResampler lens(cameras_.camera());
    drawing_ =
        std::make_unique<Drawing>(Drawing{CharactersDrawing(scene, frames_, options_, lens.plain()), std::move(lens)});
}

void PhotographFrames::makeSurfaces() {
    constexpr double kEdge = 0.05;  // metres of the scene
    std::size_t real = 0;
    for (const std::unique_ptr<SceneMember>& member : scene_.members()) {
        if (!member->file->real) continue;
        RealSurface& surface = surfaces_.emplace_back();
        const std::span<const std::uint32_t> triangles = member->asset->view.mesh.triangles;
        surface.triangles.assign(triangles.begin(), triangles.end());
        surface.caster = member->caster;
        if (member->caster != kNobody) surface.real_caster = real++;
    }
    for (const RealMesh& mesh : scene_.realMeshes()) surfaces_.push_back(surfaceOf(mesh, kEdge));
}

// Takes the vertices of members in the photograph to where they are.
void PhotographFrames::poseSurfaces() {
    std::size_t next = 0;
    for (std::size_t m = 0; m < scene_.members().size(); ++m) {
        if (!scene_.members()[m]->file->real) continue;
        const FrameVertices& from = frames_.members()[m];
        RealSurface& surface = surfaces_[next++];
        surface.positions = from.positions;
        surface.normals = from.normals;
        surface.tangents = from.tangents;
    }
}

// Puts the ratios of surfaces in the place of those of the ground behind them.
void PhotographFrames::addSurfaces(const SceneView& view, std::vector<Vec3>& ratio) {
    const GroundLight light = groundLight();
    for (RealSurface& surface : surfaces_) shadeSurface(scene_, light, frames_.sunlight().light.sh, threads_, surface);
    Image seen;
    drawing_->lens.resample(drawing_->characters.drawRatios(view, surfaces_), threads_, seen);
    for (std::size_t i = 0; i < ratio.size(); ++i) ratio[i] = ratio[i] * (1 - seen.alpha[i]) + seen.pixels[i];
}

PhotographFrames::~PhotographFrames() = default;

bool PhotographFrames::hasReal() const { return !surfaces_.empty(); }

bool PhotographFrames::pose(std::optional<double> seconds) {
    if (is_posed_ && posed_ == seconds) return false;
    if (is_posed_ || seconds) scene_.pose(seconds);
    frames_.evaluateMembers();
    std::size_t real = 0;
    for (const std::unique_ptr<SceneMember>& member : scene_.members())
        if (member->file->real && member->caster != kNobody)
            real_cast_->pose(real++, member->evaluator.bones(), member->to_scene);
    shineSuns();
    poseSurfaces();
    posed_ = seconds;
    is_posed_ = true;
    return true;
}

void PhotographFrames::shineSuns() {
    maps_.resize(frames_.suns().size());
    real_maps_.clear();
    SunCasters real;
    for (std::size_t m = 0; m < scene_.members().size(); ++m)
        if (const SceneMember& member = *scene_.members()[m]; member.file->real && castsInSuns(*member.file))
            real.members.push_back({frames_.members()[m].positions, member.asset->view.mesh.castingTriangles()});
    addRealMeshes(scene_, real);
    for (std::size_t s = 0; s < maps_.size(); ++s) {
        drawSunMaps(frames_.suns()[s], frames_.sunCasters(), options_.sun_map, threads_, maps_[s]);
        if (hasReal()) drawSunMaps(frames_.suns()[s], real, options_.sun_map, threads_, real_maps_.emplace_back());
    }
}

// Adds what the suns give to every vertex of a member: visible E f(omega_i, omega_o) cos.
void PhotographFrames::addSuns(std::size_t member, Vec3 eye) {
    constexpr std::size_t kPiece = 256;
    const FrameVertices& from = frames_.members()[member];
    std::vector<Vec3>& out = sunlit_[member];
    out = frames_.valuesOf(member);
    const std::size_t count = from.positions.size();  // further terms of pictures are drawn with suns
    const std::vector<LobeRange>& lobes = frames_.lookOf(member).lobes;
    const std::span<const BrdfLobe> table = frames_.lobes().lobes();
    if (maps_.empty()) return;
    parallelFor((count + kPiece - 1) / kPiece, threads_, [&](std::size_t piece) {
        for (std::size_t v = piece * kPiece; v < std::min((piece + 1) * kPiece, count); ++v) {
            const Mat3 to_local = toLocalFrame(from.normals[v], from.tangents[v]);
            Vec3 towards = to_local * normalized(eye - from.positions[v]);
            // The ground sees what the eye does not, and silhouettes stay as light as what is beside them.
            towards = normalized(Vec3{towards.x, towards.y, std::max(towards.z, 0.1f)});
            for (std::size_t s = 0; s < maps_.size(); ++s) {
                const Sun& sun = frames_.suns()[s];
                const float cosine = dot(sun.direction, from.normals[v]);
                if (!(cosine > 0)) continue;
                const Vec3 reflected = evalLobes(table.subspan(firstLobe(lobes[v]), lobeCount(lobes[v])),
                                                 to_local * sun.direction, towards);
                out[v] +=
                    reflected * sun.irradiance * (cosine * maps_[s].visibility(from.positions[v], from.normals[v]));
            }
        }
    });
}

// Leaves in the first [V] of what is sunlit what pictures make of its terms.
void PhotographFrames::joinPictures(std::size_t member) {
    const std::optional<ShadingSet>& shading = frames_.lookOf(member).shading;
    if (!shading || !shading->showsSurface()) return;
    if (!pictured_[member]) pictured_[member] = std::make_unique<PicturedLight>(*shading);
    std::vector<Vec3>& values = sunlit_[member];
    pictured_[member]->join(values, values);
    values.resize(frames_.members()[member].positions.size());
}

void PhotographFrames::findEmitters() {
    constexpr float kCells = 15;  // along the diagonal of a character, half of its box
    std::vector<ShiningVertex> vertices;
    float radius = 0;
    for (std::size_t m = 0; m < scene_.members().size(); ++m) {
        if (scene_.members()[m]->file->real || scene_.members()[m]->caster == kNobody) continue;
        joinPictures(m);
        const FrameVertices& from = frames_.members()[m];
        addShining({from.positions, from.normals, frames_.lookOf(m).view.mesh.triangles, sunlit_[m]}, vertices);
        radius = std::max(radius, float(boundsOf(frames_.members()[m].positions).radius()));
    }
    emitters_.clear();
    if (radius > 0) emittersOf(vertices, 2 * radius / kCells, emitters_);
}

GroundLight PhotographFrames::groundLight() const {
    GroundVertices up;
    up.normals = {{0, 1, 0}};
    up.tangents = {{0, 0, 1}};
    return {&scene_.cast(),
            real_cast_.get(),
            groundWeights(up, frames_.sunlight().light, scene_.lightRotation()),
            frames_.suns(),
            maps_,
            real_maps_,
            emitters_};
}

void PhotographFrames::compute(const SceneView& view, std::optional<double> seconds, PhotographFrame& out) {
    Stopwatch watch;
    const bool moved = pose(seconds);
    frames_.shadeFrom(toFloat(view.eye()));
    sunlit_.resize(frames_.members().size());
    pictured_.resize(sunlit_.size());
    for (std::size_t m = 0; m < sunlit_.size(); ++m)
        if (frames_.lookOf(m).drawn) addSuns(m, toFloat(view.eye()));
    cost_.shade = watch.lap();
    if (parts_.bounce) findEmitters();
    cost_.light = watch.lap();
    // The ground is computed beside the drawing: software draws triangles on one core.
    const auto ground = [&] {
        Stopwatch own;
        if (scene_.file().ground && parts_.shadow)
            ratio_.compute(view, scene_.file().ground->height, groundLight(), threads_, out.ratio);
        else
            out.ratio.assign(std::size_t(camera().width) * std::size_t(camera().height), Vec3{1, 1, 1});
        return own.lap();
    };
    std::future<double> beside = std::async(threads_ == 1 ? std::launch::deferred : std::launch::async, ground);
    out.characters = {};
    if (draws_) drawing_->lens.resample(drawing_->characters.draw(view, sunlit_, moved), threads_, out.characters);
    cost_.draw = watch.lap();
    cost_.ground = beside.get();
    if (!surfaces_.empty() && parts_.shadow) addSurfaces(view, out.ratio);
}

}  // namespace penumbra
