// Records what is compiled into display lists, so that a list's draws are known when it is called.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <vector>

#include "preload/capture/draw_state.h"
#include "preload/capture/geometry.h"

namespace sideray::run {

// A piece of geometry that a call of the list draws.
struct ListPiece {
  std::shared_ptr<const Geometry> geometry;
  uint64_t hash = 0;
  bool colored = false;  // it has colours of its own; otherwise it has the current colour
};

class Lists {
 public:
  bool is_recording() const { return recording_ != 0; }
  GLuint recording() const { return recording_; }
  void begin(GLuint list);
  void end();
  void remove(GLuint first, GLsizei count);
  void clear() { lists_.clear(), recording_ = 0; }

  // Record a compiled command.
  void add(Geometry geometry, bool colored);
  void add_call(GLuint list);
  void add_texture(GLuint name);
  void add_switch(GLenum name, bool on);
  void add_matrix_mode(GLenum mode);
  void add_matrix(const Matrix& matrix, bool replaces);
  void add_push(bool push);
  // Records a command of unknown effect; such a list is never held back.
  void add_unknown();

  // Calls f(piece, state) for each piece that the list draws when called in OpenGL's state `state`.
  using Visitor = std::function<void(const ListPiece&, const DrawState&)>;
  void visit(GLuint list, DrawState state, const Visitor& f) const;
  // Returns whether a call of the list changes only textures and the current attributes.
  bool can_be_held(GLuint list, int depth = 0) const;

 private:
  struct Command {
    enum { piece, call, texture, flag, matrix_mode, multiply, load, push, pop, unknown } what;
    ListPiece drawn;
    GLuint name = 0;
    bool on = false;
    Matrix matrix{};
  };
  struct Walk {
    DrawState state;
    bool in_modelview = true;
    std::vector<Matrix> stack;
  };
  void note(Command command);
  void walk(GLuint list, Walk& walk, int depth, const Visitor& f) const;

  std::map<GLuint, std::vector<Command>> lists_;
  GLuint recording_ = 0;
};

Matrix product(const Matrix& a, const Matrix& b);

}  // namespace sideray::run
