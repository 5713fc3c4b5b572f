// The part of penumbra.h that reports errors, opens an asset and tells what is in it.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>

#include "formats/asset/other_sides.h"
#include "runtime/capi/capi_handles.h"
#include "runtime/evaluate/deformation.h"

namespace penumbra {

penumbra_status report(penumbra_error* error, penumbra_status status, const char* message) noexcept {
    if (error) {
        error->status = status;
        std::snprintf(error->message, sizeof error->message, "%s", message);
    }
    return status;
}

void requirePointer(const void* pointer, const char* name) {
    if (!pointer) throw UsageError(std::string(name) + " is NULL");
}

void requireIndex(const char* what, std::size_t index, std::size_t limit) {
    if (index >= limit)
        throw UsageError(std::string(what) + " is " + std::to_string(index) + "; there are " + std::to_string(limit));
}

void requireRange(const char* what, std::size_t first, std::size_t count, std::size_t limit) {
    if (first > limit || count > limit - first)
        throw UsageError(std::to_string(count) + " " + what + " from " + std::to_string(first) + " on; there are " +
                         std::to_string(limit));
}

void requireCount(const char* name, std::size_t count, std::size_t size) {
    if (count > std::size_t(PTRDIFF_MAX) / size)
        throw UsageError(std::string(name) + " is " + std::to_string(count) + ", more than memory can hold");
}

Vec3 pointFrom(const char* name, const float* place) {
    requirePointer(place, name);
    requireFinite(name, {place, 3});
    return {place[0], place[1], place[2]};
}

void requireFinite(const char* name, std::span<const float> numbers) {
    for (std::size_t i = 0; i < numbers.size(); ++i)
        if (!std::isfinite(numbers[i]))
            throw UsageError(std::string(name) + "[" + std::to_string(i) + "] is not finite");
}

// Nothing moves, and morph targets have their weights at rest.
static std::vector<Affine> restBones(const AssetView& view) {
    std::vector<Affine> bones(view.animation.jointCount());
    const MorphsView& morphs = view.mesh.morphs;
    std::vector<float> inputs(view.animation.input_names.size());
    std::copy(morphs.rest_weights.begin(), morphs.rest_weights.end(), inputs.end() - std::ptrdiff_t(morphs.count()));
    for (const InputJointView& input : view.model.input_joints)
        if (input.column + morphs.count() >= inputs.size())
            bones[std::size_t(input.joint)] = inputBone(view, input, inputs);
    return bones;
}

Evaluator AssetData::restPose() const {
    // The first caller makes the pose. Callers on other threads wait for it and then copy it.
    const std::lock_guard lock(mutex_);
    if (!rest_) {
        const bool angles = view.model.features == FeatureKind::kJointAngles;
        const std::vector<float> no_rotation(angles ? view.animation.pose_size : 0);
        Evaluator evaluator(view);
        if (const Deformation* deformation = evaluator.deformation())
            evaluator.setPositions(deformation->rest(), deformation->restInputs());
        else
            evaluator.setPose(restBones(view), no_rotation);
        rest_ = std::move(evaluator);
        transfer_.emplace(view.model.convention);
    }
    return *rest_;
}

namespace {

constexpr std::size_t kMaxAssetBytes = std::size_t(1) << 31;  // no FlatBuffers buffer is larger

// Finds for every shading point of a deforming mesh its vertex and its first source vertex. The loop over source
// vertices goes backwards, so that the first one stays.
void findPoints(AssetData& data) {
    const MeshView& mesh = data.view.mesh;
    data.vertex_of_point.resize(mesh.pointCount());
    for (std::size_t v = 0; v < mesh.positions.size(); ++v)
        if (!mesh.isBack(v)) data.vertex_of_point[mesh.shading_point[v]] = std::uint32_t(v);
    data.source_of_point.resize(mesh.pointCount(), AssetData::kNoSource);
    for (std::size_t r = mesh.source_vertex.size(); r-- > 0;)
        data.source_of_point[mesh.pointOf(mesh.source_vertex[r])] = std::uint32_t(r);
}

// Checks `data`, whose bytes are in place, and hands it out as a handle.
void finishOpening(const std::shared_ptr<AssetData>& data, std::span<const std::byte> bytes, const std::string& name,
                   penumbra_asset** asset) {
    data->view = openAsset(bytes, name);
    if (data->view.has_model) data->convention = data->view.model.convention.name();
    if (data->view.transfer) data->convention = "T" + std::to_string(data->view.transfer->order);
    if (data->view.model.deforming) findPoints(*data);
    *asset = new penumbra_asset{data};
}

void fillMesh(const MeshView& mesh, penumbra_asset_info& info) {
    const auto floats = [](std::span<const Vec3> v) { return v.empty() ? nullptr : &v.data()->x; };
    info.vertex_count = mesh.positions.size();
    info.source_vertex_count = mesh.source_vertex.size();
    info.triangle_count = mesh.triangles.size() / 3;
    info.rest_positions = floats(mesh.positions);
    info.rest_normals = floats(mesh.normals);
    info.rest_tangents = floats(mesh.tangents);
    info.triangles = mesh.triangles.data();
    info.source_vertex = mesh.source_vertex.data();
    info.influence_count = std::size_t(mesh.influences);
    info.skin_joints = mesh.skin_joints.data();
    info.skin_weights = mesh.skin_weights.data();
    info.slot_count = mesh.slots.size();
    info.slot_of_vertex = mesh.slot_of_vertex.data();
}

void fillJoints(const AnimationView& animation, penumbra_asset_info& info) {
    info.joint_count = animation.jointCount();
    info.joint_parents = animation.parents.data();
    if (!hasRestTransforms(animation)) return;
    info.rest_transforms = animation.rest_transforms.data()->m.data();
    info.inverse_bind = animation.inverse_bind.data()->m.data();
}

void fillModel(const ModelView& model, const AnimationView& animation, penumbra_asset_info& info) {
    if (model.features == FeatureKind::kJointAngles) info.rotation_count = animation.pose_size;
    info.coefficient_count = std::size_t(model.convention.size());
    info.stride = std::size_t(model.stride);
    info.cluster_count = model.clusters.size();
    for (const ClusterView& cluster : model.clusters) info.score_count += cluster.components();
    info.quantization_error = model.quantization_error;
}

const AssetView* viewOf(const penumbra_asset* asset) { return asset ? &asset->data->view : nullptr; }

// Finds a name in a list. Names in the asset are followed by a zero: FlatBuffers writes one and its verifier checks
// it.
template <class Named>
std::size_t findName(const std::vector<Named>& list, const char* name) {
    if (!name) return PENUMBRA_NONE;
    for (std::size_t i = 0; i < list.size(); ++i) {
        if constexpr (std::is_same_v<Named, std::string_view>) {
            if (list[i] == name) return i;
        } else {
            if (list[i].name == name) return i;
        }
    }
    return PENUMBRA_NONE;
}

}  // namespace

}  // namespace penumbra

