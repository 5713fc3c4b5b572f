// Checks of composed assets: where their error comes from.
#include <gtest/gtest.h>
#include <unistd.h>

#include "pack/check/check_asset.h"
#include "pack/check/error_budget.h"
#include "pack/check/worst_places.h"
#include "pack/compress/compress_model.h"
#include "pack/pack_asset.h"
#include "runtime/evaluate/evaluator.h"
#include "runtime/shade/shading.h"
#include "sh/sh_rotation.h"
#include "tests/difference.h"
#include "tests/synthetic_composition.h"

namespace penumbra::test_check_composed {
namespace {

namespace fs = std::filesystem;

Model nearTube(std::size_t near_count) {
    Model model = synthetic::composedTube({.joints = 6, .frames = 6});
    if (near_count > 0) synthetic::addNearParts(model, near_count);
    return model;
}

// A bake whose visibility is what the model says, with the local moments that the model's local part says. The even
// moments of the local frames are half the numbers of D5; the odd ones, which nothing reads, are 0.
struct ComposedBake {
    Model model;
    Packed packed;
    AssetView asset;
    fs::path path = fs::temp_directory_path() / ("composed" + std::to_string(::getpid()) + ".vis.h5");

    explicit ComposedBake(int local_steps, std::size_t near_count = 0)
        : model(nearTube(near_count)),
          packed(packAsset(model, {}, {}, {.precision = AssetPrecision::kF32}, "{}", 1)),
          asset(openAsset(packed.bytes)) {
        VisibilityHeader header;
        header.rays = 16;
        if (local_steps > 0) header.local = LocalMoments{5, local_steps};
        header.mesh = model.mesh;
        header.skin = model.skin;
        header.rest_normals = model.rest_normals;
        header.frames = model.frames;
        header.pose_size = model.pose_size;
        header.provenance = model.provenance;
        VisibilityWriter writer(path, header, Precision::kFloat32);
        for (std::size_t f = 0; f < model.frames.frameCount(); ++f) writer.writeFrame(frame(f, local_steps > 0));
        writer.finish();
    }
    ~ComposedBake() { fs::remove(path); }

    VisibilityFrame frame(std::size_t f, bool with_local) const {
        Evaluator evaluator(asset);
        const std::size_t count = evaluator.vertexCount(), joints = model.skin.jointCount();
        std::vector<float> coefficients(count * 16), local(count * 16);
        std::vector<Vec3> positions(count), normals(count), tangents(count);
        evaluator.setFrame(f);
        for (std::size_t c = 0; c < evaluator.clusterCount(); ++c) {
            evaluator.evaluateCluster(c, coefficients);
            evaluator.evaluateLocal(c, local);
        }
        evaluator.skin(0, count, positions, normals, tangents);
        VisibilityFrame out;
        out.positions.resize(count);
        out.normals.resize(count);
        out.bones.assign(model.bones.begin() + long(f * joints), model.bones.begin() + long((f + 1) * joints));
        out.pose.assign(model.pose.begin() + long(f) * model.pose_size,
                        model.pose.begin() + long(f + 1) * model.pose_size);
        out.coefficients.resize(count * 25);
        if (with_local) out.local_coefficients.resize(count * 25);
        for (std::size_t v = 0; v < count; ++v) {
            const std::size_t point = asset.mesh.shading_point[v];
            out.positions[point] = positions[v];
            out.normals[point] = normals[v];
            const ShRotation to_local = makeShRotation(5, toLocalFrame(normals[v], tangents[v]));
            const auto store = [&](const std::vector<float>& from, std::vector<float>& to) {
                std::vector<float> moments(25);
                for (std::size_t i = 0; i < 15; ++i)
                    moments[std::size_t(model.convention.indices()[i])] = from[v * 16 + i] / 2;
                applyTransposed(to_local, moments, std::span(to).subspan(point * 25, 25));
            };
            store(coefficients, out.coefficients);
            if (with_local) store(local, out.local_coefficients);
        }
        return out;
    }

