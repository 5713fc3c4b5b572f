#include "player/view_loop.h"

#include <chrono>
#include <cmath>
#include <cstdio>

#include "formats/errors.h"
#include "formats/write_file.h"
#include "player/screenshot.h"
#include "player/view_panels.h"
#include "player/view_window.h"

namespace penumbra {
namespace {

using Clock = std::chrono::steady_clock;

// After the last event ImGui still needs a few frames, for what appears under the pointer.
constexpr double kDrawAfterEvent = 0.3;  // seconds
constexpr double kIdleWait = 0.25;       // seconds between looks at whether to stop

struct ViewLoop {
    ViewLoop(const ViewOptions& options, int thread_count, bool be_quiet)
        : files(options.files),
          scene(openScene(files)),
          state(stateFor(scene, {})),
          window("Penumbra: " + options.files.front().filename().string(), {options.width, options.height}),
          painter(scene, options.path.value_or(window.software() ? EvaluationPath::kCpu : EvaluationPath::kGlsl)),
          screenshots(options.screenshots),
          threads(thread_count),
          quiet(be_quiet) {
        figures.gl = window.description();
        state.camera.vertical_fov = 35 * 3.14159265358979 / 180;
        state.camera.yaw = 0.35;
        state.camera.pitch = 0.15;
    }

    std::vector<std::filesystem::path> files;
    Scene scene;
    ViewState state;
    ViewWindow window;
    ScenePainter painter;
    ViewFigures figures;
    std::filesystem::path screenshots;
    int threads;
    bool quiet;
    std::size_t frames = 0;
    Clock::time_point last_frame = Clock::now(), last_event = Clock::now();

    void handle(const ViewEvents& events);
    void drawFrame();
    void takeScreenshot();
    void run();
};

std::string_view nameOf(Channel channel) {
    static constexpr std::string_view kNames[] = {"shaded", "ao", "error", "clusters", "normals"};
    return kNames[std::size_t(channel)];
}

std::string_view nameOf(Compare compare) {
    static constexpr std::string_view kNames[] = {"model", "truth", "side by side", "wipe", "difference"};
    return kNames[std::size_t(compare)];
}

std::string describe(const Scene& scene, const ViewState& state) {
    const ViewContents contents = contentsOf(scene);
    const ClipView& clip = selectedClip(state, contents);
    std::string text = "clip " + std::string(clip.name) + ", frame " +
                       std::to_string(shownFrame(state, contents, state.selected) - clip.first_frame) + ", " +
                       std::string(nameOf(state.channel)) + ", " + std::string(nameOf(shownCompare(state)));
    if (state.channel == Channel::kShaded)
        text += ", material " + std::string(scene.material_names[chosenMaterial(state)]) + ", light " +
                std::string(scene.light_names[state.light]);
    return text;
}

void ViewLoop::takeScreenshot() {
    state.screenshot = false;
    try {
        const std::filesystem::path path = freeScreenshotName(screenshots);
        writePng(path, readDisplayed(window.width(), window.height()), 1);
        figures.message = "wrote " + path.string();
        if (quiet) return;
        std::printf("%s: %s\n", path.c_str(), describe(scene, state).c_str());
        std::fflush(stdout);
    } catch (const IoError& error) {
        figures.message = error.what();
    }
}

void ViewLoop::handle(const ViewEvents& events) {
    const ViewContents contents = contentsOf(scene);
    for (const KeyPress& press : events.keys) {
        applyKey(state, contents, press);
        if (state.screenshot) drawFrame();  // of what the keys before it made of the picture
    }
    if (events.close) state.quit = true;
}

// In ImGui's coordinates.
Rectangle inUnits(const Rectangle& r, float scale) {
    const auto unit = [&](int pixels) { return int(std::lround(float(pixels) * scale)); };
    return {unit(r.x), unit(r.y), unit(r.width), unit(r.height)};
}

void ViewLoop::drawFrame() {
    if (!window.visible()) return;
    const Clock::time_point now = Clock::now();
    const double seconds = std::chrono::duration<double>(now - last_frame).count();
    last_frame = now;
    const ViewContents contents = contentsOf(scene);
    advanceView(state, contents, seconds);
    if (state.turntable) turntable(state.camera, seconds);
    figures.frame = 0.9 * figures.frame + 100 * seconds;  // smoothed over ten frames

    const Rectangle picture = pictureArea(window.width(), window.height(), window.scale(), state.panels);
    const UpdateNeeds needs{painter.needsValues(state), threads};
    updateScene(scene, state, needs, figures.update);
    if (state.frame_all) {
        const std::vector<Pane> panes = panesOf(state, picture);
        frameAll(state.camera, boundsOf(scene), double(panes.front().area.width) / panes.front().area.height);
        state.frame_all = false;
        updateScene(scene, state, needs, figures.update);  // seen from the new place
    }
    gl::BindFramebuffer(GL_FRAMEBUFFER, 0);
    painter.draw(state, window.height(), picture, figures.paint);
    if (state.screenshot && !state.screenshot_panels) takeScreenshot();
    window.beginPanels();
    figures.path = painter.path();
    const float to_units = window.unitScale() / window.scale();
    buildPanels(scene, state, figures, inUnits(picture, to_units), window.unitScale());
    applyMouse(scene, state, inUnits(picture, to_units));
    window.drawPanels();
    if (state.screenshot) takeScreenshot();
    checkGl("drawing a frame");
    window.present();
    ++frames;
}

void ViewLoop::run() {
    while (!state.quit) {
        throwIfInterrupted();
        const bool active = state.playhead.playing || state.turntable;
        const bool settled = std::chrono::duration<double>(Clock::now() - last_event).count() > kDrawAfterEvent;
        const bool waits = (!active && settled) || !window.visible();
        const ViewEvents events = window.poll(waits ? kIdleWait : 0);
        if (events.any || !waits) {
            if (waits) last_frame = Clock::now();  // the time that was waited is no time of the animation
            if (events.any) last_event = Clock::now();
            handle(events);
            drawFrame();
        }
    }
}

}  // namespace

ViewResult runView(const ViewOptions& options, int threads, bool quiet) {
    ViewLoop loop(options, threads, quiet);
    loop.run();
    return {loop.figures.gl, loop.painter.path(), loop.frames};
}

}  // namespace penumbra