using namespace penumbra;

const char* penumbra_version(void) { return PENUMBRA_VERSION; }

int penumbra_asset_format_version(void) { return kAssetFormat.version; }

const char* penumbra_status_name(penumbra_status status) {
    switch (status) {
        case PENUMBRA_OK:
            return "PENUMBRA_OK";
        case PENUMBRA_INVALID_ARGUMENT:
            return "PENUMBRA_INVALID_ARGUMENT";
        case PENUMBRA_IO_ERROR:
            return "PENUMBRA_IO_ERROR";
        case PENUMBRA_INVALID_ASSET:
            return "PENUMBRA_INVALID_ASSET";
        case PENUMBRA_FAILED:
            return "PENUMBRA_FAILED";
        case PENUMBRA_UNSUPPORTED:
            return "PENUMBRA_UNSUPPORTED";
        case PENUMBRA_OUT_OF_MEMORY:
            return "PENUMBRA_OUT_OF_MEMORY";
        case PENUMBRA_STATUS_WIDE:
            break;
    }
    return "unknown status";
}

int penumbra_has_simd(penumbra_simd simd) {
    int known = 0;
    guarded(nullptr, [&] {
        pathOf(simd, evaluatorPaths());
        known = 1;
    });
    return known;
}

penumbra_status penumbra_asset_open_file(const char* path, penumbra_asset** asset, penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(asset, "asset", path, "path");
        const auto data = std::make_shared<AssetData>();
        data->file.emplace(path);
        finishOpening(data, data->file->bytes(), path, asset);
    });
}

