// Says what is wrong where E of an asset is most wrong.
//
// Problem: means do not show what one sees, single faults. Which stage made a fault?
//
// Here: the model is a chain of steps, and the truth can take the place of each of them. So the error of a vertex is a
// sum: what changes from the truth to the true local visibility times the far parts, from there to the same with the
// truth's projection on the components, then with the model's scores, with the residual, and with the packed numbers.
// The step that adds most to the error, in its direction, is its cause.
#include "pack/check/worst_places.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "formats/common/csv_field.h"
#include "formats/common/parallel_for.h"
#include "formats/common/write_file.h"
#include "pack/check/baked_frames.h"
#include "pack/check/component_spans.h"
#include "runtime/shade/shading.h"

namespace penumbra {

namespace {

constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

// The signed distance of a point from the surface of a part, clamped to what the bytes of the field can say.
// sampleField() tells only a depth, as a share of the fade: with another fade it tells more, with a negative one the
// distance outside.
float signedDistance(FieldTable& field, float range, Vec3 point) {
    std::array<float, kFieldCoefficients> unused;
    const float fade = std::exchange(field.fade, range);
    const float depth = sampleField(field, point, unused);
    field.fade = -range;
    const float outside = sampleField(field, point, unused);
    field.fade = fade;
    return (outside - depth) * range;
}

// What the far parts of one vertex say, by the plain form (sh/far/far_visibility.h).
struct FarLook {
    double light = 1;                                  // what being inside of parts leaves
    std::array<float, kFarCoefficients> coefficients;  // without that
    std::size_t deepest = 0, largest = 0;              // parts
    double distance = std::numeric_limits<double>::infinity(), inside = 0, hidden = 0;
};

class PlaceDescriber {
public:
    PlaceDescriber(const AssetView& asset, const VisibilityReader& truth, const CheckReferences& references);
    void setFrame(std::size_t frame, int threads);
    WorstPlace describe(const PlaceError& pair);

private:
    const AssetView& asset_;
    const VisibilityReader& truth_;
    Evaluator evaluator_;
    ComponentSpans spans_;
    std::optional<Evaluator> unpacked_;
    std::optional<Evaluator> far_alone_;  // without near parts, which the truth's local numbers have already
    std::optional<ComponentSpans> unpacked_spans_;
    const AssetView* local_asset_;  // the one whose components are looked at
    std::vector<std::uint32_t> rows_;
    std::vector<std::vector<std::uint32_t>> neighbours_;
    FarFields lit_;              // nothing goes dark in these
    std::vector<float> ranges_;  // of their signed distances
    double diagonal_;
    std::size_t frame_ = 0, stride_, size_;
    VisibilityFrame baked_;
    std::vector<float> coefficients_, unpacked_coefficients_, local_, true_local_, spanned_, far_, far_alone_factors_;
    std::vector<Vec3> positions_, normals_, tangents_;

