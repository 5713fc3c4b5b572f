// The materials that penumbra-pack makes of the looks of a source file.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/brdf/fit_slices.h"
#include "formats/common/errors.h"
#include "pack/sections/look_section.h"
#include "pack/sections/source_materials.h"
#include "sh/brdf/brdf_sum.h"
#include "tests/difference.h"

namespace penumbra::test_source_materials {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

SourceLooks twoLooks() {
    SourceLook red{.material = "Red", .principled = {.color = {0.8, 0.1, 0.1}, .roughness = 0.4}};
    SourceLook gold{.material = "Gold", .principled = {.color = {1, 0.7, 0.3}, .metallic = 1, .roughness = 0.4}};
    red.textures = {"base color", "normal"};
    gold.notes = {"KHR_materials_clearcoat is not read"};
    gold.principled.emission = {1, 2, 3};
    return {{{"Body/Red", red}, {"Body/Gold", gold}, {"Hat/Red", red}}, {}, {}};
}

// The parts add up to the slices of the whole. Measured: 3e-4, as the grids of the whole settle at other sizes.
TEST(SourceMaterials, HaveTheSlicesOfTheirSums) {
    const SourceMaterials made = materialsOf(twoLooks(), {}, 5, 1);
    ASSERT_EQ(made.materials.size(), 2u) << "two slots share one";
    for (const BrdfFile& brdf : made.materials) {
        const BrdfSum sum = parseBrdfSum(brdf.name);
        EXPECT_EQ(brdf.lobes, lobesOf(sum));
        EXPECT_EQ(brdf.emission, toFloat(sum.emission));
        const std::vector<double> whole = fitSlices(settledSlices(sumBrdf(sum), 5, 1), {});
        const double error = relativeDifference(brdf.slices, whole);
        EXPECT_LT(error, 1e-3) << brdf.name;
        RecordProperty("error", std::to_string(error));
    }
}

TEST(SourceMaterials, AreThoseOfTheMeshsSlots) {
    const std::vector<std::string> slots = {"Hat/Red", "Body/Gold", "Shoe/Black"};
    const SourceMaterials made = materialsOf(twoLooks(), slots, 5, 1);
    EXPECT_THAT(made.of_slot, ElementsAre(made.materials[0].name, made.materials[1].name, ""));
    EXPECT_THAT(made.said, ElementsAre(HasSubstr("textures: base color, normal"), HasSubstr("metallic=1")));
    EXPECT_THAT(made.warnings, ElementsAre("material 'Gold': KHR_materials_clearcoat is not read",
                                           HasSubstr("slot 'Shoe/Black' is not in the file")));
    Mesh mesh;
    mesh.slots = slots;
    EXPECT_THAT(slotMaterials(mesh, made.materials, made.of_slot, {}), ElementsAre(0, 1, 0));
    const std::vector<SlotChoice> hat = {{"Hat", made.materials[1].name}};
    EXPECT_THAT(slotMaterials(mesh, made.materials, made.of_slot, hat), ElementsAre(1, 1, 0));
}

TEST(SourceMaterials, DamageIsNamed) {
    SourceLooks looks = twoLooks();
    looks.slots[1].look.problem = "baseColorFactor has 2 numbers";
    try {
        materialsOf(looks, {}, 5, 1);
        ADD_FAILURE();
    } catch (const InvalidInput& error) {
        EXPECT_THAT(error.what(), HasSubstr("slot 'Body/Gold': material 'Gold': baseColorFactor has 2 numbers"));
    }
    const std::vector<std::string> unharmed = {"Hat/Red"}, unknown = {"Coat/Blue"};
    EXPECT_EQ(materialsOf(looks, unharmed, 5, 1).materials.size(), 1u);
    EXPECT_THROW(materialsOf(looks, unknown, 5, 1), InvalidInput);
}

}  // namespace
}  // namespace penumbra::test_source_materials