penumbra_status penumbra_asset_open_memory(const void* bytes, size_t size, penumbra_ownership ownership,
                                           penumbra_asset** asset, penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(asset, "asset", bytes, "bytes");
        if (ownership != PENUMBRA_BORROW && ownership != PENUMBRA_COPY)
            throw UsageError("ownership must be PENUMBRA_BORROW or PENUMBRA_COPY");
        if (ownership == PENUMBRA_BORROW && reinterpret_cast<std::uintptr_t>(bytes) % 16 != 0)
            throw UsageError("bytes to be read in place must begin at a multiple of 16");
        if (size > kMaxAssetBytes)
            throw InvalidInput("asset: " + std::to_string(size) + " bytes are more than an asset can have");
        const auto data = std::make_shared<AssetData>();
        const auto* begin = static_cast<const std::byte*>(bytes);
        if (ownership == PENUMBRA_COPY) {
            static_assert(alignof(std::max_align_t) >= 16);
            data->copy.reset(static_cast<std::byte*>(std::malloc(size ? size : 1)));
            if (!data->copy) throw std::bad_alloc();
            std::memcpy(data->copy.get(), bytes, size);
            begin = data->copy.get();
        }
        finishOpening(data, {begin, size}, "asset", asset);
    });
}

void penumbra_asset_close(penumbra_asset* asset) { delete asset; }

penumbra_status penumbra_asset_get_info(const penumbra_asset* asset, penumbra_asset_info* info) {
    if (!asset || !info) return PENUMBRA_INVALID_ARGUMENT;
    const AssetView& view = asset->data->view;
    *info = {};
    info->has_model = view.hasCharacter();
    info->deforming = view.model.deforming;
    info->two_sided = view.mesh.two_sided ? 1 : view.mesh.cull_backs ? 2 : 0;
    info->has_playback = view.model.deforming && !view.animation.playback.positions.empty();
    info->input_count = view.animation.input_names.size();
    info->provenance = view.provenance.data();
    if (view.has_mesh) fillMesh(view.mesh, *info);
    fillJoints(view.animation, *info);
    info->clip_count = view.animation.clips.size();
    info->frame_count = view.animation.frameCount();
    if (view.hasCharacter()) {
        fillModel(view.model, view.animation, *info);
        info->convention = asset->data->convention.c_str();
    }
    info->material_count = view.materials.size();
    info->light_count = view.lights.size();
    return PENUMBRA_OK;
}

const char* penumbra_asset_joint_name(const penumbra_asset* asset, size_t joint) {
    const AssetView* view = viewOf(asset);
    return view && joint < view->animation.jointCount() ? view->animation.joint_names[joint].data() : nullptr;
}

const char* penumbra_asset_slot_name(const penumbra_asset* asset, size_t slot) {
    const AssetView* view = viewOf(asset);
    return view && slot < view->mesh.slots.size() ? view->mesh.slots[slot].data() : nullptr;
}

int penumbra_asset_slot_surface(const penumbra_asset* asset, size_t slot, penumbra_slot_surface* surface) {
    const AssetView* view = viewOf(asset);
    if (!view || !surface || !view->surface || slot >= view->surface->slots.size()) return 0;
    const SlotSurface& look = view->surface->slots[slot];
    *surface = {};
    for (int c = 0; c < 3; ++c) {
        surface->base[c] = look.base[c];
        surface->emissive[c] = look.emissive[c];
        surface->f0[c] = look.f0[c];
    }
    surface->f90 = look.f90;
    surface->metallic = look.metallic;
    surface->roughness = look.roughness;
    surface->normal_scale = look.normal_scale;
    surface->occlusion_strength = look.occlusion_strength;
    surface->alpha = look.alpha;
    surface->alpha_cutoff = look.alpha_cutoff;
    surface->diffuse = look.materials.diffuse;
    surface->steps = look.materials.steps;
    for (std::size_t s = 0; s < look.materials.steps; ++s) {
        surface->step_roughness[s] = look.materials.roughness[s];
        surface->step_f0[s] = look.materials.f0[s];
        surface->step_f90[s] = look.materials.f90[s];
    }
    return 1;
}