    std::size_t clusterOf(std::uint32_t vertex) const;
    std::span<const float> at(const std::vector<float>& coefficients, std::uint32_t v) const {
        return std::span(coefficients).subspan(v * stride_, size_);
    }
    double ambientOf(std::span<const float> coefficients) const;
    double trueAmbient(std::uint32_t vertex) const;
    double productWith(std::span<const float> local, std::span<const float> far) const;
    bool hasTrueLocal() const;
    std::vector<float> nearFactor(std::uint32_t vertex) const;
    FarLook lookAtParts(std::uint32_t vertex);
    void describeBorder(const PlaceError& pair, WorstPlace& place) const;
    void describeSteps(const PlaceError& pair, WorstPlace& place);
};

PlaceDescriber::PlaceDescriber(const AssetView& asset, const VisibilityReader& truth, const CheckReferences& references)
    : asset_(asset),
      truth_(truth),
      evaluator_(asset),
      spans_(asset),
      local_asset_(&asset),
      rows_(bakedRows(asset, truth.header())),
      neighbours_(asset.mesh.positions.size()),
      diagonal_(boxDiagonal({asset.mesh.positions.begin(), asset.mesh.positions.end()})),
      stride_(std::size_t(asset.model.stride)),
      size_(std::size_t(asset.model.convention.size())) {
    evaluator_.setQuality(references.quality);
    if (references.unpacked) {
        local_asset_ = references.unpacked;
        unpacked_.emplace(*references.unpacked);
        unpacked_spans_.emplace(*references.unpacked);
    }
    const std::span<const std::uint32_t> corners = asset.mesh.triangles;
    for (std::size_t i = 0; i < corners.size(); ++i)
        for (std::size_t k = 1; k < 3; ++k) neighbours_[corners[i]].push_back(corners[i / 3 * 3 + (i + k) % 3]);
    const std::size_t count = evaluator_.vertexCount();
    for (std::vector<float>* coefficients : {&coefficients_, &unpacked_coefficients_, &local_, &true_local_, &spanned_})
        coefficients->resize(count * stride_);
    far_.resize(count * kFarCoefficients);
    for (std::vector<Vec3>* vectors : {&positions_, &normals_, &tangents_}) vectors->resize(count);
    if (!evaluator_.composed()) return;
    lit_ = evaluator_.farTables().fields();
    if (evaluator_.farTables().nearParts().count > 0) {
        far_alone_.emplace(evaluator_);
        far_alone_->setNearFactors(NearFactors::kWithout);
        far_alone_factors_.resize(far_.size());
    }
    for (std::size_t p = 0; p < lit_.tables.size(); ++p) {
        lit_.tables[p].fade = std::numeric_limits<float>::infinity();
        ranges_.push_back(127 * asset.model.composition->parts[p].field.distance_scale);
    }
}

std::size_t PlaceDescriber::clusterOf(std::uint32_t vertex) const {
    const std::vector<ClusterView>& clusters = asset_.model.clusters;
    const auto after = std::upper_bound(clusters.begin(), clusters.end(), vertex,
                                        [](std::uint32_t v, const ClusterView& c) { return v < c.first_vertex; });
    return std::size_t(after - clusters.begin()) - 1;
}

double PlaceDescriber::ambientOf(std::span<const float> coefficients) const {
    std::array<float, coefficientCount(kMaxOrder)> weights;
    ambientWeights(asset_.model.convention, std::span(weights).first(size_));
    double e = 0;
    for (std::size_t i = 0; i < size_; ++i) e += double(weights[i]) * coefficients[i];
    return e;
}

double PlaceDescriber::trueAmbient(std::uint32_t v) const {
    const std::size_t n = truth_.header().coefficientCount();
    std::array<float, coefficientCount(kMaxOrder)> coefficients;
    coefficientsFromMoments(asset_.model.convention, std::span(baked_.coefficients).subspan(rows_[v] * n, n),
                            normals_[v], tangents_[v], std::span(coefficients).first(size_));
    return ambientOf(coefficients);
}

// E of the product, which lies in [0, 1] as that of the model does.
double PlaceDescriber::productWith(std::span<const float> local, std::span<const float> far) const {
    std::array<float, coefficientCount(kMaxOrder)> product;
    const int order = asset_.model.convention.order;
    multiplyMirrored(order, local, order, far, kFieldOrder, std::span(product).first(size_));
    return std::clamp(ambientOf(product), 0.0, 1.0);
}

bool PlaceDescriber::hasTrueLocal() const {
    const std::optional<LocalMoments>& local = truth_.header().local;
    return evaluator_.composed() && local && local->order >= asset_.model.convention.order &&
           local->steps == asset_.model.composition->local_steps;
}

void PlaceDescriber::setFrame(std::size_t frame, int threads) {
    frame_ = frame;
    baked_ = truth_.readFrame(frame);
    poseAs(evaluator_, baked_);
    if (unpacked_) poseAs(*unpacked_, baked_);
    if (far_alone_) poseAs(*far_alone_, baked_);
    const Evaluator& local = unpacked_ ? *unpacked_ : evaluator_;
    parallelFor(asset_.model.clusters.size(), threads, [&](std::size_t c) {
        const ClusterView& view = asset_.model.clusters[c];
        const std::size_t begin = view.first_vertex, end = begin + view.vertex_count;
        evaluator_.skin(begin, end, positions_, normals_, tangents_);
        if (!evaluator_.composed()) {
            evaluator_.evaluateCluster(c, coefficients_);
            if (unpacked_) unpacked_->evaluateCluster(c, unpacked_coefficients_);
            return;
        }
        evaluator_.evaluateFar(c, far_);
        if (far_alone_) far_alone_->evaluateFar(c, far_alone_factors_);
        evaluator_.composeCluster(c, far_, coefficients_);
        if (unpacked_) unpacked_->composeCluster(c, far_, unpacked_coefficients_);
        local.evaluateLocal(c, local_);
        if (!hasTrueLocal()) return;
        const std::size_t n = truth_.header().local->coefficientCount();
        for (std::size_t v = begin; v < end; ++v)
            coefficientsFromMoments(asset_.model.convention,
                                    std::span(baked_.local_coefficients).subspan(rows_[v] * n, n), normals_[v],
                                    tangents_[v], std::span(true_local_).subspan(v * stride_, size_));
        (unpacked_ ? *unpacked_spans_ : spans_).project(local_asset_->model.clusters[c], c, true_local_, spanned_);
    });
    const std::size_t first = evaluator_.firstFollower(), all = evaluator_.vertexCount();
    if (first == all) return;
    evaluator_.skin(first, all, positions_, normals_, tangents_);
    evaluator_.follow(first, all, {normals_, tangents_}, coefficients_);
}

// What the near parts of a vertex leave visible, [kFarCoefficients]; all of it where the model has none.
std::vector<float> PlaceDescriber::nearFactor(std::uint32_t v) const {
    std::vector<float> factor = freeSight({BelowHorizon::kMirrored, kFieldOrder});
    const CompositionView& composition = *asset_.model.composition;
    const FarTables& tables = evaluator_.farTables();
    const std::span<const std::uint16_t> parts = tables.nearParts().of(composition.part_of_vertex[v]);
    std::vector<NearPart> near_parts;
    for (std::size_t i = 0; i < parts.size(); ++i)
        if (parts[i] != kNoPart)
            near_parts.push_back({parts[i], kPerGain * float(composition.near_gains[v * parts.size() + i])});
    multiplyByNear(tables.fields(), evaluator_.posedParts(), near_parts, {positions_[v], normals_[v], tangents_[v]},
                   factor);
    return factor;
}

FarLook PlaceDescriber::lookAtParts(std::uint32_t v) {
    const FarTables& tables = evaluator_.farTables();
    const std::span<const PosedPart> posed = evaluator_.posedParts();
    const std::span<const std::uint16_t> parts = tables.partsSeenBy(asset_.model.composition->part_of_vertex[v]);
    FarLook look;
    farVisibility(lit_, posed, parts, {positions_[v], normals_[v], tangents_[v]}, look.coefficients);
    for (const std::uint16_t p : parts) {
        std::array<float, kFieldCoefficients> blocked;
        const Vec3 at = posed[p].to_part.point(positions_[v]);
        const double inside = double(sampleField(tables.fields().tables[p], at, blocked));
        const double hidden = -double(blocked[0]) / std::sqrt(4 * std::numbers::pi);
        const double distance = double(signedDistance(lit_.tables[p], ranges_[p], at));
        look.light *= 1 - inside;
        if (hidden > look.hidden) look.hidden = hidden, look.largest = p;
        // Far from a part its fine box, which has the distances, has no share: 0 there says nothing.
        if (distance != 0 && distance < look.distance) look.distance = distance, look.deepest = p, look.inside = inside;
    }
    return look;
}

void PlaceDescriber::describeBorder(const PlaceError& pair, WorstPlace& place) const {
    if (pair.vertex >= evaluator_.firstFollower()) return;
    const std::size_t cluster = clusterOf(pair.vertex);
    const double error = place.e_model - place.e_truth;
    double within = 0;
    for (const std::uint32_t u : neighbours_[pair.vertex]) {
        if (u >= rows_.size()) continue;
        const double jump = std::abs(error - (ambientOf(at(coefficients_, u)) - trueAmbient(u)));
        const bool other = clusterOf(u) != cluster;
        place.border |= other;
        (other ? place.border_jump : within) = std::max(other ? place.border_jump : within, jump);
    }
    // Where errors vary as much inside of the cluster, its border is not to blame.
    place.border_jump = std::max(0.0, place.border_jump - within);
}

void PlaceDescriber::describeSteps(const PlaceError& pair, WorstPlace& place) {
    const std::uint32_t v = pair.vertex;
    const double unpacked = unpacked_ ? ambientOf(at(unpacked_coefficients_, v)) : place.e_model;
    if (unpacked_) place.packing = place.e_model - unpacked;
    if (!evaluator_.composed() || v >= evaluator_.firstFollower()) return;
    const FarLook look = lookAtParts(v);
    const auto name = [&](std::size_t part) {
        const std::uint32_t joint = lit_.joints[part];
        return joint == kStillJoint ? std::string("still") : std::string(asset_.animation.joint_names[joint]);
    };
    const std::span<const float> all = std::span(far_).subspan(v * kFarCoefficients, kFarCoefficients);
    const std::span<const float> far =
        far_alone_ ? std::span(far_alone_factors_).subspan(v * kFarCoefficients, kFarCoefficients) : all;
    const std::vector<float> free = freeSight(asset_.model.convention);
    place.e_far = productWith(free, far);
    place.e_local_model = far_alone_ ? productWith(at(local_, v), nearFactor(v)) : ambientOf(at(local_, v));
    if (look.hidden > 0) place.largest_part = name(look.largest), place.hidden = look.hidden;
    if (std::isfinite(look.distance)) {
        place.deepest_part = name(look.deepest);
        place.depth = -look.distance / diagonal_;
        place.darkened = look.inside;
    }
    const double product = productWith(at(local_, v), all);
    place.residual = unpacked - product;
    if (!hasTrueLocal()) return;
    place.e_local_truth = ambientOf(at(true_local_, v));
    const double exact = productWith(at(true_local_, v), far);
    // Where a model has near parts, its components are not of the true local numbers, which hold them.
    const double spanned = far_alone_ ? exact : productWith(at(spanned_, v), far);
    if (!far_alone_) place.e_local_spanned = ambientOf(at(spanned_, v));
    place.darkening = (look.light - 1) * productWith(at(true_local_, v), look.coefficients);
    place.far_rest = exact - place.e_truth - place.darkening;
    place.components = spanned - exact;
    place.regression = product - spanned;
}

WorstPlace PlaceDescriber::describe(const PlaceError& pair) {
    const FrameList& frames = truth_.header().frames;
    WorstPlace place;
    place.clip = frames.clip_names[frames.clip[frame_]];
    place.number = frame_ - std::size_t(std::find(frames.clip.begin(), frames.clip.end(), frames.clip[frame_]) -
                                        frames.clip.begin());
    place.time = frames.time[frame_];
    place.held_out = true;
    for (const ClipView& clip : asset_.animation.clips)
        if (clip.name == place.clip) place.held_out = clip.held_out;
    place.point = rows_[pair.vertex];
    place.position = positions_[pair.vertex];
    place.normal = normals_[pair.vertex];
    place.e_model = double(pair.e_model);
    place.e_truth = double(pair.e_truth);
    place.out_of_range = evaluator_.outOfRange();
    if (evaluator_.composed()) {
        const CompositionView& composition = *asset_.model.composition;
        const std::uint32_t joint = composition.parts[composition.part_of_vertex[pair.vertex]].field.joint;
        if (joint != kStillJoint) place.part = asset_.animation.joint_names[joint];
    }
    describeBorder(pair, place);
    describeSteps(pair, place);
    return place;
}

}  // namespace

WorstPlace::WorstPlace()
    : e_local_truth(kNotMeasured),
      e_local_spanned(kNotMeasured),
      e_local_model(kNotMeasured),
      e_far(kNotMeasured),
      darkening(kNotMeasured),
      far_rest(kNotMeasured),
      components(kNotMeasured),
      regression(kNotMeasured),
      residual(kNotMeasured),
      packing(kNotMeasured),
      depth(kNotMeasured),
      darkened(kNotMeasured),
      hidden(kNotMeasured) {}

PlaceCause causeOf(const WorstPlace& place) {
    if (std::isnan(place.far_rest)) return PlaceCause::kUnknown;
    const double error = place.e_model - place.e_truth, sign = error > 0 ? 1 : -1;
    // The residual is there to correct what the product with the far parts has wrong. What it corrects is no fault.
    double far_rest = place.far_rest, residual = place.residual;
    if ((far_rest > 0) != (residual > 0)) {
        const double corrected = std::min(std::abs(far_rest), std::abs(residual));
        far_rest -= std::copysign(corrected, far_rest);
        residual -= std::copysign(corrected, residual);
    }
    const std::pair<double, PlaceCause> steps[] = {
        {place.darkening, PlaceCause::kSunkenDark},
        {far_rest, PlaceCause::kFarParts},
        {place.components, PlaceCause::kComponents},
        {place.regression, PlaceCause::kRegression},
        {residual, PlaceCause::kResidual},
        {std::isnan(place.packing) ? 0 : place.packing, PlaceCause::kPacking}};
    const auto [most, cause] = *std::max_element(std::begin(steps), std::end(steps), [&](const auto& a, const auto& b) {
        return sign * a.first < sign * b.first;
    });
    const bool learned =
        cause == PlaceCause::kComponents || cause == PlaceCause::kRegression || cause == PlaceCause::kResidual;
    if (cause == PlaceCause::kFarParts && error > 0 && place.depth > 0) return PlaceCause::kSunkenLight;
    if (learned && place.border_jump > std::abs(error) / 2) return PlaceCause::kBorder;
    if (learned && cause != PlaceCause::kComponents && place.out_of_range > kFarOutOfRange)
        return PlaceCause::kOutOfRange;
    return cause;
}

std::vector<WorstPlace> describePlaces(const AssetView& asset, const VisibilityReader& truth,
                                       const CheckReferences& references, std::span<const PlaceError> pairs,
                                       int threads) {
    PlaceDescriber describer(asset, truth, references);
    std::vector<WorstPlace> places(pairs.size());
    std::map<std::size_t, std::vector<std::size_t>> pairs_of_frame;
    for (std::size_t i = 0; i < pairs.size(); ++i) pairs_of_frame[pairs[i].frame].push_back(i);
    for (const auto& [frame, indices] : pairs_of_frame) {
        throwIfInterrupted();
        describer.setFrame(frame, threads);
        for (const std::size_t i : indices) places[i] = describer.describe(pairs[i]);
    }
    return places;
}

std::string placesCsv(std::span<const WorstPlace> places) {
    std::string csv =
        "rank,clip,frame,time,held_out,vertex,part,x,y,z,normal_x,normal_y,normal_z,cause,e_truth,e_model,error,"
        "darkening,far_rest,components,regression,residual,packing,e_local_truth,e_local_spanned,e_local_model,e_far,"
        "deepest_part,depth,darkened,largest_part,hidden,out_of_range,border,border_jump\n";
    const auto add = [&](double value) {
        char text[32] = ",";
        if (std::isfinite(value)) std::snprintf(text, sizeof text, ",%.6g", value);
        csv += text;
    };
    for (std::size_t i = 0; i < places.size(); ++i) {
        const WorstPlace& p = places[i];
        csv += std::to_string(i + 1) + "," + csvField(p.clip) + "," + std::to_string(p.number);
        add(p.time);
        csv += (p.held_out ? ",1," : ",0,") + std::to_string(p.point) + "," + csvField(p.part);
        for (const Vec3 vector : {p.position, p.normal})
            for (int axis = 0; axis < 3; ++axis) add(double(vector[axis]));
        csv += "," + csvField(wordOf(kPlaceCauseWords, causeOf(p)));
        for (const double value :
             {p.e_truth, p.e_model, p.e_model - p.e_truth, p.darkening, p.far_rest, p.components, p.regression,
              p.residual, p.packing, p.e_local_truth, p.e_local_spanned, p.e_local_model, p.e_far})
            add(value);
        csv += "," + csvField(p.deepest_part);
        add(p.depth);
        add(p.darkened);
        csv += "," + csvField(p.largest_part);
        add(p.hidden);
        add(p.out_of_range);
        csv += p.border ? ",1" : ",0";
        add(p.border_jump);
        csv += "\n";
    }
    return csv;
}

}  // namespace penumbra
