#include "player/view/window/view_window.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "formats/common/errors.h"
#include "player/gl/gl_context_backends.h"
#include "player/gl/gl_loader.h"

namespace penumbra {

static_assert(kKeyTab == GLFW_KEY_TAB && kKeyRight == GLFW_KEY_RIGHT && kKeyLeft == GLFW_KEY_LEFT &&
              kKeyDown == GLFW_KEY_DOWN && kKeyUp == GLFW_KEY_UP && kKeyPageUp == GLFW_KEY_PAGE_UP &&
              kKeyPageDown == GLFW_KEY_PAGE_DOWN && kKeyHome == GLFW_KEY_HOME && kKeyF1 == GLFW_KEY_F1 &&
              kKeyF2 == GLFW_KEY_F2 && kKeyBackspace == GLFW_KEY_BACKSPACE && kKeyF11 == GLFW_KEY_F11 &&
              kKeyF12 == GLFW_KEY_F12 && kKeyEscape == GLFW_KEY_ESCAPE);

struct ViewWindow::Impl {
    GLFWwindow* window = nullptr;
    GlContext context;
    ViewEvents events;
    float font_scale = 0;  // scale for which the font was made

    void open(const std::string& title, const WindowPlace& place);
    void load();  // entry points and description of the current context
    ~Impl() {
        if (ImGui::GetCurrentContext()) {
            ImGui_ImplOpenGL3_Shutdown();
            ImGui_ImplGlfw_Shutdown();
            ImGui::DestroyContext();
        }
        if (window) glfwDestroyWindow(window);
        glfwTerminate();
    }
};

namespace {

std::string& lastGlfwError() {
    static std::string text;
    return text;
}

// ImGui's callbacks call those that were set before them.
ViewEvents& noteEvent(GLFWwindow* window) {
    auto& events = *static_cast<ViewEvents*>(glfwGetWindowUserPointer(window));
    events.any = true;
    return events;
}

void onKey(GLFWwindow* window, int key, int, int action, int mods) {
    ViewEvents& events = noteEvent(window);
    if (action == GLFW_RELEASE || ImGui::GetIO().WantTextInput) return;
    const bool shift = (mods & GLFW_MOD_SHIFT) != 0;
    if ((mods & GLFW_MOD_CONTROL) != 0 && key == 'Z') events.keys.push_back({kKeyBackspace, shift});
    if ((mods & GLFW_MOD_CONTROL) != 0 && key == 'O') events.keys.push_back({kKeyF2, shift});
    if ((mods & (GLFW_MOD_CONTROL | GLFW_MOD_ALT | GLFW_MOD_SUPER)) == 0) events.keys.push_back({key, shift});
}

void onDrop(GLFWwindow* window, int count, const char** paths) {
    ViewEvents& events = noteEvent(window);
    events.dropped.insert(events.dropped.end(), paths, paths + count);
}

void listenTo(GLFWwindow* window, ViewEvents& events) {
    glfwSetWindowUserPointer(window, &events);
    glfwSetKeyCallback(window, onKey);
    glfwSetDropCallback(window, onDrop);
    glfwSetCursorPosCallback(window, [](GLFWwindow* w, double, double) { noteEvent(w); });
    glfwSetMouseButtonCallback(window, [](GLFWwindow* w, int, int action, int) {
        ViewEvents& of = noteEvent(w);
        of.clicked |= action == GLFW_PRESS;
    });
    glfwSetScrollCallback(window, [](GLFWwindow* w, double, double) { noteEvent(w); });
    glfwSetWindowFocusCallback(window, [](GLFWwindow* w, int) { noteEvent(w); });
    glfwSetWindowRefreshCallback(window, [](GLFWwindow* w) { noteEvent(w); });
    glfwSetFramebufferSizeCallback(window, [](GLFWwindow* w, int, int) { noteEvent(w); });
    glfwSetWindowIconifyCallback(window, [](GLFWwindow* w, int) { noteEvent(w); });
    glfwSetWindowCloseCallback(window, [](GLFWwindow* w) { noteEvent(w); });
}

GLFWwindow* makeWindow(const std::string& title, const WindowPlace& place, int samples) {
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, kGlMajor);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, kGlMinor);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
    glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
    glfwWindowHint(GLFW_VISIBLE, GLFW_FALSE);
    glfwWindowHint(GLFW_SAMPLES, samples);
    GLFWwindow* window = glfwCreateWindow(place.width, place.height, title.c_str(), nullptr, nullptr);
    if (!window) throw Unsupported("no window with OpenGL 4.3 can be opened: " + lastGlfwError());
    glfwMakeContextCurrent(window);
    return window;
}

