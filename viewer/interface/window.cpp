#include "viewer/interface/window.h"

#define GLFW_INCLUDE_NONE
#include <GL/gl.h>
#include <GLFW/glfw3.h>
#include <imgui_impl_glfw.h>
#include <dlfcn.h>
#include <imgui_impl_opengl3.h>

#include <cstdlib>
#include <filesystem>
#include <string_view>
#include <type_traits>

#include "scenes/base/files.h"

namespace sideray::viewer {
namespace {

bool is_on_wayland() {
#if GLFW_VERSION_MAJOR > 3 || GLFW_VERSION_MINOR >= 4
  return glfwGetPlatform() == GLFW_PLATFORM_WAYLAND;
#else
  return std::string_view(glfwGetVersionString()).find("Wayland") != std::string_view::npos;
#endif
}

// Functions of OpenGL 1.1; libGL is not linked.
struct Functions {
  decltype(&glGenTextures) gen_textures;
  decltype(&glBindTexture) bind_texture;
  decltype(&glTexImage2D) image;
  decltype(&glTexParameteri) parameter;
  decltype(&glPixelStorei) store;
  decltype(&glViewport) viewport;
  decltype(&glClearColor) clear_color;
  decltype(&glClear) clear;
  GLenum (*reset_status)();  // null where the driver lacks it
};
Functions gl;

template <typename Function>
void find(Function& function, const char* name) {
  function = reinterpret_cast<Function>(glfwGetProcAddress(name));
  if (!function) scenes::refuse("window: OpenGL has no {}; use another driver", name);
}

void find_functions() {
  find(gl.gen_textures, "glGenTextures");
  find(gl.bind_texture, "glBindTexture");
  find(gl.image, "glTexImage2D");
  find(gl.parameter, "glTexParameteri");
  find(gl.store, "glPixelStorei");
  find(gl.viewport, "glViewport");
  find(gl.clear_color, "glClearColor");
  find(gl.clear, "glClear");
  const bool tells_resets = glfwExtensionSupported("GL_KHR_robustness") || glfwExtensionSupported("GL_ARB_robustness");
  for (const char* name : {"glGetGraphicsResetStatus", "glGetGraphicsResetStatusARB"})
    if (tells_resets && !gl.reset_status)
      gl.reset_status = reinterpret_cast<decltype(gl.reset_status)>(glfwGetProcAddress(name));
}

// Returns a text for a status of GL_ARB_robustness.
const char* cause_of(GLenum status) {
  switch (status) {
    case 0x8253: return "by what it drew";
    case 0x8254: return "by another program";
    default: return "by the driver";
  }
}

void require_context() {
  if (const GLenum status = gl.reset_status ? gl.reset_status() : GL_NO_ERROR; status != GL_NO_ERROR)
    throw ContextLost(std::string("window: its OpenGL context was reset ") + cause_of(status));
}

std::function<void()> on_display_gone;

int end_without_display(void*) {
  on_display_gone();
  std::_Exit(EXIT_FAILURE);
}

int go_on(void*, void*) {
  return 0;
}

// Replaces Xlib's handlers, which end the program while its threads run: when the display is gone, and when a request
// fails. GLFW's reply to a window from which a file was dropped fails if that window is already closed. Uses the
// library that GLFW has opened; outside X11 there is none.
void handle_x_errors() {
  void* const xlib = ::dlopen("libX11.so.6", RTLD_LAZY | RTLD_NOLOAD);
  if (!xlib) return;
  const auto set = [&]<typename... Arguments>(const char* name, int (*handler)(Arguments...)) {
    using Handler = int (*)(Arguments...);
    if (void* const function = ::dlsym(xlib, name)) reinterpret_cast<Handler (*)(Handler)>(function)(handler);
  };
  set("XSetIOErrorHandler", end_without_display);
  set("XSetErrorHandler", go_on);
  ::dlclose(xlib);
}

// Returns GLFW's last error, for our message.
std::string reason() {
  const char* description = nullptr;
  glfwGetError(&description);
  return description ? description : "unknown";
}

void set_style() {
  ImGui::StyleColorsDark();
  ImGuiStyle& style = ImGui::GetStyle();
  style.WindowRounding = 0;
  style.FrameRounding = 3;
  style.GrabRounding = 3;
  style.WindowBorderSize = 0;
  style.ItemSpacing = {8, 5};
  style.Colors[ImGuiCol_WindowBg] = {0.11f, 0.12f, 0.13f, 1.0f};
  style.Colors[ImGuiCol_PopupBg] = {0.16f, 0.17f, 0.19f, 1.0f};  // lists and help are read over other text
  style.Colors[ImGuiCol_Header] = {0.20f, 0.22f, 0.25f, 1.0f};
  style.Colors[ImGuiCol_FrameBg] = {0.18f, 0.20f, 0.22f, 1.0f};
  style.Colors[ImGuiCol_Button] = {0.22f, 0.28f, 0.36f, 1.0f};
  const char* const font = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
  if (std::filesystem::exists(font)) ImGui::GetIO().Fonts->AddFontFromFileTTF(font, 14.0f);
}

}  // namespace

Window::Window(uint32_t width, uint32_t height, WindowEvents events) : events_(std::move(events)) {
  if (!glfwInit()) scenes::refuse("window: no display: {}; set DISPLAY, or use sideray render", reason());
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_CONTEXT_ROBUSTNESS, GLFW_LOSE_CONTEXT_ON_RESET);
  window_ = glfwCreateWindow(static_cast<int>(width), static_cast<int>(height), "Sideray", nullptr, nullptr);
  if (!window_) {
    const std::string why = reason();
    glfwTerminate();
    scenes::refuse("window: no OpenGL 3.3: {}; install a driver (libgl1-mesa-dri), or use sideray render", why);
  }
  on_display_gone = events_.display_gone;
  handle_x_errors();
  glfwMakeContextCurrent(window_);
  glfwSwapInterval(is_on_wayland() ? 0 : 1);  // there a swap that waits for the screen never ends for a hidden window
  find_functions();
  glfwSetWindowUserPointer(window_, this);
  glfwSetKeyCallback(window_, on_key);
  glfwSetDropCallback(window_, on_drop);
  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr;
  set_style();
  ImGui_ImplGlfw_InitForOpenGL(window_, true);
  ImGui_ImplOpenGL3_Init("#version 330 core");
}

