#include "player/view/window/view_loop.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <utility>

#include "formats/common/errors.h"
#include "formats/common/write_file.h"
#include "player/composite/picture_stream.h"
#include "player/frame/framed_rest.h"
#include "player/gl/gpu_timer.h"
#include "player/gl/screenshot.h"
#include "player/view/folder_list.h"
#include "player/view/shown_files.h"
#include "player/view/view_actions.h"
#include "player/view/view_history.h"
#include "player/view/view_look.h"
#include "player/view/view_settings.h"
#include "player/view/window/first_file.h"
#include "player/view/window/view_panels.h"
#include "player/view/window/view_window.h"
#include "sh/angles.h"

namespace penumbra {
namespace {

using Clock = std::chrono::steady_clock;

// After the last event ImGui still needs a few frames for what appears under the pointer.
constexpr double kDrawAfterEvent = 0.3;  // seconds
constexpr double kIdleWait = 0.25;       // seconds between looks at whether to stop
constexpr double kStep = 0.002;          // seconds until the state may have changed by itself
constexpr double kStripTime = 3;         // milliseconds a frame for the strips of the timeline
const std::string kWrote = "wrote ";
constexpr int kTurntableRate = 25;  // pictures a second
constexpr std::size_t kTurntablePictures = kTurntableRate * std::size_t(kTurnSeconds);
constexpr double kStripTimeAtRest = 12;  // if the picture does not change

double secondsSince(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

WindowPlace placeFor(const ViewOptions& options, const ViewSettings& settings) {
    WindowPlace place = settings.window;
    if (options.size) std::tie(place.width, place.height) = *options.size;
    return place;
}

// Looks a little from above, and more so where every character lies flat.
double startPitch(const Scene& scene) {
    double least = std::numbers::pi;
    for (const auto& character : scene.characters) least = std::min(least, defaultPitch(framedRest(character->asset)));
    return std::max(least, radians(8));
}

ViewState startState(const Scene& scene, const ViewSettings& settings, const ViewOptions& options) {
    ViewState state = settings.state;
    state.lighting.shading = options.shading;
    state.window.hint &= options.settings;
    state.camera.yaw = 20 * kDegree;
    state.camera.pitch = startPitch(scene);
    state.camera.vertical_fov = 35 * kDegree;
    state = stateFor(scene, state);
    applySceneFile(scene, state);
    return state;
}

// Converts a rectangle to ImGui's coordinates.
Rectangle scaled(const Rectangle& r, float scale) {
    const auto unit = [&](int pixels) { return int(std::lround(float(pixels) * scale)); };
    return {unit(r.x), unit(r.y), unit(r.width), unit(r.height)};
}

// The writing of a sequence changes these.
struct KeptView {
    Sequence of = Sequence::kClip;
    Camera camera;
    Playhead playhead;
};

struct ClosedWhileReading {};  // the user closed the window before the files were read

class ViewLoop {
public:
    ViewLoop(const ViewOptions& options, int threads)
        : options_(options),
          threads_(threads),
          quiet_(options.quiet),
          settings_(options.settings ? readSettings(settingsPath(), result_.problem) : ViewSettings()),
          files_(options.files),
          scene_(std::make_unique<Scene>(openFirst())),
          state_(startState(*scene_, settings_, options)) {
        for (const std::filesystem::path& file : files_) noteRecent(state_.window.recent, file);
        openWindow();
        timer_ = std::make_unique<GpuTimer>();
        tellSettingsProblem();
        scene_->blend = LightBlend(options.fade);
        result_.gl = window_->description();
        result_.path = options.path.value_or(window_->software() ? EvaluationPath::kCpu : EvaluationPath::kGlsl);
        figures_.path = result_.path;
        figures_.software = window_->software();
    }
    ViewResult run();

private:
    const ViewOptions& options_;
    int threads_;
    bool quiet_;
    ViewResult result_;
    ViewSettings settings_;
    std::vector<std::filesystem::path> files_;
    std::unique_ptr<ViewWindow> window_;  // before everything that needs its context
    Clock::time_point last_bar_ = Clock::now();
    std::unique_ptr<Scene> scene_;
    ViewState state_;
    Cached<ShadingChoice, std::unique_ptr<ScenePainter>> painter_;  // it keeps references to everyone's shading
    Cached<FrameKey> drawn_;
    ViewHistory history_;
    std::optional<PictureSink> turn_;  // turntable that is being written
    std::filesystem::path turn_path_;
    std::optional<KeptView> kept_;     // while a sequence is written
    Cached<ExposedLook> exposed_;      // key of the measured automatic exposure
    std::unique_ptr<GpuTimer> timer_;  // needs the window's context
    ViewFigures figures_;
    Clock::time_point last_step_ = Clock::now(), last_frame_ = Clock::now(), last_event_ = Clock::now();

    void openWindow();
    std::string title() const;
    Scene openFirst();
    OpenChoice openChoice();
    void showReading(const std::filesystem::path& file, double share);
    void tellSettingsProblem();
    void handle(const ViewEvents& events);
    void addFiles(const std::vector<std::filesystem::path>& dropped);
    void takeAway(std::size_t character);
    void show(std::vector<std::filesystem::path> files);
    void advanceTime();
    void updatePicture(const Rectangle& picture);
    void updateExposure(const Rectangle& picture);
    void listFiles();
    void drawFrame();
    void write(const std::filesystem::path& path, const Image& image);
    void takeScreenshot(const Rectangle& part);
    void takeTurntablePicture(const Rectangle& picture);
    void takeSequencePicture(const Rectangle& picture);
    void keepView();
    bool busy() const;
    void keepSettings();
};

void ViewLoop::openWindow() {
    if (window_) return;
    window_ = std::make_unique<ViewWindow>(title(), placeFor(options_, settings_));
}

std::string ViewLoop::title() const {
    return files_.empty() ? "Penumbra" : "Penumbra: " + files_.front().filename().string();
}

// Reads the files of the command line, or one that the user chooses where there is none.
Scene ViewLoop::openFirst() {
    if (!files_.empty()) return openScene(files_, threads_, openChoice());
    openWindow();
    for (std::string problem;;) {
        const std::optional<std::filesystem::path> file = chooseFirstFile(*window_, settings_.state, problem);
        if (!file) throw ClosedWhileReading();
        try {
            const std::vector<std::filesystem::path> chosen = {shownFile(*file)};
            Scene scene = openScene(chosen, threads_, openChoice());
            files_ = chosen;
            window_->setTitle(title());
            return scene;
        } catch (const std::runtime_error& error) {
            problem = error.what();
        }
    }
}

OpenChoice ViewLoop::openChoice() {
    return {options_.reading, options_.textures,
            [this](const std::filesystem::path& file, double share) { showReading(file, share); }};
}

// Shows a bar while a large picture is read. The first call opens the window: what takes no time is read before it, so
// that wrong files need no display.
void ViewLoop::showReading(const std::filesystem::path& file, double share) {
    constexpr double kBarStep = 0.1;  // seconds
    if (window_ && secondsSince(last_bar_) < kBarStep) return;
    openWindow();
    last_bar_ = Clock::now();
    if (window_->poll(0).close) throw ClosedWhileReading();
    if (!window_->visible()) return;
    beginEmptyPicture(*window_);
    buildReadingPanel(file.filename().string(), float(share), window_->unitScale());
    window_->drawPanels();
    window_->present();
}

// Tells the problem at the start, since a window may stay open for long.
void ViewLoop::tellSettingsProblem() {
    if (result_.problem.empty()) return;
    std::fprintf(stderr, "penumbra-player: %s\n", result_.problem.c_str());
    figures_.message = std::exchange(result_.problem, {});
}

// Adds dropped files. A file that cannot be used changes nothing.
void ViewLoop::addFiles(const std::vector<std::filesystem::path>& dropped) {
    const bool is_scene = std::ranges::any_of(dropped, [](const auto& file) { return file.extension() == ".json"; });
    std::vector<std::filesystem::path> files = is_scene ? filesWithoutAnyone(*scene_, files_) : files_;
    const SceneCounts before = countsOf(*scene_);
    try {
        for (const std::filesystem::path& file : dropped) files.push_back(shownFile(file));
        show(std::move(files));
        for (const std::filesystem::path& file : dropped) noteRecent(state_.window.recent, file);
        if (is_scene) applySceneFile(*scene_, state_);
        figures_.message = is_scene ? "opened " + dropped.back().filename().string()
                                    : showNewcomer(dropped.back(), before, *scene_, state_);
    } catch (const std::runtime_error& error) {
        figures_.message = error.what();
    }
}

void ViewLoop::takeAway(std::size_t character) {
    const ViewState before = state_;
    state_.characters.erase(state_.characters.begin() + std::ptrdiff_t(character));
    if (state_.selected > character) --state_.selected;
    const std::string name = scene_->characters[character]->asset.name;
    try {
        show(filesWithout(*scene_, files_, character));
        figures_.message = std::filesystem::path(name).filename().string() + " is gone; F2 opens it again";
    } catch (const std::runtime_error& error) {  // a file that has gone
        state_ = before;
        figures_.message = error.what();
    }
}

// Shows these files in the place of those before. Throws the errors of openScene(), and changes nothing then.
void ViewLoop::show(std::vector<std::filesystem::path> files) {
    auto scene = std::make_unique<Scene>(openScene(files, threads_, openChoice()));
    scene->blend = LightBlend(options_.fade);
    state_ = carriedOver(*scene_, *scene, state_);
    scene_ = std::move(scene);
    files_ = std::move(files);
    window_->setTitle(title());
    history_.forget();
    painter_.forget();
    exposed_.forget();
    state_ = stateFor(*scene_, state_);
}

std::string stopped(Sequence of, std::size_t written) {
    if (of == Sequence::kTurntable) return "stopped: no turntable is written";
    return "stopped: " + std::to_string(written) + " pictures are written";
}

void ViewLoop::handle(const ViewEvents& events) {
    if (!events.dropped.empty()) addFiles(events.dropped);
    if (const auto chosen = std::exchange(state_.window.chosen, {})) addFiles({*chosen});
    if (const auto leaving = std::exchange(state_.window.leaving, {})) takeAway(*leaving);
    // A picture of the window shows what it says, but not that the picture before was written.
    const bool other = std::ranges::any_of(events.keys, [](const KeyPress& press) { return press.key != kKeyF12; });
    if (figures_.message.starts_with(kWrote) && !events.keys.empty()) figures_.message.clear();
    if (other || events.clicked) {
        figures_.message.clear();
        state_.window.hint = false;
    }
    const std::optional<std::size_t> written = state_.window.sequence;
    for (const KeyPress& press : events.keys) {
        if (press.key == kKeyEscape && window_->listOpen()) {
            state_.window.closes_list = true;
            continue;
        }
        const ViewState before = state_;
        applyKey(state_, *scene_, press);
        const bool changed = state_ != before;
        const std::string why = changed ? whyUnseen(state_, *scene_, press) : whyNothing(press);
        if (!changed || !why.empty()) figures_.message = why;
        if (const int steps = std::exchange(state_.window.undone, 0))
            if (!history_.go(state_, steps)) figures_.message = steps < 0 ? "no view before" : "no view after";
        if (!state_.window.screenshot) continue;
        advanceTime();
        drawFrame();  // shows the state after the keys so far
    }
    if (written && !state_.window.sequence) figures_.message = stopped(state_.window.of, *written);
    if (events.close) state_.window.quit = true;
}

void ViewLoop::write(const std::filesystem::path& path, const Image& image) {
    try {
        writePng(path, image, 1);
        figures_.message = kWrote + std::filesystem::absolute(path).lexically_normal().string();
        if (quiet_) return;
        std::printf("%s: %s\n", path.c_str(), describe(*scene_, state_).c_str());
        std::fflush(stdout);
    } catch (const IoError& error) {
        figures_.message = error.what();
        state_.window.sequence.reset();
    }
}

std::string progress(std::size_t written, std::size_t of) {
    return std::to_string(written) + " of " + std::to_string(of) + " (Escape stops)";
}

Image readPart(const Rectangle& part, int window_height) {
    return readDisplayed(part.x, window_height - part.y - part.height, part.width, part.height);
}

void ViewLoop::takeScreenshot(const Rectangle& part) {
    state_.window.screenshot = false;
    write(freeScreenshotName(options_.screenshots), readPart(part, window_->height()));
}

// Writes pictures of a whole turn as a video that begins with the first and ends with the last.
void ViewLoop::takeTurntablePicture(const Rectangle& picture) {
    try {
        if (!turn_) {
            turn_path_ = freeTurntableName(options_.screenshots);
            turn_.emplace(turn_path_, nullptr, kTurntableRate);
        }
        const Image image = readPart(picture, window_->height());
        turn_->write(*state_.window.sequence, TexturePicture{image.width, image.height, displayedBytes(image, 1)});
        const std::size_t written = ++*state_.window.sequence;
        figures_.message = "turntable: " + progress(written, kTurntablePictures);
        if (written < kTurntablePictures) return;
        turn_->finish();
        figures_.message = kWrote + std::filesystem::absolute(turn_path_).lexically_normal().string();
        if (!quiet_) std::printf("%s: turntable, %s\n", turn_path_.c_str(), describe(*scene_, state_).c_str());
        std::fflush(stdout);
    } catch (const std::runtime_error& error) {  // nothing can be written, or the window got another size
        figures_.message = error.what();
    }
    turn_.reset();
    state_.window.sequence.reset();
}

void ViewLoop::takeSequencePicture(const Rectangle& picture) {
    if (state_.window.of == Sequence::kTurntable) return takeTurntablePicture(picture);
    const ClipView& clip = selectedClip(state_, *scene_);
    write(sequenceName(options_.screenshots, clip.name, *state_.window.sequence), readPart(picture, window_->height()));
    if (!state_.window.sequence) return;
    const std::size_t written = ++*state_.window.sequence;
    if (written < clip.frame_count)
        figures_.message = "pictures: " + progress(written, clip.frame_count);
    else
        state_.window.sequence.reset();
}

// Notes what a sequence changes when it begins, and brings it back when it is written or stopped.
void ViewLoop::keepView() {
    if (state_.window.sequence && !kept_) kept_ = KeptView{state_.window.of, state_.camera, state_.playhead};
    if (state_.window.sequence || !kept_) return;
    if (kept_->of == Sequence::kTurntable)
        state_.camera = kept_->camera;
    else
        state_.playhead = kept_->playhead;
    kept_.reset();
}

void ViewLoop::advanceTime() {
    keepView();
    const bool turns = state_.window.sequence && state_.window.of == Sequence::kTurntable;
    if (!turns) turn_.reset();  // it was stopped
    // A video has its own time. Its first picture is what the window shows.
    const double seconds = !turns ? secondsSince(last_step_) : *state_.window.sequence > 0 ? 1.0 / kTurntableRate : 0.0;
    last_step_ = Clock::now();
    const ClipView& clip = selectedClip(state_, *scene_);
    const AnimationView& animation = scene_->characters[state_.selected]->asset.animation;
    if (state_.window.sequence && !turns) {
        state_.playhead.playing = false;
        showClipTime(state_, frameSeconds(animation, clip,
                                          std::min<std::size_t>(*state_.window.sequence, clip.frame_count - 1)));
    }
    advanceView(state_, *scene_, seconds);
    if (state_.turntable || turns) turntable(state_.camera, seconds);
    advanceLight(*scene_, state_, seconds);
    computeStrips(*scene_, state_, state_.playhead.playing || state_.turntable ? kStripTime : kStripTimeAtRest);
}

void ViewLoop::updatePicture(const Rectangle& picture) {
    painter_.update(shownShading(*scene_, state_), [&](std::unique_ptr<ScenePainter>& painter) {
        painter = std::make_unique<ScenePainter>(*scene_, result_.path);
    });
    const UpdateNeeds needs = (*painter_)->needs(state_, threads_);
    if (const auto stroke = std::exchange(state_.tool.stroke, {}); stroke && scene_->field)
        scene_->field->brush(stroke->at, stroke->radius, stroke->rise);
    updateScene(*scene_, state_, needs, figures_.update);
    if (std::exchange(state_.window.worst_point, false)) pickWorst(state_, *scene_);
    if (!state_.frame_all) return;
    const Rectangle area = panesOf(state_, picture).front().area;
    frameAll(state_.camera, boundsOf(*scene_), double(area.width) / area.height);
    state_.frame_all = false;
    updateScene(*scene_, state_, needs, figures_.update);  // seen from the new place
}

void ViewLoop::updateExposure(const Rectangle& picture) {
    if (!state_.automatic_exposure) return exposed_.forget();
    if (showsShadedColors(*scene_, state_))
        exposed_.update(exposedLook(*scene_, state_),
                        [&](auto&) { state_.display.exposure = (*painter_)->measureExposure(state_, picture); });
}

void ViewLoop::drawFrame() {
    if (!window_->visible()) return;
    figures_.frame = 0.9 * figures_.frame + 100 * secondsSince(last_frame_);  // milliseconds, smoothed over ten frames
    last_frame_ = Clock::now();
    const int width = window_->width(), height = window_->height();
    const Rectangle picture =
        showsPanels(state_) ? pictureArea(width, height, window_->scale()) : Rectangle{0, 0, width, height};
    updatePicture(picture);
    updateExposure(picture);
    listFiles();
    drawn_.update(frameKey(*scene_, state_));
    gl::BindFramebuffer(GL_FRAMEBUFFER, 0);
    timer_->begin();
    (*painter_)->draw(state_, height, picture, figures_.paint);
    timer_->end();
    figures_.gpu = timer_->milliseconds();
    if (state_.window.screenshot && !state_.window.screenshot_panels) takeScreenshot(picture);
    if (state_.window.sequence) takeSequencePicture(picture);
    window_->beginPanels();
    const Rectangle in_units = scaled(picture, window_->unitScale() / window_->scale());
    buildPanels(*scene_, state_, figures_, in_units, window_->unitScale());
    applyMouse(*scene_, state_, in_units);
    if (!state_.turntable && !state_.window.sequence && !window_->held()) history_.note(state_);
    window_->drawPanels();
    if (state_.window.screenshot && state_.window.screenshot_panels) takeScreenshot({0, 0, width, height});
    checkGl("drawing a frame");
    window_->present();
    ++result_.frames;
}

// Reads the folder that is shown, when it is opened and not at every frame.
void ViewLoop::listFiles() {
    if (!state_.window.browsed) return figures_.folder.forget();
    figures_.folder.update(*state_.window.browsed,
                           [&](FolderList& list) { list = listFolder(*state_.window.browsed); });
}

// Tells whether the state changes by itself.
bool ViewLoop::busy() const {
    return state_.playhead.playing || state_.turntable || state_.window.sequence || state_.awaited ||
           state_.tool.stroke || scene_->blend.active() || !stripsAreComplete(*scene_, state_);
}

void ViewLoop::keepSettings() {
    const std::filesystem::path path = settingsPath();
    if (!options_.settings || path.empty()) return;
    try {
        writeSettings(path, {window_->place(), state_});
    } catch (const IoError& error) {
        result_.problem = error.what();
    }
}

ViewResult ViewLoop::run() {
    bool drew = true;
    while (!state_.window.quit) {
        throwIfInterrupted();
        const bool waits = (!busy() && secondsSince(last_event_) > kDrawAfterEvent) || !window_->visible();
        const ViewEvents events = window_->poll(waits ? kIdleWait : drew ? 0 : kStep);
        if (waits && !events.any) continue;
        if (waits) last_step_ = last_frame_ = Clock::now();  // the time that was waited is no time of the animation
        if (events.any) last_event_ = Clock::now();
        handle(events);
        advanceTime();
        drew = secondsSince(last_event_) < kDrawAfterEvent || drawn_.key() != frameKey(*scene_, state_);
        if (drew) drawFrame();
    }
    keepSettings();
    return result_;
}

}  // namespace

ViewResult runView(const ViewOptions& options, int threads) {
    try {
        return ViewLoop(options, threads).run();
    } catch (const ClosedWhileReading&) {
        return {};
    }
}

}  // namespace penumbra
