// Tests the files of a scene: which of them is a character, what the others bring, and what is computed again.
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <filesystem>

#include "formats/common/errors.h"
#include "formats/common/write_file.h"
#include "pack/pack_asset.h"
#include "pack/sections/material_section.h"
#include "player/view/shown_files.h"
#include "player/view/view_scene.h"
#include "tests/difference.h"
#include "tests/synthetic_model.h"

namespace penumbra::test_view_files {
namespace {

namespace fs = std::filesystem;

BrdfFile named(const std::string& name, Vec3d color) {
    BrdfFile brdf = synthetic::lambert(color);
    brdf.name = name;
    return brdf;
}

// A tube with its own material and light, and a file with one material and nothing else.
class ViewFiles : public testing::Test {
protected:
    // The folder belongs to this process, because tests of this suite run side by side.
    fs::path folder = fs::path(testing::TempDir()) / ("view_files_" + std::to_string(getpid()));
    fs::path tube = folder / "tube.pnb", library = folder / "library.pnb";

    void SetUp() override {
        fs::create_directories(folder);
        const std::array own = {named("grey", {0.5, 0.5, 0.5})};
        const std::array lights = {synthetic::light(4, 0.1)};
        writeWholeFile(
            tube, packAsset(synthetic::tubeModel(), own, lights, {.precision = AssetPrecision::kF32}, "{}", 1).bytes);
        FlatBufferBuilder builder;
        AssetSections sections;
        sections.materials.push_back(writeMaterial(builder, named("red", {0.5, 0.01, 0.01})));
        writeWholeFile(library, finishAsset(builder, sections, 5, "{}"));
    }
    void TearDown() override { fs::remove_all(folder); }
};

TEST_F(ViewFiles, AFileWithoutMeshAddsItsMaterials) {
    const std::array files = {tube, library};
    Scene scene = openScene(files, 1);
    ASSERT_EQ(scene.characters.size(), 1u);
    EXPECT_EQ(scene.material_names, (std::vector<std::string_view>{"grey", "red"}));
    ViewState state = stateFor(scene, {});
    const std::vector<Vec3>& values = (*scene.characters[0]->shown.values)[std::size_t(Shown::kModel)];
    UpdateCost cost;
    updateScene(scene, state, {.values = true, .threads = 1}, cost);
    const std::vector<Vec3> grey = values;
    chooseMaterial(state, 1);
    updateScene(scene, state, {.values = true, .threads = 1}, cost);
    ASSERT_EQ(values.size(), grey.size());
    for (std::size_t v = 0; v < grey.size(); ++v) {  // the colour alone differs: red as it was, green a fiftieth
        EXPECT_NEAR(values[v].x, grey[v].x, 1e-5f);
        EXPECT_NEAR(values[v].y, grey[v].y / 50, 1e-5f);
    }
}

// Its own material comes second then.
TEST_F(ViewFiles, ACharacterKeepsItsMaterialsWhateverTheOrder) {
    const std::array files = {library, tube, tube};
    const Scene scene = openScene(files, 1);
    ASSERT_EQ(scene.characters.size(), 2u);
    const ViewState state = stateFor(scene, {});
    EXPECT_EQ(scene.material_names[state.characters[0].material_of_slot[0]], "grey");
    EXPECT_EQ(state.characters[0].material_of_slot[0], 1u);
    EXPECT_EQ(state.characters[1].material_of_slot[0], 1u) << "the same file";
    EXPECT_LT(scene.characters[0]->placement.m[3], scene.characters[1]->placement.m[3]);
}

// A model that brings no materials and no light shows the scene's first ones, with slots and without, wherever it is
// named.
TEST_F(ViewFiles, AModelWithoutMaterialsShowsTheFirst) {
    Model model = synthetic::tubeModel();
    const fs::path bare = folder / "bare.pnb", slots = folder / "slots.pnb";
    writeWholeFile(bare, packAsset(model, {}, {}, {.precision = AssetPrecision::kF32}, "{}", 1).bytes);
    model.mesh.slots = {"skin", "cloth"};
    for (std::size_t v = 0; v < model.mesh.vertexCount(); ++v)
        model.mesh.slot_of_vertex.push_back(std::uint16_t(v % 2));
    writeWholeFile(slots, packAsset(model, {}, {}, {.precision = AssetPrecision::kF32}, "{}", 1).bytes);
    const std::array<std::array<fs::path, 4>, 3> orders = {
        {{tube, bare, slots, library}, {library, slots, bare, tube}, {bare, library, tube, slots}}};
    for (const auto& files : orders) {
        Scene scene = openScene(files, 1);
        ViewState state = stateFor(scene, {});
        UpdateCost cost;
        updateScene(scene, state, {.values = true, .threads = 1}, cost);
        for (std::size_t i = 0; i < scene.characters.size(); ++i) {
            const Character& character = *scene.characters[i];
            const bool own = fs::path(character.asset.name).filename() == tube.filename();
            ASSERT_EQ(character.asset.materials.size(), 2u);
            for (const std::size_t material : state.characters[i].material_of_slot)
                EXPECT_EQ(scene.material_names[material], own ? "grey" : scene.material_names[0]);
            EXPECT_EQ(character.shown.of(Shown::kModel).size(), character.asset.mesh.positions.size());
        }
    }
    // A file may also come by drop, after the scene was shown without it.
    const std::array one = {tube};
    const std::array two = {tube, slots};
    const ViewState before = stateFor(openScene(one, 1), {});
    EXPECT_EQ(stateFor(openScene(two, 1), before).characters[1].material_of_slot, (std::vector<std::size_t>{0, 0}));
}

// A file is mapped once, by whatever name, and its materials and lights are listed once.
TEST_F(ViewFiles, CharactersOfOneFileShareIt) {
    const fs::path copy = folder / "copy.pnb", link = folder / "link.pnb";
    fs::copy_file(tube, copy);
    fs::create_symlink(tube, link);
    const std::array files = {tube, link, copy, folder / "." / "tube.pnb"};
    const Scene scene = openScene(files, 1);
    ASSERT_EQ(scene.characters.size(), 4u);
    EXPECT_EQ(scene.files.size(), 2u);
    EXPECT_EQ(scene.material_names.size(), 2u);
    EXPECT_EQ(scene.light_names.size(), 2u);
    const auto positions = [&](std::size_t i) { return scene.characters[i]->asset.mesh.positions.data(); };
    EXPECT_EQ(positions(1), positions(0));
    EXPECT_EQ(positions(3), positions(0));
    EXPECT_NE(positions(2), positions(0));
}

TEST_F(ViewFiles, WhatWasChosenStaysWhenAFileIsAdded) {
    const std::array one = {tube};
    const Scene before = openScene(one, 1);
    ViewState state = stateFor(before, {});
    state.playhead.time = 0.3;
    state.inspect.picked = PickedVertex{0, 3};
    const std::array two = {tube, library};
    const ViewState after = stateFor(openScene(two, 1), state);
    EXPECT_EQ(after.playhead.time, 0.3);
    EXPECT_FALSE(after.inspect.picked);
    EXPECT_EQ(after.show.compare, Compare::kModel);
}

// Sliders add to what the pose gives. Other clusters, and the scores once they are taken back, are the pose's.
TEST_F(ViewFiles, ChangedScoresChangeTheirClusterOnly) {
    const std::array files = {tube};
    Scene scene = openScene(files, 1);
    ViewState state = stateFor(scene, {});
    state.show.channel = Channel::kAmbient;
    UpdateCost cost;
    updateScene(scene, state, {.values = true, .threads = 1}, cost);
    Character& character = *scene.characters[0];
    const std::vector<float> coefficients = character.posed.vertices.coefficients;
    const std::size_t cluster = character.asset.model.clusters.size() - 1;
    const ClusterView& view = character.asset.model.clusters[cluster];
    const float score = character.posed.evaluator->scores(cluster)[0];
    state.inspect.score_edit = ScoreEdit{0, cluster, {0.5f}};
    updateScene(scene, state, {.values = true, .threads = 1}, cost);
    EXPECT_FLOAT_EQ(character.posed.evaluator->scores(cluster)[0], score + 0.5f);
    const std::size_t stride = std::size_t(character.asset.model.stride);
    std::size_t changed = 0;
    for (std::size_t i = 0; i < coefficients.size(); ++i) {
        const std::size_t v = i / stride;
        const bool inside = v >= view.first_vertex && v < view.first_vertex + view.vertex_count;
        if (!inside) {
            EXPECT_EQ(character.posed.vertices.coefficients[i], coefficients[i]);
        }
        changed += character.posed.vertices.coefficients[i] != coefficients[i];
    }
    EXPECT_GT(changed, view.vertex_count / 2);
    state.inspect.score_edit.reset();
    updateScene(scene, state, {.values = true, .threads = 1}, cost);
    EXPECT_EQ(character.posed.vertices.coefficients, coefficients);
}

// The range holds the least and the largest score over training frames. Shares sum to 1, and are larger for
// components that move more.
TEST_F(ViewFiles, ComponentsHaveTheirTrainingRange) {
    const std::array files = {tube};
    Scene scene = openScene(files, 1);
    Character& character = *scene.characters[0];
    ScoreRanges ranges;
    for (int i = 0; i < 1000 && !ranges.complete(); ++i) ranges.compute(*character.timeline.evaluator, 0.01);
    ASSERT_TRUE(ranges.complete());
    const AnimationView& animation = character.asset.animation;
    for (std::size_t c = 0; c < character.asset.model.clusters.size(); ++c) {
        const std::vector<ComponentFigures> figures = ranges.figures(*character.posed.evaluator, c);
        ASSERT_EQ(figures.size(), character.asset.model.clusters[c].components());
        Largest most;
        float least = 1e9f;
        for (const ClipView& clip : animation.clips)
            for (std::size_t f = clip.first_frame; !clip.held_out && f < clip.first_frame + clip.frame_count; ++f) {
                character.posed.evaluator->setPose(animation.bonesOf(f), animation.poseOf(f));
                least = std::min(least, character.posed.evaluator->scores(c)[0]);
                most.add(character.posed.evaluator->scores(c)[0]);
            }
        EXPECT_EQ(figures[0].least, least);
        EXPECT_EQ(figures[0].most, most);
        float sum = 0;
        for (const ComponentFigures& figure : figures) sum += figure.share;
        EXPECT_NEAR(sum, most > least ? 1 : sum, 1e-5f);
    }
}

// Forms that the light or a material lacks are not used. Where all have a form, every ShadingSet is made anew, once.
TEST_F(ViewFiles, ShadingFormsAreUsedWhereTheyExist) {
    const std::array files = {tube, tube};
    Scene scene = openScene(files, 1);
    ViewState state = stateFor(scene, {});
    state.lighting.shading = {Reflectance::kOperators, LightForm::kFixed};
    const AssetView& asset = scene.characters[0]->asset;
    const bool operators = hasReflectance(asset.materials[0], Reflectance::kOperators);
    EXPECT_EQ(shownShading(scene, state),
              (ShadingChoice{operators ? Reflectance::kOperators : Reflectance::kSlices, LightForm::kFixed}));
    UpdateCost cost;
    EXPECT_TRUE(updateScene(scene, state, {.values = true, .threads = 1}, cost));
    EXPECT_FALSE(updateScene(scene, state, {.values = true, .threads = 1}, cost));
    for (const auto& character : scene.characters)
        EXPECT_EQ(character->shown.shading->choice().light_form, LightForm::kFixed);
    state.lighting.shading.light_form = LightForm::kLobes;
    ASSERT_FALSE(hasForm(asset.lights[0], LightForm::kLobes));
    EXPECT_EQ(shownShading(scene, state).light_form, LightForm::kRotation);
}

TEST_F(ViewFiles, FilesWithoutACharacterAreRefused) {
    const std::array none = {library};
    EXPECT_THROW(openScene(none, 1), InvalidInput);
    const std::array missing = {folder / "none.pnb"};
    EXPECT_THROW(openScene(missing, 1), IoError);
}

TEST_F(ViewFiles, ACharacterLeavesAndTheOthersStay) {
    const fs::path other = folder / "other.pnb", scene_file = folder / "s.json";
    fs::copy_file(tube, other);
    const std::vector<fs::path> files = {library, tube, other, tube};
    const Scene scene = openScene(files, 1);
    ASSERT_EQ(scene.characters.size(), 3u);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_TRUE(canLeave(scene, i));
    EXPECT_EQ(filesWithout(scene, files, 0), (std::vector<fs::path>{library, other, tube}));
    EXPECT_EQ(filesWithout(scene, files, 1), (std::vector<fs::path>{library, tube, tube}));
    EXPECT_EQ(filesWithout(scene, files, 2), (std::vector<fs::path>{library, tube, other}));
    EXPECT_EQ(filesWithoutAnyone(scene, files), (std::vector<fs::path>{library}));
    EXPECT_FALSE(canLeave(openScene(std::array{tube}, 1), 0)) << "the last one stays";
    writeWholeFile(scene_file, std::string(R"({"version": 1, "characters": [{"asset": "tube.pnb"}]})"));
    const std::vector<fs::path> with_scene = {scene_file, library, other};
    const Scene staged = openScene(with_scene, 1);
    EXPECT_FALSE(canLeave(staged, 0)) << "the scene's file names it";
    EXPECT_TRUE(canLeave(staged, 1));
    EXPECT_EQ(filesWithout(staged, with_scene, 1), (std::vector<fs::path>{scene_file, library}));
    EXPECT_EQ(filesWithoutAnyone(staged, with_scene), (std::vector<fs::path>{library}));
}

TEST_F(ViewFiles, WhatComesWithAFileIsShown) {
    const Scene one = openScene(std::array{tube}, 1);
    ViewState state = stateFor(one, {});
    const Scene richer = openScene(std::array{tube, library}, 1);
    EXPECT_EQ(showNewcomer(library, countsOf(one), richer, state), "opened library.pnb, 1 material more (M)");
    EXPECT_EQ(state, stateFor(one, {})) << "what is on stays on";
    const Scene two = openScene(std::array{tube, tube}, 1);
    state = stateFor(two, state);
    showNewcomer(tube, countsOf(one), two, state);
    EXPECT_EQ(state.selected, 1u) << "a character is selected";
}

// Materials and lights are numbered over all files, so a file that leaves moves the others'.
TEST_F(ViewFiles, WhatIsChosenKeepsItsNameWhenAFileLeaves) {
    const std::array all = {library, tube};
    const std::array left = {tube};
    const Scene with = openScene(all, 1), without = openScene(left, 1);
    ViewState state = stateFor(with, {});
    const std::size_t chosen = with.material_names.size() - 1;
    const auto at = std::ranges::find(without.material_names, with.material_names[chosen]);
    const auto gone = std::ranges::find_if(with.material_names, [&](std::string_view name) {
        return std::ranges::find(without.material_names, name) == without.material_names.end();
    });
    ASSERT_TRUE(at != without.material_names.end() && gone != with.material_names.end());
    std::ranges::fill(state.characters[0].material_of_slot, chosen);
    ViewState carried = stateFor(without, carriedOver(with, without, state));
    EXPECT_EQ(carried.characters[0].material_of_slot[0], std::size_t(at - without.material_names.begin()));
    std::ranges::fill(state.characters[0].material_of_slot, std::size_t(gone - with.material_names.begin()));
    carried = stateFor(without, carriedOver(with, without, state));
    for (const std::size_t material : carried.characters[0].material_of_slot)
        EXPECT_LT(material, without.material_names.size());
    EXPECT_LT(carried.lighting.light, without.light_names.size());
}

// A component is shown instead of the channel, and without a material.
TEST_F(ViewFiles, APictureIsDescribedByWhatIsOnIt) {
    const std::array files = {tube};
    const Scene scene = openScene(files, 1);
    ViewState state = stateFor(scene, {});
    const std::string shaded = describe(scene, state);
    EXPECT_NE(shaded.find(", frame 0, shaded, model, material grey, light "), std::string::npos) << shaded;
    state.show.component = 1;
    const std::string component = describe(scene, state);
    EXPECT_TRUE(component.ends_with(", frame 0, component 1, model")) << component;
}

// Nothing is skinned or evaluated again while only the eye, the light or the material changes.
TEST_F(ViewFiles, AFrameIsEvaluatedOnce) {
    const std::array files = {tube};
    Scene scene = openScene(files, 1);
    ViewState state = stateFor(scene, {});
    UpdateCost cost;
    updateScene(scene, state, {.values = true, .threads = 1}, cost);
    Character& character = *scene.characters[0];
    const Vec3 there = character.posed.vertices.positions[0];
    character.posed.vertices.positions[0] = {9, 9, 9};  // stays unless the frame is skinned again
    const double evaluate = cost.evaluate;
    EXPECT_GT(evaluate, 0);
    state.lighting.yaw = 40;
    state.camera.yaw = 1;
    updateScene(scene, state, {.values = true, .threads = 1}, cost);
    EXPECT_EQ(character.posed.vertices.positions[0], (Vec3{9, 9, 9}));
    EXPECT_EQ(cost.evaluate, evaluate) << "of the last evaluation";
    stepFrames(state.playhead, character.asset.animation, selectedClip(state, scene), 1);
    updateScene(scene, state, {.values = true, .threads = 1}, cost);
    EXPECT_NE(character.posed.vertices.positions[0], (Vec3{9, 9, 9}));
    EXPECT_LT(length(character.posed.vertices.positions[0] - there), 3);
}

}  // namespace
}  // namespace penumbra::test_view_files