Window::~Window() {
  ImGui_ImplOpenGL3_Shutdown();
  ImGui_ImplGlfw_Shutdown();
  ImGui::DestroyContext();
  glfwDestroyWindow(window_);
  glfwTerminate();
}

void Window::on_key(GLFWwindow* window, int key, int, int action, int mods) {
  auto& self = *static_cast<Window*>(glfwGetWindowUserPointer(window));
  if (action == GLFW_PRESS && !ImGui::GetIO().WantTextInput) self.events_.key(key, (mods & GLFW_MOD_CONTROL) != 0);
}

void Window::on_drop(GLFWwindow* window, int count, const char** paths) {
  static_cast<Window*>(glfwGetWindowUserPointer(window))->events_.drop({paths, paths + count});
}

bool Window::is_closing() const {
  return glfwWindowShouldClose(window_) != 0;
}

void Window::close() {
  glfwSetWindowShouldClose(window_, GLFW_TRUE);
}

void Window::hide() {
  glfwHideWindow(window_);
  glfwPollEvents();
}

bool Window::wait(double seconds) {
  if (seconds == 0) {
    glfwPollEvents();
    return false;
  }
  const double start = glfwGetTime();
  glfwWaitEventsTimeout(seconds);
  return glfwGetTime() - start < seconds;
}

void Window::wake() {
  glfwPostEmptyEvent();
}

bool Window::is_down(int key) const {
  return glfwGetKey(window_, key) == GLFW_PRESS;
}

void Window::set_title(const std::string& title) {
  if (title != title_) glfwSetWindowTitle(window_, title.c_str());
  title_ = title;
}

void Window::copy_text(const std::string& text) {
  glfwSetClipboardString(window_, text.c_str());
}

float Window::pixels_per_unit() const {
  int width = 0, pixels = 0, ignored = 0;
  glfwGetWindowSize(window_, &width, &ignored);
  glfwGetFramebufferSize(window_, &pixels, &ignored);
  return width > 0 && pixels > 0 ? static_cast<float>(pixels) / static_cast<float>(width) : 1.0f;
}

void Window::draw(const std::function<void()>& content) {
  int width = 0, height = 0;
  glfwGetFramebufferSize(window_, &width, &height);
  if (width == 0 || height == 0 || glfwGetWindowAttrib(window_, GLFW_ICONIFIED)) return;
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  ImGui::NewFrame();
  content();
  ImGui::Render();
  gl.viewport(0, 0, width, height);
  gl.clear_color(0.06f, 0.06f, 0.07f, 1.0f);
  gl.clear(GL_COLOR_BUFFER_BIT);
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
  glfwSwapBuffers(window_);
  require_context();
}

void Texture::upload(uint32_t width, uint32_t height, const std::vector<uint8_t>& rgb) {
  if (name_ == 0) gl.gen_textures(1, &name_);
  gl.bind_texture(GL_TEXTURE_2D, name_);
  gl.store(GL_UNPACK_ALIGNMENT, 1);
  gl.parameter(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  gl.parameter(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  gl.parameter(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, 0x812F);  // GL_CLAMP_TO_EDGE
  gl.parameter(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, 0x812F);
  gl.image(GL_TEXTURE_2D, 0, GL_RGB, static_cast<GLsizei>(width), static_cast<GLsizei>(height), 0, GL_RGB, GL_UNSIGNED_BYTE,
           rgb.data());
}

// Returns a texture's id, which is a pointer in some versions of Dear ImGui and a number in others.
template <typename Id>
Id texture_id(uintptr_t name) {
  if constexpr (std::is_pointer_v<Id>)
    return reinterpret_cast<Id>(name);
  else
    return static_cast<Id>(name);
}

ImTextureID Texture::id() const {
  return texture_id<ImTextureID>(name_);
}

}  // namespace sideray::viewer