    // The places where a changed model is most wrong.
    std::vector<WorstPlace> worst(const Model& changed, const CheckReferences& references = {}) const {
        const Packed bytes = packAsset(changed, {}, {}, {.precision = AssetPrecision::kF32}, "{}", 1);
        const AssetView checked = openAsset(bytes.bytes);
        const VisibilityReader truth(path);
        WorstPairs pairs(checked, truth.header().frames, {.count = 10});
        CheckReferences all = references;
        all.worst = &pairs;
        checkAsset(checked, truth, all, 2, [](std::size_t) {});
        return describePlaces(checked, truth, all, pairs.chosen(), 2);
    }

    ErrorFigures check(const AssetView& checked, const CheckReferences& references = {}) const {
        return checkAsset(checked, VisibilityReader(path), references, 2, [](std::size_t) {}).training;
    }
};

// Measured: 3e-6, from single-precision rotations there and back.
TEST(CheckComposed, AModelThatMadeTheTruthHasNoErrorOfItsOwn) {
    const ComposedBake bake(1);
    const ErrorFigures figures = bake.check(bake.asset);
    EXPECT_TRUE(figures.composed);
    EXPECT_LT(figures.relative_error, 1e-5);
    for (double local : {figures.local, figures.local_truncation, figures.local_regression}) EXPECT_LT(local, 1e-5);
    EXPECT_GT(figures.split, 0.01) << "the residual is not in it";
    EXPECT_NEAR(figures.split, figures.without_residual, 1e-5);
    // The fields are of balls, and rays meet the tube.
    EXPECT_GT(figures.far_by_fields, 0);
    EXPECT_GT(figures.far_by_rays, 0);
    EXPECT_EQ(figures.far_frames, figures.frames);
    EXPECT_TRUE(std::isnan(figures.truncation));
    EXPECT_TRUE(std::isnan(figures.regression));
}

// A row with the truth's local numbers is the same whether the model has near parts or not. This bake's local numbers
// lack what near parts hide, unlike those of penumbra-bake, so that the local model differs by it.
TEST(CheckComposed, TrueLocalNumbersAreNotMultipliedByNearParts) {
    const ComposedBake bake(1, 2);
    const ErrorFigures figures = bake.check(bake.asset);
    EXPECT_LT(figures.relative_error, 1e-5);
    Model without = bake.model;
    without.composition->near_count = 0;
    without.composition->near_parts.clear();
    without.composition->near_gains.clear();
    const Packed packed = packAsset(without, {}, {}, {.precision = AssetPrecision::kF32}, "{}", 1);
    const ErrorFigures far_alone = bake.check(openAsset(packed.bytes));
    EXPECT_NEAR(figures.split, far_alone.split, 1e-6);
    EXPECT_GT(figures.local, 0.01) << "what near parts hide";
    EXPECT_LT(far_alone.local, 1e-5);
    EXPECT_TRUE(std::isnan(figures.local_truncation) && std::isnan(figures.local_regression));
    for (const BudgetRow& row : errorBudget(figures))
        if (row.name == "local PCA") {
            EXPECT_EQ(row.option, "a model without near parts");
        }
}

TEST(CheckComposed, NeedsLocalMomentsOfTheSameSteps) {
    for (int steps : {0, 2}) {
        const ComposedBake bake(steps);
        const ErrorFigures figures = bake.check(bake.asset);
        EXPECT_TRUE(std::isnan(figures.split));
        EXPECT_TRUE(std::isnan(figures.far_by_fields) && std::isnan(figures.far_by_rays));
        for (double local : {figures.local, figures.local_truncation, figures.local_regression})
            EXPECT_TRUE(std::isnan(local));
        EXPECT_GT(figures.without_residual, 0.01);
    }
}

TEST(CheckComposed, BudgetHasTheRowsOfAComposedModel) {
    const ComposedBake bake(1);
    const Packed bytes = packAsset(bake.model, {}, {}, {.precision = AssetPrecision::kI8}, "{}", 1);
    const AssetView small = openAsset(bytes.bytes);
    const ErrorFigures figures = bake.check(small, {.unpacked = &bake.asset});
    EXPECT_GT(figures.packing, 1e-3);
    EXPECT_NEAR(figures.packing, figures.relative_error, 1e-5) << "the truth is the unpacked model";
    for (double local : {figures.local, figures.local_truncation, figures.local_regression})
        EXPECT_LT(local, 1e-5) << "these are of the unpacked model, not of the packed one";
    const ErrorFigures stored = bake.check(small);
    for (double local : {stored.local, stored.local_truncation, stored.local_regression}) EXPECT_GT(local, 1e-4);
    std::vector<std::string> names;
    for (const BudgetRow& row : errorBudget(figures)) names.push_back(row.name);
    EXPECT_EQ(names, (std::vector<std::string>{"bake noise", "SH truncation", "true local x far",
                                               "true local x far by fields", "true local x far by rays", "local PCA",
                                               "local regression", "local model", "without residual", "unpacked model",
                                               "rank and quantisation", "total", "against all bands"}));
}

// The components still span the truth, so that whatever other scores cost is regression.
TEST(CheckComposed, OtherScoresAreLocalRegression) {
    const ComposedBake bake(1);
    Model other = bake.model;
    for (ClusterModel& cluster : other.clusters)
        for (float& x : cluster.bias) x += 0.1f;
    const Packed bytes = packAsset(other, {}, {}, {.precision = AssetPrecision::kF32}, "{}", 1);
    const ErrorFigures figures = bake.check(openAsset(bytes.bytes));
    EXPECT_GT(figures.local, 0.01);
    EXPECT_LT(figures.local_truncation, 1e-5);
    EXPECT_NEAR(figures.local_regression, figures.local, 1e-5);
}

// Without components the model and the projected truth are both the mean, and nothing is left to regress.
TEST(CheckComposed, MissingComponentsAreLocalPca) {
    const ComposedBake bake(1);
    Model other = bake.model;
    for (ClusterModel& cluster : other.clusters) keepComponents(cluster, 0);
    const Packed bytes = packAsset(other, {}, {}, {.precision = AssetPrecision::kF32}, "{}", 1);
    const ErrorFigures figures = bake.check(openAsset(bytes.bytes));
    EXPECT_GT(figures.local, 0.01);
    EXPECT_EQ(figures.local_regression, 0);
    EXPECT_EQ(figures.local_truncation, figures.local);
}

// Returns by how much the steps do not add up to the error.
double leftOver(const WorstPlace& p) {
    return p.e_truth + p.darkening + p.far_rest + p.components + p.regression + p.residual +
           (std::isnan(p.packing) ? 0 : p.packing) - p.e_model;
}

// Lets the fine box of a part reach everywhere, with every point far below the part's surface.
void sinkEverythingInto(std::size_t part, Model& model) {
    PartFields& fields = model.composition->fields;
    for (std::int8_t& x : fields.distances[part]) x = -127;
    fields.parts[part].boxes[0].low = Vec3{-9, -9, -9};
    fields.parts[part].boxes[0].high = Vec3{9, 9, 9};
}

// Measured: 2e-7.
TEST(WorstPlaces, StepsAddUpToTheErrorAndNameTheStepThatIsWrong) {
    const ComposedBake bake(1);
    Model scores = bake.model, components = bake.model, residual = bake.model, inside = bake.model;
    for (ClusterModel& cluster : scores.clusters)
        for (float& x : cluster.bias) x += 0.5f;
    for (ClusterModel& cluster : components.clusters) keepComponents(cluster, 0);
    for (ClusterModel& cluster : residual.composition->residual)
        for (float& x : cluster.mean) x += 0.2f;
    for (std::size_t part = 0; part < 6; ++part) sinkEverythingInto(part, inside);
    for (const auto& [model, cause] : {std::pair(&scores, PlaceCause::kRegression),
                                       {&components, PlaceCause::kComponents},
                                       {&residual, PlaceCause::kResidual},
                                       {&inside, PlaceCause::kSunkenDark}}) {
        const std::vector<WorstPlace> places = bake.worst(*model);
        ASSERT_FALSE(places.empty());
        std::size_t named = 0;
        Largest left_over;
        for (WorstPlace place : places) {
            left_over.add(std::abs(leftOver(place)));
            place.out_of_range = 0;  // the model's ranges are not those of its frames
            named += causeOf(place) == cause || causeOf(place) == PlaceCause::kBorder;
        }
        EXPECT_LT(left_over.value(), 1e-5);
        EXPECT_GT(2 * named, places.size()) << wordOf(kPlaceCauseWords, cause) << "\n" << placesCsv(places);
    }
}

TEST(WorstPlaces, WrongScoresInAPoseOutOfRangeAreOutOfRange) {
    WorstPlace place;
    place.e_truth = 0.5;
    place.e_model = place.regression = 0.9;
    place.darkening = place.far_rest = place.components = place.residual = 0;
    EXPECT_EQ(causeOf(place), PlaceCause::kRegression);
    place.out_of_range = 2 * kFarOutOfRange;
    EXPECT_EQ(causeOf(place), PlaceCause::kOutOfRange);
    place.border_jump = 0.3;
    EXPECT_EQ(causeOf(place), PlaceCause::kBorder);
}

TEST(WorstPlaces, ASunkenVertexNamesThePartThatDarkensIt) {
    const ComposedBake bake(1);
    Model inside = bake.model;
    sinkEverythingInto(5, inside);
    const WorstPlace place = bake.worst(inside).at(0);
    EXPECT_EQ(place.deepest_part, inside.skin.joint_names[5]);
    EXPECT_GT(place.darkened, 0.5);
    EXPECT_GT(place.depth, 0);
    EXPECT_LT(place.darkening, -0.3);
    EXPECT_LT(place.e_model, place.e_truth);
}

TEST(WorstPlaces, WithoutTrueLocalMomentsTheCauseIsUnknown) {
    const ComposedBake bake(0);
    Model scores = bake.model;
    for (ClusterModel& cluster : scores.clusters)
        for (float& x : cluster.bias) x += 0.5f;
    const WorstPlace place = bake.worst(scores).at(0);
    EXPECT_EQ(causeOf(place), PlaceCause::kUnknown);
    EXPECT_TRUE(std::isnan(place.components));
    EXPECT_FALSE(std::isnan(place.residual));
}

TEST(WorstPlaces, PackingIsWhatBytesChange) {
    const ComposedBake bake(1);
    const CheckReferences references{.unpacked = &bake.asset};
    Model coarse = bake.model;
    for (ClusterModel& cluster : coarse.clusters) keepComponents(cluster, 0);
    for (const WorstPlace& place : bake.worst(coarse, references)) {
        EXPECT_LT(std::abs(leftOver(place)), 1e-5);
        EXPECT_EQ(causeOf(place), PlaceCause::kPacking) << "the unpacked model is the truth";
    }
}

TEST(WorstPlaces, CsvHasARowAPlaceAndEmptyFieldsForWhatIsNotMeasured) {
    WorstPlace place;
    place.clip = "a,b";
    place.part = "hip";
    place.e_truth = 0.75;
    const std::string csv = placesCsv(std::array{place, place});
    EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 3);
    EXPECT_NE(csv.find("\n2,\"a,b\",0,0,0,0,hip,0,0,0,0,0,0,unknown,0.75,0,-0.75,,,,,,,,,,,,,,,,0,0,0\n"),
              std::string::npos)
        << csv;
}

}  // namespace
}  // namespace penumbra::test_check_composed
