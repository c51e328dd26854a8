// A window with OpenGL and Dear ImGui. Main thread, one at a time.
#pragma once

#include <cstdint>
#include <functional>
#include <imgui.h>
#include <stdexcept>
#include <string>
#include <vector>

struct GLFWwindow;

namespace sideray::viewer {

// What the window tells beside what Dear ImGui knows.
struct WindowEvents {
  std::function<void(int key, bool with_control)> key;  // pressed, where no text is being written
  std::function<void(const std::vector<std::string>& paths)> drop;
  std::function<void()> display_gone;  // does not return
};

// The window's OpenGL is gone, and all that was in it.
struct ContextLost : std::runtime_error {
  using std::runtime_error::runtime_error;
};

class Window {
 public:
  // Throws Error where there is no display or no OpenGL 3.3.
  Window(uint32_t width, uint32_t height, WindowEvents events);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  bool is_closing() const;
  void close();
  void hide();
  // Until there is an event or so many seconds are over; whether there was one. 0: looks, and does not wait.
  bool wait(double seconds);
  static void wake();  // any thread
  bool is_down(int key) const;
  void set_title(const std::string& title);
  void copy_text(const std::string& text);

  // Calls `content` between the beginning and the end of a frame of Dear ImGui, and shows it. A minimised window draws nothing.
  // Throws ContextLost.
  void draw(const std::function<void()>& content);
  float pixels_per_unit() const;

 private:
  static void on_key(GLFWwindow* window, int key, int scancode, int action, int mods);
  static void on_drop(GLFWwindow* window, int count, const char** paths);

  WindowEvents events_;
  GLFWwindow* window_ = nullptr;
  std::string title_;
};

// A picture in the window's OpenGL. Main thread, while there is a window.
class Texture {
 public:
  void upload(uint32_t width, uint32_t height, const std::vector<uint8_t>& rgb);
  bool is_empty() const { return name_ == 0; }
  ImTextureID id() const;

 private:
  unsigned name_ = 0;
};

}  // namespace sideray::viewer