const char* penumbra_asset_input_name(const penumbra_asset* asset, size_t input) {
    const AssetView* view = viewOf(asset);
    return view && input < view->animation.input_names.size() ? view->animation.input_names[input].data() : nullptr;
}

size_t penumbra_asset_morph_count(const penumbra_asset* asset, float* weights) {
    if (!asset) return 0;
    const std::span<const float> rest = viewOf(asset)->mesh.morphs.rest_weights;
    if (weights) std::copy(rest.begin(), rest.end(), weights);
    return rest.size();
}

size_t penumbra_asset_find_input(const penumbra_asset* asset, const char* name) {
    return asset ? findName(viewOf(asset)->animation.input_names, name) : PENUMBRA_NONE;
}

size_t penumbra_asset_find_joint(const penumbra_asset* asset, const char* name) {
    return asset ? findName(viewOf(asset)->animation.joint_names, name) : PENUMBRA_NONE;
}

size_t penumbra_asset_find_slot(const penumbra_asset* asset, const char* name) {
    return asset ? findName(viewOf(asset)->mesh.slots, name) : PENUMBRA_NONE;
}

size_t penumbra_asset_find_clip(const penumbra_asset* asset, const char* name) {
    return asset ? findName(viewOf(asset)->animation.clips, name) : PENUMBRA_NONE;
}

size_t penumbra_asset_find_material(const penumbra_asset* asset, const char* name) {
    return asset ? findName(viewOf(asset)->materials, name) : PENUMBRA_NONE;
}

size_t penumbra_asset_find_light(const penumbra_asset* asset, const char* name) {
    return asset ? findName(viewOf(asset)->lights, name) : PENUMBRA_NONE;
}

penumbra_status penumbra_asset_get_clip(const penumbra_asset* asset, size_t clip, penumbra_clip* out) {
    if (!asset || !out || clip >= viewOf(asset)->animation.clips.size()) return PENUMBRA_INVALID_ARGUMENT;
    const ClipView& stored = viewOf(asset)->animation.clips[clip];
    *out = {stored.name.data(), stored.first_frame, stored.frame_count, stored.held_out};
    return PENUMBRA_OK;
}

penumbra_status penumbra_asset_get_frame(const penumbra_asset* asset, size_t frame, penumbra_frame* out) {
    if (!asset || !out || frame >= viewOf(asset)->animation.frameCount()) return PENUMBRA_INVALID_ARGUMENT;
    const AnimationView& animation = viewOf(asset)->animation;
    const std::span<const Affine> bones = animation.bonesOf(frame);
    *out = {animation.times[frame], bones.empty() ? nullptr : bones.data()->m.data(), animation.poseOf(frame).data(),
            animation.input_names.empty() ? nullptr : animation.inputsOf(frame).data()};
    return PENUMBRA_OK;
}

size_t penumbra_asset_frame_at(const penumbra_asset* asset, size_t clip, double seconds) {
    if (!asset || clip >= viewOf(asset)->animation.clips.size()) return PENUMBRA_NONE;
    const AnimationView& animation = viewOf(asset)->animation;
    const ClipView& range = animation.clips[clip];
    if (range.frame_count == 0 || std::isnan(seconds)) return PENUMBRA_NONE;
    const std::span<const double> times = animation.times.subspan(range.first_frame, range.frame_count);
    const auto after = std::upper_bound(times.begin(), times.end(), seconds) - times.begin();
    return range.first_frame + std::size_t(std::max<std::ptrdiff_t>(after - 1, 0));
}