// Limits the size of `window`, which has just been made of `place`, scaled to its monitor.
void limitSize(GLFWwindow* window, const WindowPlace& place) {
    int width = 0, height = 0;
    glfwGetWindowSize(window, &width, &height);
    const auto scaled = [](int least, int size, int of) { return int(std::lround(double(least) * size / of)); };
    glfwSetWindowSizeLimits(window, scaled(kMinWidth, width, place.width), scaled(kMinHeight, height, place.height),
                            GLFW_DONT_CARE, GLFW_DONT_CARE);
}

// Moves the window where it was left, unless the monitor that it was on is gone.
void moveTo(GLFWwindow* window, const WindowPlace& place) {
    if (!place.x || !place.y) return;
    std::vector<ScreenArea> areas;
    int count = 0;
    GLFWmonitor** monitors = glfwGetMonitors(&count);
    for (int i = 0; i < count; ++i) {
        ScreenArea& area = areas.emplace_back();
        glfwGetMonitorWorkarea(monitors[i], &area.x, &area.y, &area.width, &area.height);
    }
    ScreenArea there{*place.x, *place.y, 0, 0};
    glfwGetWindowSize(window, &there.width, &there.height);
    if (isReachable(there, areas)) glfwSetWindowPos(window, there.x, there.y);
}

}  // namespace

void ViewWindow::Impl::load() {
    if (const char* missing = gl::loadFunctions(glfwGetProcAddress))
        throw Unsupported(std::string("this OpenGL has no ") + missing);
    describe(context, "GLFW");
}

// Takes four samples a pixel on a GPU. In software these take several times as long, so one is enough.
void ViewWindow::Impl::open(const std::string& title, const WindowPlace& place) {
    glfwSetErrorCallback([](int, const char* text) { lastGlfwError() = text; });
    if (!glfwInit())
        throw Unsupported("no window can be opened: " + lastGlfwError() + "; penumbra-player render needs none");
    window = makeWindow(title, place, 0);
    load();
    if (!context.software) {
        glfwDestroyWindow(std::exchange(window, nullptr));
        window = makeWindow(title, place, 4);
        load();
    }
    limitSize(window, place);
    moveTo(window, place);
    glfwShowWindow(window);
    glfwSwapInterval(1);
}

ViewWindow::ViewWindow(const std::string& title, const WindowPlace& place) : impl_(std::make_unique<Impl>()) {
    impl_->open(title, place);
    listenTo(impl_->window, impl_->events);
    IMGUI_CHECKVERSION();
    ImGui::CreateContext();
    ImGui::GetIO().IniFilename = nullptr;                                     // panels have fixed places
    ImGui_ImplGlfw_InitForOpenGL(impl_->window, /*install_callbacks=*/true);  // they call ours first
    ImGui_ImplOpenGL3_Init("#version 430 core");
}

ViewWindow::~ViewWindow() = default;

ViewEvents ViewWindow::poll(double seconds) {
    if (seconds > 0)
        glfwWaitEventsTimeout(seconds);
    else
        glfwPollEvents();
    ViewEvents events = std::move(impl_->events);
    impl_->events = {};
    events.close = glfwWindowShouldClose(impl_->window) == GLFW_TRUE;
    return events;
}

int ViewWindow::width() const {
    int width = 0, height = 0;
    glfwGetFramebufferSize(impl_->window, &width, &height);
    return width;
}

int ViewWindow::height() const {
    int width = 0, height = 0;
    glfwGetFramebufferSize(impl_->window, &width, &height);
    return height;
}

bool ViewWindow::listOpen() const {
    return ImGui::IsPopupOpen("", ImGuiPopupFlags_AnyPopupId | ImGuiPopupFlags_AnyPopupLevel);
}

