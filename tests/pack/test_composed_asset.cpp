// Assets of composed models: what they hold, what they cost, and what their reader refuses.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "asset_generated.h"
#include "formats/common/errors.h"
#include "pack/compress/coarsen_fields.h"
#include "pack/compress/packing_error.h"
#include "pack/pack_asset.h"
#include "tests/difference.h"
#include "tests/pack/changed_asset.h"
#include "tests/synthetic_composition.h"
#include "tests/use_asset.h"

namespace penumbra::test_composed_asset {
namespace {

using synthetic::composedTube;

Packed packedTube(const PackOptions& options = {.precision = AssetPrecision::kI8},
                  const Model& model = composedTube()) {
    return packAsset(model, {}, {}, options, "{}", 1);
}

std::vector<std::byte> tinyAsset() {
    Model model = composedTube({.rings = 3, .segments = 3, .joints = 4}, {.cells = 2});
    synthetic::addNearParts(model, 2);
    return packedTube({.precision = AssetPrecision::kI8}, model).bytes;
}

TEST(ComposedAsset, HoldsWhatTheModelHas) {
    Model model = composedTube();
    synthetic::addNearParts(model, 3);
    const Packed packed = packedTube({.precision = AssetPrecision::kF32}, model);
    const AssetView asset = openAsset(packed.bytes);
    ASSERT_TRUE(asset.model.composition);
    const CompositionView& view = *asset.model.composition;
    const Composition& composition = *model.composition;
    EXPECT_EQ(view.local_steps, composition.local_steps);
    EXPECT_EQ(view.fade, composition.fields.fade);
    EXPECT_TRUE(std::equal(view.steps.begin(), view.steps.end(), composition.steps.begin(), composition.steps.end()));
    for (std::size_t v = 0; v < view.part_of_vertex.size(); ++v)
        EXPECT_EQ(view.part_of_vertex[v], composition.part_of_vertex[asset.mesh.shading_point[v]]);
    ASSERT_EQ(view.near_count, 3u);
    EXPECT_TRUE(std::ranges::equal(view.near_parts, composition.near_parts));
    ASSERT_EQ(view.near_gains.size(), composition.near_gains.size());
    for (std::size_t i = 0; i < view.near_gains.size(); ++i)
        EXPECT_EQ(view.near_gains[i], composition.near_gains[3 * asset.mesh.shading_point[i / 3] + i % 3]);
    ASSERT_EQ(view.parts.size(), composition.fields.parts.size());
    for (std::size_t p = 0; p < view.parts.size(); ++p) {
        const PartField &a = view.parts[p].field, &b = composition.fields.parts[p];
        EXPECT_EQ(a.joint, b.joint);
        EXPECT_EQ(a.center, b.center);
        EXPECT_EQ(a.radius, b.radius);
        EXPECT_EQ(a.scale, b.scale);
        EXPECT_EQ(a.distance_scale, b.distance_scale);
        for (std::size_t box = 0; box < 2; ++box) {
            EXPECT_EQ(a.boxes[box].low, b.boxes[box].low);
            EXPECT_EQ(a.boxes[box].high, b.boxes[box].high);
            EXPECT_EQ(a.boxes[box].size, b.boxes[box].size);
        }
        const FieldBytes &bytes = view.parts[p].bytes, expected = composition.fields.bytesOf(p);
        EXPECT_TRUE(
            std::equal(bytes.values.begin(), bytes.values.end(), expected.values.begin(), expected.values.end()));
        EXPECT_TRUE(std::equal(bytes.distances.begin(), bytes.distances.end(), expected.distances.begin(),
                               expected.distances.end()));
    }
    ASSERT_EQ(view.residual.size(), asset.model.clusters.size());
    for (std::size_t c = 0; c < view.residual.size(); ++c)
        EXPECT_EQ(view.residual[c].first_vertex, asset.model.clusters[c].first_vertex);
}

// Half a step is the most that a number moves. The small step leaves coarse bands as they are.
TEST(ComposedAsset, CoarseFieldsAreWithinHalfAStep) {
    const PartFields fine = composedTube({}, {}).composition->fields;
    Largest moved;
    std::size_t changed = 0, kept = 0;
    for (const float step : {0.05f, 0.005f}) {
        PartFields coarse = fine;
        coarsenFields(step, coarse);
        for (std::size_t p = 0; p < fine.parts.size(); ++p) {
            const PartField &a = fine.parts[p], &b = coarse.parts[p];
            const std::size_t box = a.boxes[0].pointCount(), boxes = box + a.boxes[1].pointCount();
            const float coarsest = step * a.radius * a.radius;
            for (std::size_t i = 0; i < fine.values[p].size(); ++i) {
                const std::size_t point = i / kFieldCoefficients, level = std::size_t(point >= box) + (point >= boxes);
                const auto band = std::size_t(bandOfIndex(int(i % kFieldCoefficients)));
                const float scale = a.scale[level][band], other = b.scale[level][band];
                EXPECT_EQ(other, scale > 0 ? std::max(scale, coarsest) : 0);
                moved.add(std::abs(fine.values[p][i] * scale - coarse.values[p][i] * other) / coarsest);
                changed += fine.values[p][i] != coarse.values[p][i];
                kept += other == scale;
            }
            EXPECT_EQ(fine.distances[p], coarse.distances[p]);
        }
    }
    EXPECT_LE(moved, 0.501);
    EXPECT_GT(moved, 0.4);
    EXPECT_GT(changed, 1000u);
    EXPECT_GT(kept, 1000u);
}

TEST(ComposedAsset, RejectsEveryTruncation) { expectTruncationsRefused(tinyAsset()); }

// Most bytes are those of fields, which any byte suits, so half of the changes go to the rest of the file.
TEST(ComposedAsset, MutationsAreRefusedOrHarmless) {
    const std::vector<std::byte> whole = tinyAsset();
    std::mt19937 random(5);
    int refused = 0, used = 0;
    for (int trial = 0; trial < 3000; ++trial) {
        std::vector<std::byte> bytes = whole;
        const int changes = 1 + int(random() % 4);
        for (int i = 0; i < changes; ++i) {
            const std::size_t at = random() % 2 ? random() % bytes.size() : random() % 4000;
            bytes[at] = random() % 2 ? bytes[at] ^ std::byte(1u << random() % 8) : std::byte(random());
        }
        sealAsset(bytes);
        try {
            const AssetView asset = openAsset(bytes);
            ++used;
            useAsset(asset);
        } catch (const InvalidInput&) {
            ++refused;
        }
    }
    EXPECT_GT(refused, 150);
    EXPECT_GT(used, 150);
}

template <class Change>
std::string refusalAfter(const Change& change) {
    return refusalOf(tinyAsset(), [&](fbs::Asset& asset) {
        fbs::Model& model = *asset.mutable_model();
        change(model, *model.mutable_composition());
    });
}

TEST(ComposedAsset, NamesTheFieldThatIsWrong) {
    using fbs::Composition;
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const auto expect = [](const auto& change, const std::string& part) {
        const std::string message = refusalAfter([&](fbs::Model&, Composition& c) { change(c); });
        EXPECT_NE(message.find("x.pnb: model.composition." + part), std::string::npos)
            << message << " should say " << part;
    };
    const auto part = [](Composition& c) { return c.mutable_fields()->GetMutableObject(1); };
    const auto box = [&](Composition& c) { return part(c)->mutable_boxes()->GetMutableObject(1); };
    const auto cluster = [](Composition& c) { return c.mutable_residual()->GetMutableObject(1); };
    expect([&](Composition& c) { c.mutate_fade(0); }, "fade");
    expect([&](Composition& c) { c.mutate_fade(nan); }, "fade");
    expect([&](Composition& c) { c.mutable_part_of_vertex()->Mutate(2, 4); }, "part_of_vertex[2]");
    expect([](Composition& c) { c.mutate_near_count(5); }, "near_count");
    expect([](Composition& c) { c.mutate_near_count(1); }, "near_parts");
    // Part 1 of 4 has the near parts 0 and 2.
    for (const std::uint16_t wrong : {1, 3, 4, 2})
        expect([&](Composition& c) { c.mutable_near_parts()->Mutate(2, wrong); }, "near_parts entry ");
    expect([&](Composition& c) { part(c)->mutate_joint(4); }, "fields[1].joint");
    expect([&](Composition& c) { part(c)->mutate_radius(-1); }, "fields[1].radius");
    expect([&](Composition& c) { part(c)->mutable_center()->Mutate(2, nan); }, "fields[1].center");
    expect([&](Composition& c) { part(c)->mutable_scale()->Mutate(7, -1.0f); }, "fields[1].scale[7]");
    expect([&](Composition& c) { part(c)->mutate_distance_scale(INFINITY); }, "fields[1].distance_scale");
    expect([&](Composition& c) { box(c)->mutable_low()->Mutate(0, nan); }, "fields[1].boxes[1].low");
    expect([&](Composition& c) { box(c)->mutable_high()->Mutate(0, -9.0f); }, "fields[1].boxes[1].high");
    expect([&](Composition& c) { box(c)->mutable_size()->Mutate(0, 1); }, "fields[1].boxes[1].size[0]");
    expect([&](Composition& c) { box(c)->mutable_size()->Mutate(0, 65535); }, "fields[1].values");
    expect([&](Composition& c) { cluster(c)->mutate_joint(0); }, "residual[1].joint");
    expect([&](Composition& c) { cluster(c)->mutate_vertex_count(1); }, "residual[1].vertex_count");
    expect([&](Composition& c) { cluster(c)->mutable_bias()->Mutate(0, nan); }, "residual[1].bias");
    const std::string convention =
        refusalAfter([&](fbs::Model& m, Composition&) { const_cast<char*>(m.convention()->c_str())[0] = 'A'; });
    EXPECT_NE(convention, "accepted");
}

// Numbers of A4 and D5 both take 16 places, so nothing else is wrong with this file.
TEST(ComposedAsset, NeedsAMirroredConvention) {
    const Model model = composedTube({.joints = 4, .convention = parseConvention("A4")});
    try {
        packedTube({.precision = AssetPrecision::kI8}, model);
        FAIL();
    } catch (const InvalidInput& error) {
        EXPECT_NE(std::string(error.what()).find("composition"), std::string::npos) << error.what();
    }
}

TEST(ComposedAsset, StatesItsFieldsApart) {
    Model model = composedTube();
    synthetic::addNearParts(model, 2);
    const Packed packed = packedTube({.precision = AssetPrecision::kI8}, model);
    const AssetView asset = openAsset(packed.bytes);
    std::map<std::string, std::size_t> bytes;
    std::size_t sum = 0;
    for (const SizeOf& size : sectionSizes(asset, packed.bytes.size())) {
        bytes[size.section] = size.bytes;
        sum += size.bytes;
    }
    EXPECT_EQ(sum, packed.bytes.size());
    EXPECT_EQ(bytes["fields"], asset.model.composition->byteCount());
    EXPECT_EQ(bytes.count("visibility"), 0u);
    EXPECT_GT(bytes["residual"], 0u);
    EXPECT_EQ(bytes["near parts"], 2 * (model.mesh.vertexCount() + sizeof(std::uint16_t) * 5));
    EXPECT_EQ(modelBytes(asset, packed.bytes.size()), bytes["local"] + bytes["near parts"] + bytes["residual"] +
                                                          bytes["regression"] + bytes["names and layout"]);
}

TEST(ComposedAsset, RanksComponentsOfBothForOneBudget) {
    Model model = composedTube(
        {.rings = 12, .segments = 8, .joints = 5, .clusters = 3, .components = 8, .inputs = 6, .frames = 16});
    synthetic::turnJointsApart(model);
    const auto kept = [](const std::vector<ClusterView>& clusters) {
        std::size_t sum = 0;
        for (const ClusterView& c : clusters) sum += c.components();
        return sum;
    };
    const Packed all = packedTube({.precision = AssetPrecision::kI8}, model);
    EXPECT_EQ(all.components, 48u);
    const double bytes = double(modelBytes(openAsset(all.bytes), all.bytes.size())) / 96;
    double last = 0;
    for (double share : {0.8, 0.65, 0.5}) {
        const Packed packed = packedTube({.max_bytes_per_vertex = share * bytes}, model);
        const AssetView asset = openAsset(packed.bytes);
        EXPECT_LE(double(modelBytes(asset, packed.bytes.size())) / 96, share * bytes);
        EXPECT_EQ(kept(asset.model.clusters) + kept(asset.model.composition->residual), packed.components);
        // The energy of what was dropped predicts the error. Measured: .98 and 1.03.
        if (share < 0.8) {
            EXPECT_NEAR(packed.dropped_error / packed.quantization_error, 1, 0.1) << share;
        }
        EXPECT_GT(packed.quantization_error, last);
        last = packed.quantization_error;
    }
    // The residual varies less, so more of it goes.
    const Packed small = packedTube({.max_bytes_per_vertex = 0.75 * bytes}, model);
    const AssetView asset = openAsset(small.bytes);
    EXPECT_LT(kept(asset.model.composition->residual), kept(asset.model.clusters));
}

}  // namespace
}  // namespace penumbra::test_composed_asset
