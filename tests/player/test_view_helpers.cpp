// Tests what the window does for its user beside drawing: views to go back to, files to open, names, and why a key did
// nothing.
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "formats/common/errors.h"
#include "player/view/folder_list.h"
#include "player/view/material_label.h"
#include "player/view/view_actions.h"
#include "player/view/view_controls.h"
#include "player/view/view_history.h"
#include "player/view/view_layout.h"

namespace penumbra::test_view_helpers {
namespace {

namespace fs = std::filesystem;

ViewState seenFrom(double yaw) {
    ViewState state;
    state.characters = {{0, {0}}};
    state.camera.yaw = yaw;
    return state;
}

TEST(ViewHistory, GoesBackAndForth) {
    ViewHistory history;
    ViewState state = seenFrom(0);
    EXPECT_FALSE(history.go(state, -1)) << "nothing was noted";
    history.note(state);
    for (const double yaw : {0.1, 0.2, 0.2, 0.3}) {
        state.camera.yaw = yaw;
        history.note(state);
    }
    EXPECT_TRUE(history.go(state, -1));
    EXPECT_EQ(state.camera.yaw, 0.2);
    EXPECT_TRUE(history.go(state, -1)) << "a view that stays is noted once";
    EXPECT_EQ(state.camera.yaw, 0.1);
    EXPECT_TRUE(history.go(state, 2));
    EXPECT_EQ(state.camera.yaw, 0.3);
    EXPECT_FALSE(history.go(state, 1));
    EXPECT_TRUE(history.go(state, -9)) << "as far as there are any";
    EXPECT_EQ(state.camera.yaw, 0);
    EXPECT_FALSE(history.go(state, -1));
}

TEST(ViewHistory, ForgetsWhatWasLeft) {
    ViewHistory history;
    ViewState state = seenFrom(0);
    history.note(state);
    state.show.ground = true;
    state.lighting.light = 1;
    history.note(state);
    history.go(state, -1);
    EXPECT_FALSE(state.show.ground);
    EXPECT_EQ(state.lighting.light, 0u);
    history.note(state);  // the view that was gone back to is no new one
    EXPECT_TRUE(history.go(state, 1));
    EXPECT_TRUE(state.show.ground);
    history.go(state, -1);
    state.camera.pitch = 1;
    history.note(state);
    EXPECT_FALSE(history.go(state, 1)) << "another way was taken";
    history.forget();
    EXPECT_FALSE(history.go(state, -1));
}

TEST(ViewHistory, LeavesTimeAndMeasuredExposureAlone) {
    ViewHistory history;
    ViewState state = seenFrom(0);
    history.note(state);
    state.playhead.time = 3;
    state.display.exposure = 2;
    history.note(state);
    EXPECT_FALSE(history.go(state, -1)) << "neither is another view";
    state.camera.yaw = 1;
    history.note(state);
    state.display.exposure = 5;
    EXPECT_TRUE(history.go(state, -1));
    EXPECT_EQ(state.playhead.time, 3);
    EXPECT_EQ(state.display.exposure, 5);
}

class FolderListTest : public testing::Test {
protected:
    fs::path folder = fs::path(testing::TempDir()) / ("folder_list_" + std::to_string(getpid()));
    void SetUp() override {
        fs::create_directories(folder / "b");
        fs::create_directories(folder / "a");
        fs::create_directories(folder / ".hidden");
        for (const char* name : {"x.pnb", "x.glb", "lonely.glb", "sky.exr", "report.json", "notes.txt", ".secret.pnb"})
            std::ofstream(folder / name) << "x";
        std::ofstream(folder / "scene.json") << R"({"version": 1, "characters": []})";
    }
    void TearDown() override { fs::remove_all(folder); }
    static std::vector<std::string> namesOf(const std::vector<fs::path>& paths) {
        std::vector<std::string> names;
        for (const fs::path& path : paths) names.push_back(path.filename().string());
        return names;
    }
};

TEST_F(FolderListTest, HasFoldersAndWhatTheWindowOpens) {
    const FolderList list = listFolder(folder);
    EXPECT_EQ(namesOf(list.folders), (std::vector<std::string>{"a", "b"}));
    EXPECT_EQ(namesOf(list.files), (std::vector<std::string>{"scene.json", "sky.exr", "x.glb", "x.pnb"}));
    EXPECT_TRUE(list.folder.is_absolute());
    EXPECT_EQ(list.problem, "");
    EXPECT_NE(listFolder(folder / "none").problem, "");
}

TEST_F(FolderListTest, ACharactersFileStandsForTheAssetBesideIt) {
    EXPECT_EQ(shownFile(folder / "x.glb"), folder / "x.pnb");
    EXPECT_EQ(shownFile(folder / "sky.exr"), folder / "sky.exr");
    EXPECT_THROW(shownFile(folder / "lonely.glb"), InvalidInput);
}

TEST_F(FolderListTest, FilesThatWereOpenedLastStayFew) {
    std::vector<fs::path> recent;
    for (int i = 0; i < 12; ++i) {
        const fs::path file = folder / ("f" + std::to_string(i) + ".pnb");
        std::ofstream(file) << "x";
        noteRecent(recent, file);
    }
    ASSERT_EQ(recent.size(), 8u);
    EXPECT_EQ(recent.front().filename(), "f11.pnb");
    noteRecent(recent, folder / "f9.pnb");
    noteRecent(recent, folder / "gone.pnb");
    EXPECT_EQ(recent.size(), 8u) << "each once, and none that is not there";
    EXPECT_EQ(recent.front().filename(), "f9.pnb");
}

TEST(MaterialLabel, NamesModelsAndTheirParameters) {
    EXPECT_EQ(materialLabel("ggx:alpha=0.3,f0=0.9"), "GGX, alpha 0.3, f0 0.9");
    EXPECT_EQ(materialLabel("lambert"), "Lambert");
    EXPECT_EQ(materialLabel("lambert:color=1/0.6/0.2+phong:exponent=30"),
              "Lambert, color 1/0.6/0.2 + Phong, exponent 30");
    for (const char* name : {"", "skin", "green paint", "gold+leaf", "merl: gold"})
        EXPECT_EQ(materialLabel(name), name);
}

TEST(WhyNothing, SaysWhatAKeyNeeds) {
    EXPECT_EQ(whyNothing({'T', false}),
              "T (baked truth or model) needs a baked truth (F2 opens one), and a shaded picture "
              "or ambient visibility (1, 2)");
    EXPECT_EQ(whyNothing({';', false}), "; is not a key of this window; F1 lists them");
    EXPECT_EQ(whyNothing({340, true}), "") << "Shift alone";
}

TEST(Controls, EachSaysWhatItDoes) {
    for (const Control& control : controls()) {
        EXPECT_GT(std::string(control.tip).size(), 10u) << control.id;
        EXPECT_TRUE(control.name || std::holds_alternative<Switch>(control.does) ||
                    control.panel == ControlPanel::kTime)
            << control.id << " has no name";
    }
}

TEST(PanelSizes, LeaveASmallWindowsPicture) {
    const PanelSizes large = panelSizes(1280, 800, 1), dense = panelSizes(2560, 1600, 2),
                     small = panelSizes(480, 320, 1);
    EXPECT_EQ(dense.side, 2 * large.side);
    EXPECT_EQ(dense.timeline, 2 * large.timeline);
    EXPECT_LT(small.side, 0.45f * 480);
    EXPECT_LT(small.timeline, 0.4f * 320);
}

}  // namespace
}  // namespace penumbra::test_view_helpers