void ViewWindow::setTitle(const std::string& title) { glfwSetWindowTitle(impl_->window, title.c_str()); }

bool ViewWindow::held() const {
    for (const int button : {GLFW_MOUSE_BUTTON_LEFT, GLFW_MOUSE_BUTTON_MIDDLE, GLFW_MOUSE_BUTTON_RIGHT})
        if (glfwGetMouseButton(impl_->window, button) == GLFW_PRESS) return true;
    return false;
}

bool ViewWindow::visible() const {
    return width() > 0 && height() > 0 && glfwGetWindowAttrib(impl_->window, GLFW_ICONIFIED) == GLFW_FALSE;
}

float ViewWindow::scale() const {
    float x = 1, y = 1;
    glfwGetWindowContentScale(impl_->window, &x, &y);
    return std::clamp(x, 0.5f, 8.0f);
}

// On some systems screen coordinates are pixels, on others units. The window may be resized between two questions.
float ViewWindow::unitScale() const {
    int window_width = 0, window_height = 0, pixels = width(), before = -1;
    while (pixels != before) {
        before = pixels;
        glfwGetWindowSize(impl_->window, &window_width, &window_height);
        pixels = width();
    }
    return window_width > 0 && pixels > 0 ? scale() * float(window_width) / float(pixels) : 1;
}

WindowPlace ViewWindow::place() const {
    WindowPlace place;
    glfwGetWindowSize(impl_->window, &place.width, &place.height);
    int x = 0, y = 0;
    glfwGetWindowPos(impl_->window, &x, &y);
    place.x = x;
    place.y = y;
    const float unit = unitScale();  // a new window is scaled to its monitor again
    place.width = std::clamp(int(std::lround(float(place.width) / unit)), kMinWidth, kMaxWidth);
    place.height = std::clamp(int(std::lround(float(place.height) / unit)), kMinHeight, kMaxHeight);
    return place;
}

const std::string& ViewWindow::description() const { return impl_->context.description; }
bool ViewWindow::software() const { return impl_->context.software; }

namespace {

// Sets fonts and margins for the monitor's density, and again when the window moves to another one. ImGui 1.86 must
// keep its GL buffers then: it would take new, empty ones for as large as the old.
void styleFor(float unit_scale, bool first) {
    constexpr const char* kFont = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
    ImGui::GetStyle() = ImGuiStyle();
    ImGui::StyleColorsDark();
    ImGui::GetStyle().WindowRounding = 0;
    ImGui::GetStyle().FrameRounding = 3;
    ImGui::GetStyle().WindowBorderSize = 0;
    // Numbers stand on the grab of a slider: white on these colours has a contrast of 4.8 and more.
    ImGui::GetStyle().Colors[ImGuiCol_SliderGrab] = ImVec4(0.22f, 0.40f, 0.66f, 1);
    ImGui::GetStyle().Colors[ImGuiCol_SliderGrabActive] = ImVec4(0.26f, 0.45f, 0.72f, 1);
    ImGui::GetStyle().Colors[ImGuiCol_TextDisabled] = ImVec4(0.62f, 0.65f, 0.70f, 1);  // headings
    ImGui::GetStyle().ScaleAllSizes(unit_scale);
    ImFontAtlas& fonts = *ImGui::GetIO().Fonts;
    fonts.Clear();
    ImFontConfig config;
    config.SizePixels = std::round(15 * unit_scale);
    if (!std::filesystem::exists(kFont) || !fonts.AddFontFromFileTTF(kFont, config.SizePixels))
        fonts.AddFontDefault(&config);
    if (first) return;  // the next frame makes the texture
    ImGui_ImplOpenGL3_DestroyFontsTexture();
    ImGui_ImplOpenGL3_CreateFontsTexture();
}

}  // namespace

void ViewWindow::beginPanels() {
    if (const float scale = unitScale(); impl_->font_scale != scale) {
        styleFor(scale, impl_->font_scale == 0);
        impl_->font_scale = scale;
    }
    ImGui_ImplOpenGL3_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    ImGui::NewFrame();
}

void ViewWindow::drawPanels() {
    ImGui::Render();
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

void ViewWindow::present() { glfwSwapBuffers(impl_->window); }

}  // namespace penumbra
