#include "player/view/window/live_loop.h"

#include <imgui.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdio>

#include "formats/camera/camera_file.h"
#include "formats/common/errors.h"
#include "formats/common/write_file.h"
#include "player/composite/live_plates.h"
#include "player/composite/live_tracker.h"
#include "player/composite/photograph_frames.h"
#include "player/composite/plate_poses.h"
#include "player/gl/gl_objects.h"
#include "player/gl/screenshot.h"
#include "player/view/window/view_window.h"

namespace penumbra {
namespace {

using Clock = std::chrono::steady_clock;

double millisecondsSince(Clock::time_point start) {
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

WindowPlace placeFor(const LiveOptions& options, const PinholeCamera& camera) {
    WindowPlace place;
    place.width = options.size ? options.size->first : std::clamp(camera.width, kMinWidth, kMaxWidth);
    place.height = options.size ? options.size->second : std::clamp(camera.height, kMinHeight, kMaxHeight);
    return place;
}

GlObject makeTexture() {
    GLuint id = 0;
    gl::GenTextures(1, &id);
    return GlObject(id, [](GLuint texture) { gl::DeleteTextures(1, &texture); });
}

class LiveLoop {
public:
    LiveLoop(const LiveOptions& options, int threads)
        : options_(options),
          threads_(threads),
          scene_(readScene(options.scene)),
          camera_(cameraOfScene()),
          window_("Penumbra: " + options.scene.filename().string(), placeFor(options, camera_)),
          frames_(readiedScene(), drawnHere(options.look), threads),
          plates_(options.plate, camera_.width, camera_.height),
          poses_(frames_.cameras(), plates_.files()),
          composer_(readResponse(options.response), float(options.exposure)),
          texture_(makeTexture()) {
        result_.gl = window_.description();
        if (!options.tags.empty()) tracker_.emplace(camera_, options.tags, readResponse(options.response), threads);
        if (options.ball)
            light_.emplace(turnedBall(), scene_.light()->order, readResponse(options.response), options.exposure);
    }
    LiveResult run();

private:
    const LiveOptions& options_;
    int threads_;
    PosedScene scene_;
    PinholeCamera camera_;
    ViewWindow window_;  // before everything that needs its context
    PhotographFrames frames_;
    LivePlates plates_;
    PlatePoses poses_;
    Composer composer_;
    GlObject texture_;
    std::optional<LiveTracker> tracker_;
    std::optional<LiveLight> light_;
    LiveResult result_;
    TrackedPose pose_;
    Plate plate_;
    PhotographFrame frame_;
    double compose_ = 0;  // milliseconds of the last picture
    double latency_ = 0;  // milliseconds from when the last picture was taken until it was shown
    bool quit_ = false, paused_ = false, panels_ = true, relit_ = false, screenshot_ = false;

    PinholeCamera cameraOfScene() const {
        if (!scene_.file().photograph)
            throw InvalidInput(options_.scene.string() + ": /camera: must be the camera of the photographs");
        return SceneCameras(scene_.file()).camera();
    }
    // A scene whose light will be that of a ball needs a sun that the ball's can take the place of.
    PosedScene& readiedScene() {
        if (options_.ball) scene_.addDarkSun();
        return scene_;
    }
    LiveBall turnedBall() const {
        LiveBall ball = *options_.ball;
        std::ranges::transform(scene_.lightRotation().m, ball.scene_turn.m.begin(), [](double x) { return float(x); });
        return ball;
    }
    static RenderOptions drawnHere(RenderOptions look) {
        look.backend = GlBackend::kCurrent;
        return look;
    }
    std::optional<CameraPose> poseOfScene() const;
    void handle(const ViewEvents& events);
    bool takePlate();
    void compose();
    void draw();
    void drawPanel() const;
    void takeScreenshot();
};

std::optional<CameraPose> LiveLoop::poseOfScene() const {
    if (!poses_.hasPose(plates_.number())) return std::nullopt;
    return frames_.cameras().view(*poses_.pictureOf(plates_.number()), {}).pose;
}

void LiveLoop::handle(const ViewEvents& events) {
    quit_ = quit_ || events.close || interrupted();
    for (const KeyPress& press : events.keys) {
        if (press.key == 'Q' || press.key == kKeyEscape) quit_ = true;
        if (press.key == ' ') paused_ = !paused_;
        if (press.key == kKeyTab) panels_ = !panels_;
        if (press.key == kKeyF12) screenshot_ = true;
    }
}

// Returns false while the camera has no picture yet, and at the end, when it quits.
bool LiveLoop::takePlate() {
    const LiveNext next = plates_.next(plate_);
    quit_ = quit_ || next == LiveNext::kEnded;
    if (next != LiveNext::kPicture) return false;
    if (plate_.width() != camera_.width || plate_.height() != camera_.height)
        throw InvalidInput(options_.plate.string() + ": picture " + std::to_string(plates_.number()) + " has " +
                           std::to_string(plate_.width()) + " x " + std::to_string(plate_.height()) +
                           " pixels, and the scene's camera has " + std::to_string(camera_.width) + " x " +
                           std::to_string(camera_.height));
    if (plate_.isLinear())
        throw InvalidInput(options_.plate.string() + ": a window shows codes of a camera, and this is linear light");
    ++result_.pictures;
    return true;
}

// Finds the pose and the light, and puts the characters into the photograph. Without a pose it stays as it is.
void LiveLoop::compose() {
    frame_.characters = {};
    frame_.ratio.assign(std::size_t(camera_.width) * std::size_t(camera_.height), Vec3{1, 1, 1});
    if (tracker_)
        pose_ = tracker_->track(plate_.codes);
    else
        pose_.pose = poseOfScene();
    result_.track += pose_.milliseconds;
    result_.seen += pose_.seen;
    const auto start = Clock::now();
    if (pose_.pose) {
        if (const LightView* light = light_ ? light_->update(plate_.codes, camera_, *pose_.pose, threads_) : nullptr) {
            frames_.replaceLight(*light);
            relit_ = true;
        }
        frames_.compute(*pose_.pose, std::nullopt, frame_);
    }
    const TexturePicture shown = composer_.compose(plate_, {frame_.characters, frame_.ratio}, {}, threads_);
    compose_ = millisecondsSince(start);
    result_.compose += compose_;
    gl::BindTexture(GL_TEXTURE_2D, texture_.id());
    gl::PixelStorei(GL_UNPACK_ALIGNMENT, 1);
    gl::TexImage2D(GL_TEXTURE_2D, 0, GL_RGB8, shown.width, shown.height, 0, GL_RGB, GL_UNSIGNED_BYTE, shown.rgb.data());
    gl::TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    gl::TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    gl::BindTexture(GL_TEXTURE_2D, 0);
}

void LiveLoop::drawPanel() const {
    ImGui::SetNextWindowPos({8, 8});
    ImGui::Begin("live", nullptr,
                 ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoMove |
                     ImGuiWindowFlags_NoSavedSettings);
    ImGui::Text("picture %zu", plates_.number());
    if (!tracker_ && !pose_.pose) ImGui::TextUnformatted("the poses have none of this picture");
    if (tracker_ && !pose_.pose)
        ImGui::TextUnformatted("no tag was seen yet");
    else if (tracker_)
        ImGui::Text("pose: %s, margin %.2f, %.2f px", pose_.seen ? "tag seen" : "tag lost, the last pose is kept",
                    pose_.margin, pose_.residual);
    if (pose_.twice) ImGui::TextUnformatted("a tag is visible twice: cover one");
    if (pose_.clipped) ImGui::TextUnformatted("the tag's paper is clipped: expose darker");
    if (light_) ImGui::Text("light: %s, %.0f ms", relit_ ? "of the ball" : "of the scene", light_->milliseconds());
    ImGui::Text("tags %.1f ms, composite %.1f ms", pose_.milliseconds, compose_);
    ImGui::Text("latency %.0f ms", latency_);
    ImGui::TextUnformatted("Space: pause, Tab: this panel, F12: screenshot, Q: quit");
    ImGui::End();
}

void LiveLoop::takeScreenshot() {
    screenshot_ = false;
    try {
        const std::filesystem::path path = freeScreenshotName(options_.screenshots);
        writePng(path, readDisplayed(0, 0, window_.width(), window_.height()), 1);
        std::printf("%s\n", path.c_str());
    } catch (const IoError& error) {
        std::fprintf(stderr, "penumbra-player: %s\n", error.what());
    }
}

void LiveLoop::draw() {
    if (!window_.visible()) return;
    gl::BindFramebuffer(GL_FRAMEBUFFER, 0);
    gl::Viewport(0, 0, window_.width(), window_.height());
    gl::ClearColor(0, 0, 0, 1);
    gl::Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    window_.beginPanels();
    const ImVec2 all = ImGui::GetIO().DisplaySize;
    const float scale = std::min(all.x / float(camera_.width), all.y / float(camera_.height));
    const ImVec2 size(scale * float(camera_.width), scale * float(camera_.height));
    const ImVec2 low((all.x - size.x) / 2, (all.y - size.y) / 2);
    ImGui::GetBackgroundDrawList()->AddImage(ImTextureID(std::intptr_t(texture_.id())), low,
                                             {low.x + size.x, low.y + size.y});
    if (panels_) drawPanel();
    window_.drawPanels();
    if (screenshot_) takeScreenshot();
    window_.present();
}

LiveResult LiveLoop::run() {
    while (!quit_) {
        handle(window_.poll(paused_ ? 0.1 : 0));
        if (quit_) break;
        const bool is_new = !paused_ && takePlate();
        if (quit_) break;
        if (is_new) compose();
        draw();
        if (!is_new) continue;
        latency_ = std::chrono::duration<double, std::milli>(Clock::now() - plates_.taken()).count();
        result_.latency += latency_;
        if (options_.pictures && result_.pictures >= *options_.pictures) quit_ = true;
    }
    const double shown = std::max<double>(1, double(result_.pictures));
    result_.track /= shown;
    result_.compose /= shown;
    result_.latency /= shown;
    return std::move(result_);
}

}  // namespace

LiveResult runLive(const LiveOptions& options, int threads) { return LiveLoop(options, threads).run(); }

}  // namespace penumbra