penumbra_status penumbra_asset_get_other_sides(const penumbra_asset* asset, uint32_t* vertices, penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(asset, "asset", vertices, "vertices");
        const AssetView& view = asset->data->view;
        if (!view.mesh.two_sided) throw Unsupported(view.name + ": its mesh is not two-sided");
        std::ranges::copy(otherSides(view.mesh), vertices);
    });
}

penumbra_status penumbra_asset_get_material(const penumbra_asset* asset, size_t material, penumbra_material* out) {
    if (!asset || !out || material >= viewOf(asset)->materials.size()) return PENUMBRA_INVALID_ARGUMENT;
    const MaterialView& m = viewOf(asset)->materials[material];
    *out = {m.name.data(),   m.slice_order,     m.view_order,  m.channels, {m.color.x, m.color.y, m.color.z},
            m.slices.data(), m.operators.count, m.lobes.size()};
    return PENUMBRA_OK;
}

penumbra_status penumbra_asset_get_lobe(const penumbra_asset* asset, size_t material, size_t lobe, penumbra_lobe* out) {
    if (!asset || !out || material >= viewOf(asset)->materials.size()) return PENUMBRA_INVALID_ARGUMENT;
    const std::span<const BrdfLobe> lobes = viewOf(asset)->materials[material].lobes;
    if (lobe >= lobes.size()) return PENUMBRA_INVALID_ARGUMENT;
    const BrdfLobe& l = lobes[lobe];
    const auto& p = l.parameters;
    *out = {int(l.model), {p[0], p[1], p[2], p[3]}, {l.color.x, l.color.y, l.color.z}};
    return PENUMBRA_OK;
}

penumbra_status penumbra_asset_get_emission(const penumbra_asset* asset, size_t material, float* out) {
    if (!asset || !out || material >= viewOf(asset)->materials.size()) return PENUMBRA_INVALID_ARGUMENT;
    const Vec3 emission = viewOf(asset)->materials[material].emission;
    for (int c = 0; c < 3; ++c) out[c] = emission[c];
    return PENUMBRA_OK;
}

penumbra_status penumbra_asset_get_light(const penumbra_asset* asset, size_t light, penumbra_light* out) {
    if (!asset || !out || light >= viewOf(asset)->lights.size()) return PENUMBRA_INVALID_ARGUMENT;
    const LightView& l = viewOf(asset)->lights[light];
    *out = {l.name.data(), l.order, l.sh.data(), int(l.lobes.directions.size()), int(l.suns.size())};
    return PENUMBRA_OK;
}

penumbra_status penumbra_asset_get_followers(const penumbra_asset* asset, penumbra_followers* out) {
    if (!asset || !out) return PENUMBRA_INVALID_ARGUMENT;
    const MeshView& mesh = viewOf(asset)->mesh;
    *out = {mesh.firstFollower(), mesh.follower_corners.size(),
            mesh.follower_corners.empty() ? nullptr : mesh.follower_corners.front().data(),
            mesh.follower_weights.empty() ? nullptr : mesh.follower_weights.front().data()};
    return PENUMBRA_OK;
}

penumbra_status penumbra_asset_get_cluster(const penumbra_asset* asset, size_t cluster, penumbra_cluster* out) {
    if (!asset || !out || cluster >= viewOf(asset)->model.clusters.size()) return PENUMBRA_INVALID_ARGUMENT;
    const std::vector<ClusterView>& clusters = viewOf(asset)->model.clusters;
    const ClusterView& c = clusters[cluster];
    std::size_t first_score = 0;
    for (std::size_t before = 0; before < cluster; ++before) first_score += clusters[before].components();
    *out = {std::size_t(c.joint),
            c.first_vertex,
            c.vertex_count,
            c.components(),
            first_score,
            penumbra_precision(c.mean.precision),
            penumbra_precision(c.basis.precision),
            c.mean.data,
            c.basis.data,
            c.basis.scale.empty() ? nullptr : c.basis.scale.data()};
    return PENUMBRA_OK;
}
