// Follows the OpenGL calls of one context and passes its draws to Frame.
#pragma once

#include <functional>
#include <optional>

#include "preload/capture/arrays.h"
#include "preload/capture/attributes.h"
#include "preload/capture/lists.h"
#include "preload/frame/frame.h"

namespace sideray::run {

class Session {
 public:
  Session();

  // Returns whether this thread's calls are followed. Chooses the thread's context if none is chosen yet.
  bool looks();
  void make_current(void* context);  // of GLX or EGL
  void destroy(void* context);
  void swap();

  // Handles glBegin. Returns whether the draw is held back, so that the driver must not see it.
  bool begin(GLenum mode);
  bool is_open() const { return open_; }  // between glBegin and glEnd of a draw that is captured
  bool is_held() const { return held_; }
  // Returns whether vertex attributes are recorded, for a captured draw or for a display list.
  bool follows_attributes() const { return open_ || is_recording(); }
  Vertex& next() { return next_; }
  void note_color() { colored_ = true; }
  // glNewList
  void begin_list(GLuint list);
  void add_vertex() { geometry_.vertices.push_back(next_); }
  void end();

  // Handles a draw of arrays. `read` reads them if they are needed, and may return null. Returns whether the draw is
  // held back.
  bool take(const std::function<std::shared_ptr<const Geometry>()>& read);
  bool call_list(GLuint list);
  // Handles a draw or a copy that is not captured: makes the held draws before it if it draws over them or reads them.
  void before_other(const char* name);
  // Makes the held draws before a change of something that they depend on.
  void before_change() {
    if (frame_.is_holding()) frame_.flush();
  }
  // Makes the held draws before depth is cleared or the picture is copied.
  void before_cut() { frame_.flush(); }
  void uses_shaders(const char* name);
  bool is_recording() const { return lists_.is_recording(); }

  Lists& lists() { return lists_; }
  Arrays& arrays() { return arrays_; }
  Frame& frame() { return frame_; }

 private:
  bool pass_unread();

  Frame frame_;
  Lists lists_;
  Arrays arrays_;
  void* context_ = nullptr;
  bool open_ = false, held_ = false, colored_ = false;
  Vertex next_;
  Geometry geometry_;
  DrawState state_;
  Decision decision_;
};

// Returns the only session. It lives as long as the process, because programs call OpenGL until they exit.
Session& session();

}  // namespace sideray::run
