// The parameter of a live material in the window, without a window.
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <filesystem>

#include "formats/common/write_file.h"
#include "pack/pack_asset.h"
#include "player/view/view_look.h"
#include "tests/runtime/count_allocations.h"
#include "tests/synthetic_model.h"

namespace penumbra::test_view_material {
namespace {

namespace fs = std::filesystem;

// A tube whose first material is live and whose second is not, and a library with a membrane.
class ViewMaterial : public testing::Test {
protected:
    fs::path folder = fs::path(testing::TempDir()) / ("view_material_" + std::to_string(getpid()));
    Scene scene;
    ViewState state;

    void SetUp() override {
        fs::create_directories(folder);
        BrdfFile live, membrane = synthetic::lambert();
        live.name = "live";
        live.slice_order = live.view_order = 1;
        live.even_index = {0};
        live.lobes = {lobeOf(parseBrdf("phong-live:exponent=10"))};
        membrane.name = "membrane";
        membrane.membrane = Membrane();
        const std::array materials = {live, synthetic::lambert()};
        const std::array lights = {synthetic::light(4, 0.5)};
        const std::array films = {membrane};
        const fs::path tube = folder / "tube.pnb", library = folder / "library.pnb";
        writeWholeFile(tube, packAsset(synthetic::tubeModel(), materials, lights, {}, "{}", 1).bytes);
        writeWholeFile(library, packLibrary(films, {}, "{}"));
        const std::array files = {tube, library};
        scene = openScene(files, 1);
        state = stateFor(scene, {});
        update();
    }
    void TearDown() override { fs::remove_all(folder); }
    const std::vector<Vec3>& update() {
        UpdateCost cost;
        updateScene(scene, state, {.values = true, .threads = 1}, cost);
        return (*scene.characters[0]->shown.values)[std::size_t(Shown::kModel)];
    }
};

TEST_F(ViewMaterial, TheSliderChangesWhatIsShown) {
    EXPECT_EQ(shownParameter(scene, state, 0), 10);
    EXPECT_EQ(shownRange(scene, 0)->name, "exponent");
    EXPECT_FALSE(shownRange(scene, 1));
    const std::vector<Vec3> before = update();
    chooseParameter(scene, state, 0, 300);
    const std::vector<Vec3> sharp = update();
    EXPECT_NE(sharp, before);
    chooseParameter(scene, state, 0, 1e9);
    EXPECT_EQ(shownParameter(scene, state, 0), 1000) << "within its range";
    chooseParameter(scene, state, 0, 10);
    EXPECT_EQ(update(), before);
    chooseParameter(scene, state, 1, 5);
    EXPECT_EQ(state.lighting.parameters.count(1), 0u) << "a material of tables has none";
}

// A drag adds nothing to a frame: the change itself makes no objects.
TEST_F(ViewMaterial, ADragMakesNothing) {
    ShadingSet& shading = *scene.characters[0]->shown.shading;
    chooseParameter(scene, state, 0, 20);  // the first choice takes a place in the map
    const std::size_t allocations = allocationCount();
    for (int step = 0; step < 100; ++step) {
        chooseParameter(scene, state, 0, 20 + step);
        setParameters(scene, state, shading);
    }
    EXPECT_EQ(allocationCount(), allocations);
    EXPECT_EQ(shading.lobesOf(0)[0].parameters[0], 119);
    const std::uint64_t version = shading.materialVersion();
    setParameters(scene, state, shading);
    EXPECT_EQ(shading.materialVersion(), version) << "nothing has changed";
}

TEST_F(ViewMaterial, AMembraneOnASolidIsNotPutOn) {
    chooseMaterial(state, 2);
    update();
    EXPECT_EQ(scene.characters[0]->shown.shading->materialOfSlot()[0], 0u);
}

}  // namespace
}  // namespace penumbra::test_view_material
