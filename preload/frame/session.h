// The context that is looked at, and what its calls become.
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

  // Whether calls of this thread are looked at. Chooses the thread's context if none is yet.
  bool looks();
  void make_current(void* context);  // of GLX or EGL
  void destroy(void* context);
  void swap();

  // glBegin; whether the draw is held back, so that the driver does not see it.
  bool begin(GLenum mode);
  bool is_open() const { return open_; }  // between glBegin and glEnd of a draw that is captured
  bool is_held() const { return held_; }
  // Whether attributes count: those of a draw that is captured, or that are compiled into a list.
  bool follows_attributes() const { return open_ || is_recording(); }
  Vertex& next() { return next_; }
  void note_color() { colored_ = true; }
  // glNewList
  void begin_list(GLuint list);
  void add_vertex() { geometry_.vertices.push_back(next_); }
  void end();

  // A draw of arrays, which `read` reads where they are wanted; it may return none. Returns whether the draw is held back.
  bool take(const std::function<std::shared_ptr<const Geometry>()>& read);
  bool call_list(GLuint list);
  // A draw or a copy that is not captured: what is held back is drawn before it, where it lies over it or reads it.
  void before_other(const char* name);
  // Something changes that held draws depend on.
  void before_change() {
    if (frame_.is_holding()) frame_.flush();
  }
  // What has been drawn so far ends here: depth is cleared, or the picture is copied.
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

// The one session. It lives as long as the process: programs call OpenGL until their last moment.
Session& session();

}  // namespace sideray::run
