#include "player/draw/gl_asset.h"

#include <limits>

#include "formats/common/errors.h"
#include "player/frame/frame_values.h"
#include "runtime/glsl/far_glsl.h"

namespace penumbra {

namespace {

constexpr GLuint kArraysBinding = 0;  // in evaluate.comp

// Collects the asset's arrays, one after another at multiples of 16 bytes, and tells where each begins.
class ArrayList {
public:
    template <class T>
    std::uint32_t place(std::span<const T> array) {  // in words
        return placeBytes(std::as_bytes(array));
    }
    std::uint32_t placeBytes(std::span<const std::byte> array) {
        const std::size_t at = bytes_;
        if (at / 4 > std::numeric_limits<std::uint32_t>::max() / 2) throw Unsupported("an asset too large for a GPU");
        arrays_.push_back({at, array});
        bytes_ += (array.size() + 15) / 16 * 16;
        return std::uint32_t(at / 4);
    }
    std::size_t bytes() const { return bytes_; }
    // Uploads them from where they are, the mapped file, without another copy.
    GlObject upload() const {
        checkStorageBlock("the asset", bytes_);
        GlObject buffer = makeStorage(bytes_);
        for (const auto& [at, array] : arrays_)
            gl::BufferSubData(GL_SHADER_STORAGE_BUFFER, GLintptr(at), GLsizeiptr(array.size()), array.data());
        return buffer;
    }

private:
    std::vector<std::pair<std::size_t, std::span<const std::byte>>> arrays_;
    std::size_t bytes_ = 0;
};

std::uint32_t placeNumbers(ArrayList& arrays, const NumbersView& numbers) {
    return arrays.placeBytes({numbers.data, numbers.count * bytesPerNumber(numbers.precision)});
}

// Returns the clusters that the shader reads: those of the model, then those of the residual.
std::vector<const ClusterView*> clustersOf(const ModelView& model, bool composed) {
    std::vector<const ClusterView*> clusters;
    for (const ClusterView& cluster : model.clusters) clusters.push_back(&cluster);
    if (composed)
        for (const ClusterView& cluster : model.composition->residual) clusters.push_back(&cluster);
    return clusters;
}

// Adds the rows of light that bounces to the table of clusters. Their means are decoded into `means`, which must live
// until the arrays are uploaded.
void addIndirectRows(const IndirectView& indirect, ArrayList& arrays, std::vector<std::vector<float>>& means,
                     std::uint32_t first_score, std::vector<std::uint32_t>& table) {
    for (const ClusterView& cluster : indirect.clusters) {
        std::vector<float>& mean = means.emplace_back(cluster.mean.count);
        decode(cluster.mean, mean);
        const auto components = std::uint32_t(cluster.components());
        table.insert(table.end(), {cluster.first_vertex, cluster.vertex_count, components, first_score,
                                   arrays.place(std::span<const float>(mean)), placeNumbers(arrays, cluster.basis),
                                   std::uint32_t(AssetPrecision::kF32), std::uint32_t(cluster.basis.precision)});
        first_score += components;
    }
}

std::size_t scoreCount(std::span<const ClusterView* const> clusters) {
    std::size_t scores = 0;
    for (const ClusterView* cluster : clusters) scores += cluster->components();
    return scores;
}

std::optional<AssetPrecision> sharedPrecision(std::span<const ClusterView* const> clusters,
                                              NumbersView ClusterView::*array) {
    std::optional<AssetPrecision> shared;
    for (const ClusterView* cluster : clusters) {
        const AssetPrecision precision = (cluster->*array).precision;
        if (shared && *shared != precision) return std::nullopt;
        shared = precision;
    }
    return shared;
}

// Makes the table with kClusterWords for each cluster, and places their arrays.
std::vector<std::uint32_t> clusterTable(std::span<const ClusterView* const> clusters, ArrayList& arrays) {
    std::vector<std::uint32_t> table;
    std::uint32_t first_score = 0;
    for (const ClusterView* const at : clusters) {
        const ClusterView& cluster = *at;
        const auto components = std::uint32_t(cluster.components());
        table.insert(table.end(), {cluster.first_vertex, cluster.vertex_count, components, first_score,
                                   placeNumbers(arrays, cluster.mean), placeNumbers(arrays, cluster.basis),
                                   std::uint32_t(cluster.mean.precision), std::uint32_t(cluster.basis.precision)});
        first_score += components;
    }
    return table;
}

// Places the bytes of the fields, and tells the tables where they are.
void placeFields(const CompositionView& composition, ArrayList& arrays, FarWords& words) {
    for (std::size_t p = 0; p < composition.parts.size(); ++p) {
        const FieldBytes& bytes = composition.parts[p].bytes;
        const std::uint32_t points = arrays.place(bytes.values);
        setFieldWords(words, p, points, arrays.place(bytes.distances));
    }
}

FarPlaces placeTables(const FarWords& words, ArrayList& arrays) {
    FarPlaces places;
    const auto place = [&](const std::vector<std::uint32_t>& table) { return arrays.place(std::span(table)); };
    places.parts = place(words.parts);
    places.lists = place(words.lists);
    places.receivers = place(words.receivers);
    places.anchors = place(words.anchors);
    places.anchor_count = std::uint32_t(words.anchors.size() / 2);
    places.anchor_values = std::uint32_t(words.anchor_values);
    return places;
}

}  // namespace

GlAsset::GlAsset(const AssetView& asset, const ShadingSet* shading, const Evaluator* evaluator) : asset_(&asset) {
    recipe_.convention = asset.model.convention;
    recipe_.stride = asset.model.stride;
    recipe_.influences = asset.mesh.influences;
    recipe_.deforming = asset.model.deforming || !asset.mesh.morphs.empty();
    recipe_.slots = !asset.mesh.slot_of_vertex.empty();
    recipe_.clusters = asset.model.clusters.size();
    uploadArrays(evaluator, shading);
    if (shading) uploadMaterials(*shading);
    recipe_.surface = surfaceShaderOf(shading);
    placePose();
    vertex_array_ = makeVertexArray();
    gl::BindVertexArray(vertex_array_.id());
    triangles_ = makeBuffer(GL_ELEMENT_ARRAY_BUFFER, asset.mesh.triangles);
    bytes_ += asset.mesh.triangles.size_bytes();
    if (recipe_.surface.on) uploadSurface();
    checkGl("uploading the asset");
}

void GlAsset::uploadSurface() {
    constexpr GLuint kDrawnVertex = 0, kPlaces = 6;  // in evaluated.vert
    surface_.emplace(*asset_);
    pictured_array_ = makeVertexArray();
    gl::BindVertexArray(pictured_array_.id());
    gl::BindBuffer(GL_ARRAY_BUFFER, surface_->sources().id());
    gl::VertexAttribIPointer(kDrawnVertex, 1, GL_UNSIGNED_INT, 0, nullptr);
    gl::EnableVertexAttribArray(kDrawnVertex);
    gl::BindBuffer(GL_ARRAY_BUFFER, surface_->places().id());
    gl::VertexAttribPointer(kPlaces, 4, GL_FLOAT, GL_FALSE, 0, nullptr);
    gl::EnableVertexAttribArray(kPlaces);
    pictured_triangles_ = makeBuffer(GL_ELEMENT_ARRAY_BUFFER, surface_->triangles());
    bytes_ += surface_->bytes() + surface_->triangles().size_bytes();
}

std::size_t GlAsset::evaluatedQuads(Channel channel, BrdfModels sunlit) const {
    const SurfaceShader surface = surfaceOf(channel);
    return firstTermQuad(surface.slopes, sunlit) + surface.terms();
}

void GlAsset::uploadArrays(const Evaluator* evaluator, const ShadingSet* shading) {
    const MeshView& mesh = asset_->mesh;
    const ModelView& model = asset_->model;
    const bool composed =
        model.composition && evaluator && model.convention.order <= kFieldOrder && !model.composition->floor;
    ArrayList arrays;
    const std::vector<const ClusterView*> clusters = clustersOf(model, composed);
    recipe_.mean = sharedPrecision(clusters, &ClusterView::mean);
    recipe_.basis = sharedPrecision(clusters, &ClusterView::basis);
    const std::vector<std::uint32_t> cluster_of_vertex = clusterOfVertex(*asset_);
    std::vector<std::uint32_t> table = clusterTable(clusters, arrays);
    std::vector<std::vector<float>> means;  // of light that bounces, until they are uploaded
    if (model.indirect) {
        recipe_.first_indirect = clusters.size();
        recipe_.bounced_ambient = bouncedAmbientWeights(model.indirect->axes);
        addIndirectRows(*model.indirect, arrays, means, std::uint32_t(scoreCount(clusters)), table);
    }
    FarWords words;  // until they are uploaded
    if (composed) {
        words = makeFarWords(evaluator->farTables(), evaluator->farLayout());
        placeFields(*model.composition, arrays, words);
        recipe_.far = placeTables(words, arrays);
        recipe_.far->part_count = std::uint32_t(model.composition->parts.size());
        recipe_.far->coefficients = model.convention.size();
        recipe_.far->near_count = std::uint32_t(model.composition->near_count);
        recipe_.far->near_parts = arrays.place(model.composition->near_parts);
        recipe_.far->near_gains = arrays.place(model.composition->near_gains);
        recipe_.far_functions = farGlsl(evaluator->farTables().constants());
        recipe_.residual = !model.composition->residual.empty();
    }
    AssetPlaces& places = recipe_.asset;
    places.positions = arrays.place(mesh.positions);
    places.normals = arrays.place(mesh.normals);
    places.tangents = arrays.place(mesh.tangents);
    places.skin_joints = arrays.place(mesh.skin_joints);
    places.skin_weights = arrays.place(mesh.skin_weights);
    places.slots = arrays.place(mesh.slot_of_vertex);
    places.cluster_of_vertex = arrays.place(std::span(cluster_of_vertex));
    places.clusters = arrays.place(std::span<const std::uint32_t>(table));
    if (asset_->model.composition) places.part_of_vertex = arrays.place(asset_->model.composition->part_of_vertex);
    if (shading) places.other_side = arrays.place(shading->otherSides());
    if (!mesh.follower_corners.empty()) {
        places.first_follower = std::uint32_t(mesh.firstFollower());
        places.point_corners = arrays.place(mesh.follower_corners);
        places.point_weights = arrays.place(mesh.follower_weights);
    }
    arrays_ = arrays.upload();
    bytes_ += arrays.bytes();
}

void GlAsset::uploadMaterials(const ShadingSet& shading) {
    shading_ = shadingLayout(shading);
    const std::vector<float> data = materialData(*shading_, shading);
    materials_ = makeTextureBuffer(GL_RGBA32F, std::span<const float>(data));
    bytes_ += data.size() * sizeof(float);
}

void GlAsset::placePose() {
    const auto texels = [](std::size_t numbers) { return (numbers + 3) / 4; };
    std::size_t scores = scoreCount(clustersOf(asset_->model, evaluatesFar()));
    if (asset_->model.indirect)
        for (const ClusterView& cluster : asset_->model.indirect->clusters) scores += cluster.components();
    PosePlaces& pose = recipe_.pose;
    pose.rotations = pose.bones + 3 * asset_->animation.jointCount();
    pose.scores = pose.rotations + 3 * asset_->model.clusters.size();
    pose.parts = pose.scores + texels(scores);
    pose.materials = pose.parts + (recipe_.far ? kPosedPartRows * recipe_.far->part_count : 0);
    const std::size_t slots = std::max<std::size_t>(1, asset_->mesh.slots.size());
    pose.lobes = pose.materials + texels(slots);
    pose.terms = pose.lobes + slots;
    pose.light = pose.terms + (recipe_.surface.on ? texels(slots * (1 + shading_->term_passes)) : 0);
    pose.size = pose.light + (shading_ ? shading_->lightTexels() : 0);
}

const GlAsset::Program& GlAsset::evaluateProgram(Channel channel, std::size_t cast_sets, bool sunlit) {
    const auto [found, is_new] = evaluate_.try_emplace({channel, cast_sets, sunlit});
    Program& made = found->second;
    if (!is_new) return made;
    ShaderRecipe recipe = recipe_;
    recipe.channel = channel;
    recipe.casts = cast_sets > 0;
    recipe.heights = cast_sets > 1;
    recipe.sunlit = sunlit;
    if (channel == Channel::kShaded) recipe.shading = &shading();
    made.program = makeComputeProgram(evaluateSource(recipe));
    made.eye = gl::GetUniformLocation(made.program.id(), "eye");
    made.vertex_count = gl::GetUniformLocation(made.program.id(), "vertex_count");
    return made;
}

namespace {

// Makes a program that has no eye when it is first asked for.
const GlAsset::Program& madeOnce(std::optional<GlAsset::Program>& made, std::string (*source)(const ShaderRecipe&),
                                 const ShaderRecipe& recipe) {
    if (!made) {
        made = GlAsset::Program();
        made->program = makeComputeProgram(source(recipe));
        made->vertex_count = gl::GetUniformLocation(made->program.id(), "vertex_count");
    }
    return *made;
}

}  // namespace

const GlAsset::Program& GlAsset::anchorProgram() { return madeOnce(anchor_, anchorSource, recipe_); }
const GlAsset::Program& GlAsset::receiverProgram() { return madeOnce(receiver_, receiverSource, recipe_); }

const GlAsset::Program& GlAsset::drawProgram(Channel channel, BrdfModels sunlit) {
    const auto [found, is_new] = draw_.try_emplace({channel, sunlit});
    Program& made = found->second;
    if (!is_new) return made;
    const SurfaceShader surface = surfaceOf(channel);
    made.program =
        makeProgram(evaluatedVertexSource(channel, sunlit, surface), channelFragmentSource(channel, sunlit, surface));
    if (surface.on) made.surface = surfaceUniforms(made.program);
    made.view = viewUniforms(made.program);
    if (sunlit) made.sunlight = sunlightUniforms(made.program);
    made.vertex_count = gl::GetUniformLocation(made.program.id(), "vertex_count");
    return made;
}

void GlAsset::bindArrays() const {
    gl::BindBufferBase(GL_SHADER_STORAGE_BUFFER, kArraysBinding, arrays_.id());
    if (!shading_) return;
    gl::ActiveTexture(GL_TEXTURE0);  // the only sampler, unit 0
    gl::BindTexture(GL_TEXTURE_BUFFER, materials_.texture.id());
}

void GlAsset::draw(Channel channel, const Program& program, std::size_t instances) const {
    const bool cull_backs = asset_->mesh.cull_backs;  // a back has triangles of its own
    if (cull_backs) gl::Enable(GL_CULL_FACE);
    if (surfaceOf(channel).on) {
        gl::BindVertexArray(pictured_array_.id());
        surface_->draw(program.surface, nullptr, instances);
    } else {
        gl::BindVertexArray(vertex_array_.id());
        gl::DrawElementsInstanced(GL_TRIANGLES, indexCount(), GL_UNSIGNED_INT, nullptr, GLsizei(instances));
    }
    if (cull_backs) gl::Disable(GL_CULL_FACE);
}

}  // namespace penumbra
