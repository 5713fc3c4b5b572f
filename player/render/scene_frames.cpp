#include "player/render/scene_frames.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "formats/common/errors.h"
#include "formats/common/parallel_for.h"
#include "formats/scene/scene_placement.h"
#include "player/frame/framed_rest.h"
#include "player/frame/mirror_sight.h"
#include "player/frame/truth_frames.h"
#include "player/papers/sphere_cast.h"
#include "player/scene/scene_suns.h"
#include "sh/bounding_box.h"

namespace penumbra {

SceneFrames::SceneFrames(const PosedScene& scene, const RenderOptions& options, int threads, const AssetView* truth)
    : scene_(scene), options_(options), threads_(threads) {
    requireLight(scene, options.channel);
    for (const std::unique_ptr<SceneMember>& member : scene.members())
        looks_.push_back(std::make_unique<SceneLook>(scene, *member, options));
    members_.resize(looks_.size());
    sight_.resize(looks_.size());
    values_.resize(looks_.size() + (scene.file().ground ? 1 : 0));
    if (compares()) casts_.resize(values_.size());
    if (truth) attachTruth(*truth);
    hidden_.resize(looks_.size());
    sent_.resize(looks_.size());
    for (const std::unique_ptr<SceneLook>& look : looks_)
        shining_vertices_.push_back(shiningVertices(look->view.mesh.positions.size(), look->view.mesh.slot_of_vertex));
    if (scene.light()) whole_light_ = *scene.light();
    sunlight_ = sceneSunlight(scene, looks_);
    if (scene.field()) makeField();
    if (!scene.file().ground || scene.field()) return;
    ground_ = groundMesh(*scene.file().ground);
    if (sunlight_.suns.empty()) return;
    const auto side = std::size_t(scene.file().ground->resolution);
    ground_lobes_.assign(side * side, sunlight_.ground);
}

void SceneFrames::makeField() {
    const SceneField& field = *scene_.field();
    field_triangles_ = fieldTriangles(field.heights().field().grid());
    if (options_.channel != Channel::kShaded) return;
    field_look_.emplace(*scene_.file().ground, field.convention(), scene_.lightAsset(), sunlight_.light);
    field_look_->turnLight(lightRotation());
    if (sunlight_.suns.empty()) return;
    field_casting_triangles_ = castingTriangles(field.heights().field().grid());
    sunlight_.ground = sunlight_.lobes.add(fieldLobes(*scene_.file().ground, scene_.lightAsset()));
    ground_lobes_.assign(field.heights().field().grid().size(), sunlight_.ground);
}

void SceneFrames::replaceLight(const LightView& light) {
    const bool shines = !scene_.light()->suns.empty() && !sunlight_.remainder.empty();
    for (const std::unique_ptr<SceneLook>& look : looks_)
        if (look->shading) look->shading->replaceLight(look->shot.light, light);
    sunlight_.light = whole_light_ = light;
    if (!shines) return;
    sunlight_.suns = sunsOf(light, sunlight_.light_rotation);
    sunlight_.remainder = remainderOf(light);
    sunlight_.light.sh = sunlight_.remainder;
}

SunCasters SceneFrames::sunCasters() const {
    SunCasters casters;
    for (std::size_t m = 0; m < members_.size(); ++m)
        if (castsInSuns(*scene_.members()[m]->file))
            casters.members.push_back({members_[m].positions, looks_[m]->view.mesh.castingTriangles()});
    addRealMeshes(scene_, casters);
    if (scene_.field()) {
        casters.ground = {field_casting_, field_casting_triangles_};
        casters.ground_version = scene_.field()->version();
    }
    return casters;
}

void SceneFrames::attachTruth(const AssetView& truth) {
    std::string problem;
    bool fits = false;
    for (const std::unique_ptr<SceneLook>& look : looks_) try {
            checkTruth(look->view, truth);
            look->shot.truth = &truth;
            fits = true;
        } catch (const InvalidInput& error) {
            problem = error.what();
        }
    if (!fits) throw InvalidInput(problem);
}

namespace {

CastReceivers receiversOf(const auto& vertices) { return {vertices.positions, vertices.normals, vertices.tangents}; }

}  // namespace

void SceneFrames::evaluateMembers() {
    for (std::size_t m = 0; m < members_.size(); ++m) {
        if (!compares()) {
            memberVertices(scene_, m, threads_, members_[m], receives() ? &hidden_[m] : nullptr);
            continue;
        }
        ownVertices(*scene_.members()[m], threads_, members_[m]);
        castOverSphere(scene_.cast(), {.except = scene_.members()[m]->caster}, castOrderOf(scene_.castWay().mode),
                       receiversOf(members_[m]), threads_, casts_[m]);
    }
    if (receives() && scene_.groundCasts()) castOnGlow();
}

bool SceneFrames::receives() const {
    return options_.channel == Channel::kShaded && options_.bounces != Bounces::kDirect && !compares();
}

void SceneFrames::castOnGlow() {
    standing_.clear();
    for (const FrameVertices& member : members_) {
        const BoundingBox box = boundsOf(member.positions);
        standing_.insert(standing_.end(), {box.low, box.high});
    }
    glow_.cast(scene_.cast(), scene_.file().ground->height, standing_, threads_);
}

void SceneFrames::evaluateGround() {
    if (!scene_.file().ground) return;
    if (!scene_.field() && scene_.file().ground->catcher) return;  // nobody looks at it
    if (scene_.field()) {
        scene_.field()->update(scene_.cast(), FieldPoints::kNew, threads_, field_);
        if (!suns().empty()) scene_.field()->heights().castingPoints(field_casting_);
        return;
    }
    if (!compares()) {
        castOnGround(scene_.cast(), threads_, ground_);
        return;
    }
    castOverSphere(scene_.cast(), {}, castOrderOf(scene_.castWay().mode), receiversOf(ground_), threads_,
                   casts_.back());
}

namespace {

// Returns the length of the ground's longer side, in metres.
double groundSize(const PosedScene& scene) {
    if (!scene.field()) return scene.file().ground ? scene.file().ground->size : 0;
    const HeightGrid& grid = scene.field()->heights().field().grid();
    return std::max(double(grid.cell_x) * grid.rows, double(grid.cell_y) * grid.columns);
}

// The camera of the scene's first photograph without its lens, as large as the picture that is wanted. Its middle
// stays in the middle.
SceneView sceneViewOf(const PosedScene& scene, const RenderOptions& options) {
    SceneView view = SceneCameras(scene.file()).view(0, scene.file().origin);
    PinholeCamera& camera = view.camera;
    const double scale = std::min(double(options.width) / camera.width, double(options.height) / camera.height);
    camera = {camera.f * scale, (camera.cx - 0.5 * (camera.width - 1)) * scale + 0.5 * (options.width - 1),
              (camera.cy - 0.5 * (camera.height - 1)) * scale + 0.5 * (options.height - 1), options.width,
              options.height};
    return view;
}

}  // namespace

void clipFromPhotograph(const SceneView& view, std::span<const BoundingBox> boxes, double reach,
                        std::span<float, 16> out) {
    double near = std::numeric_limits<double>::infinity(), far = reach;
    for (const BoundingBox& box : boxes) {
        const double away = view.inCamera(toDouble(box.low + box.high) * 0.5).z, radius = box.radius();
        near = std::min(near, away - radius);
        far = std::max(far, away + radius + reach);
    }
    clipFromScene(view, std::clamp(near, 1e-3 * far, 0.5 * far), far, out);
}

FrameView sceneView(const PosedScene& scene, const RenderOptions& options, std::span<const FrameVertices> members) {
    std::vector<Vec3> corners;
    std::vector<BoundingBox> boxes;
    for (std::size_t m = 0; m < members.size(); ++m) {
        const BoundingBox box = boxes.emplace_back(framedBox(scene.members()[m]->asset->view, members[m].positions));
        corners.insert(corners.end(), {box.low, box.high});
    }
    const double radius = std::max<double>(boundsOf(corners).radius(), 1e-3);
    const double reach = std::max(radius, groundSize(scene));
    FrameView view;
    if (scene.file().photograph && options.camera.empty()) {
        const SceneView of_scene = sceneViewOf(scene, options);
        clipFromPhotograph(of_scene, boxes, reach, view.clip_from_model);
        view.eye = toFloat(of_scene.eye());
        return view;
    }
    const Camera camera = cameraOf(scene.file(), options.camera, corners);
    clipFromModel(camera, double(options.width) / options.height, reach, view.clip_from_model);
    view.eye = toFloat(cameraPosition(camera));
    return view;
}

Channel SceneFrames::channelOf(std::size_t m) const {
    if (options_.channel != Channel::kError) return options_.channel;
    const SceneLook& look = *looks_[m];
    const bool has = look.shot.truth && findTruthFrame(look.view, *look.shot.truth, scene_.members()[m]->frame);
    return has ? Channel::kError : Channel::kAmbient;
}

// The member with numbers of its truth, past the same casters as those of its model.
FrameVertices SceneFrames::trueMember(std::size_t m) const {
    const SceneMember& member = *scene_.members()[m];
    Shot shot = looks_[m]->shot;
    shot.truth_frame = *findTruthFrame(looks_[m]->view, *shot.truth, member.frame);
    FrameVertices in_model, truth = members_[m];
    skinFrame(member.evaluator, threads_, in_model);  // moments are in the frame of the model
    truth.coefficients = truthCoefficients(shot, in_model, threads_);
    truth.indirect.clear();
    if (!compares()) castOthers(scene_, member, threads_, truth);
    return truth;
}

std::vector<float> SceneFrames::memberAmbient(std::size_t m, const FrameVertices& vertices) const {
    if (!compares()) return ambientOf(looks_[m]->shot, vertices.coefficients, threads_);
    return castAmbient(scene_.castWay().mode, looks_[m]->view.model, vertices, casts_[m]);
}

void SceneFrames::findMemberValues(std::size_t m) {
    SceneLook& look = *looks_[m];
    std::vector<Vec3>& values = values_[m];
    if (options_.channel != Channel::kShaded) {
        values.clear();
        std::vector<float> ambient = memberAmbient(m, members_[m]);
        if (options_.channel == Channel::kBouncedAmbient)
            addBouncedAmbient(look.view.model.indirect->axes, members_[m].indirect, ambient);
        for (const float e : ambient) values.push_back({e, 0, 0});
        if (channelOf(m) != Channel::kError) return;
        const std::vector<float> truth = memberAmbient(m, trueMember(m));
        for (std::size_t v = 0; v < truth.size(); ++v) values[v].x = std::abs(values[v].x - truth[v]);
        return;
    }
    if (compares())
        look.cast_shader->shade(members_[m], casts_[m], view_.eye, threads_, values);
    else
        shadeFrame(*look.shading, members_[m], view_.eye, threads_, values);
    if (!suns().empty())
        sight_[m] = takeMirrorsOut(look.view.model.convention, look.view.model.stride, members_[m], view_.eye, threads_,
                                   sunlight_.lobes, look.lobes, values);
}

void SceneFrames::findGroundValues() {
    const bool shaded = options_.channel == Channel::kShaded;
    std::vector<Vec3>& values = values_.back();
    if (field_look_) {
        field_look_->shade(field_, view_.eye, threads_, values);
        if (!suns().empty())
            field_sight_ = takeMirrorsOut(scene_.field()->convention(), kFieldStride, field_, view_.eye, threads_,
                                          sunlight_.lobes, ground_lobes_, values);
        return;
    }
    if (compares()) {
        values = groundInMode(scene_.castWay().mode, casts_.back(), shaded ? scene_.light() : nullptr,
                              scene_.lightRotation(), scene_.file().ground->albedo);
        return;
    }
    if (shaded) {
        const Vec3 albedo = scene_.file().ground->albedo;
        groundRadiance(ground_, {sunlight_.light, scene_.lightRotation(), albedo}, threads_, values);
        if (receives() && scene_.groundCasts()) addMembersLight(ground_, shining_, albedo, threads_, values);
        return;
    }
    values.clear();
    for (const float e : scene_.field() ? fieldAmbient(scene_.field()->convention(), field_) : groundAmbient(ground_))
        values.push_back({e, 0, 0});
}

void SceneFrames::frameCamera() {
    view_ = sceneView(scene_, options_, members_);
    view_.error_max = options_.error_max;
}

void SceneFrames::shade() {
    shadeMembers();
    if (scene_.file().ground && (scene_.field() || !scene_.file().ground->catcher)) findGroundValues();
}

void SceneFrames::shadeMembers() {
    const bool glows = receives() && scene_.groundCasts();
    if (glows) glow_.light(whole_light_, scene_.lightRotation(), scene_.file().ground->albedo);
    for (std::size_t m = 0; m < members_.size(); ++m) {
        members_[m].received.clear();
        if (!looks_[m]->drawn) continue;
        if (glows) receiveFromGround(glow_, hidden_[m], threads_, members_[m]);
    }
    if (receives()) receiveFromMembers();
    for (std::size_t m = 0; m < members_.size(); ++m)
        if (looks_[m]->drawn) findMemberValues(m);
}

// Finds what members send to others: what they show under the whole light, but for that of others.
void SceneFrames::findShining() {
    shines_ = true;
    shining_.resize(members_.size());
    parallelFor(members_.size(), threads_, [&](std::size_t m) {
        SceneLook& look = *looks_[m];
        if (!look.drawn) return;
        if (!suns().empty()) look.shading->setSuns(false);
        shadeSome(*look.shading, shining_vertices_[m], members_[m], view_.eye, sent_[m]);
        if (!suns().empty()) look.shading->setSuns(true);
        shiningMember(members_[m], look.view.mesh.triangles, sent_[m], shining_[m]);
    });
}

SentLight SceneFrames::sentLight() {
    if (!receives()) return {};
    if (!shines_) findShining();
    return {scene_.groundCasts() ? &glow_ : nullptr, shining_};
}

void SceneFrames::receiveFromMembers() {
    const auto wants = [&](std::size_t m) { return looks_[m]->drawn && hidden_[m].fromOthers(); };
    receivers_.clear();
    for (std::size_t m = 0; m < members_.size(); ++m)
        if (wants(m)) receivers_.push_back(m);
    shines_ = false;
    const bool ground = scene_.groundCasts() && !scene_.file().ground->catcher;
    if (receivers_.empty() && !ground) return;
    findShining();
    parallelFor(receivers_.size(), threads_, [&](std::size_t n) {
        const std::size_t m = receivers_[n];
        members_[m].received.resize(members_[m].positions.size());
        receiveFromOthers(scene_.members()[m]->evaluator, m, shining_, hidden_[m], members_[m]);
    });
}

std::vector<SceneMesh> SceneFrames::meshes() const {
    std::vector<SceneMesh> out;
    for (std::size_t m = 0; m < members_.size(); ++m) {
        if (!looks_[m]->drawn) continue;
        out.push_back({looks_[m]->view.mesh.triangles,
                       members_[m].positions,
                       values_[m],
                       looks_[m]->view.mesh.cull_backs ? Sides::kFront : Sides::kBoth,
                       channelOf(m),
                       {members_[m].normals, members_[m].tangents, looks_[m]->lobes, sight_[m]}});
        out.back().mesh = &looks_[m]->view.mesh;
        if (looks_[m]->shading) out.back().shading = &*looks_[m]->shading;
    }
    if (!scene_.file().ground || scene_.file().ground->catcher) return out;
    const Channel of_ground = options_.channel == Channel::kShaded ? Channel::kShaded : Channel::kAmbient;
    if (scene_.field())
        out.push_back({field_triangles_,
                       field_.positions,
                       values_.back(),
                       Sides::kBoth,
                       of_ground,
                       {field_.normals, field_.tangents, ground_lobes_, field_sight_}});
    else
        out.push_back({ground_.shown(),
                       ground_.positions,
                       values_.back(),
                       Sides::kBoth,
                       of_ground,
                       {ground_.normals, ground_.tangents, ground_lobes_},
                       true});
    return out;
}

}  // namespace penumbra
