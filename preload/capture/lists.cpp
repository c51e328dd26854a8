#include "preload/capture/lists.h"

#include <algorithm>

namespace sideray::run {
namespace {

constexpr int deepest = 64;  // GL_MAX_LIST_NESTING

}  // namespace

Matrix product(const Matrix& a, const Matrix& b) {
  Matrix result{};
  for (size_t column = 0; column < 4; ++column)
    for (size_t row = 0; row < 4; ++row)
      for (size_t k = 0; k < 4; ++k) result[4 * column + row] += a[4 * k + row] * b[4 * column + k];
  return result;
}

void Lists::begin(GLuint list) {
  recording_ = list;
  lists_[list].clear();
}

void Lists::end() {
  recording_ = 0;
}

void Lists::remove(GLuint first, GLsizei count) {
  lists_.erase(lists_.lower_bound(first), lists_.lower_bound(first + static_cast<GLuint>(std::max(count, 0))));
}

void Lists::note(Command command) {
  lists_[recording_].push_back(std::move(command));
}

void Lists::add(Geometry geometry, bool colored) {
  const uint64_t hash = hash_of(geometry, {.colors = colored});
  note({Command::piece, {std::make_shared<const Geometry>(std::move(geometry)), hash, colored}, 0, false, {}});
}

void Lists::add_call(GLuint list) {
  note({Command::call, {}, list, false, {}});
}

void Lists::add_texture(GLuint name) {
  note({Command::texture, {}, name, false, {}});
}

void Lists::add_switch(GLenum name, bool on) {
  note({Command::flag, {}, name, on, {}});
}

void Lists::add_matrix_mode(GLenum mode) {
  note({Command::matrix_mode, {}, mode, false, {}});
}

void Lists::add_matrix(const Matrix& matrix, bool replaces) {
  note({replaces ? Command::load : Command::multiply, {}, 0, false, matrix});
}

void Lists::add_push(bool push) {
  note({push ? Command::push : Command::pop, {}, 0, false, {}});
}

void Lists::add_unknown() {
  note({Command::unknown, {}, 0, false, {}});
}

void Lists::visit(GLuint list, DrawState state, const Visitor& f) const {
  Walk start{std::move(state), true, {}};
  walk(list, start, 0, f);
}

void Lists::walk(GLuint list, Walk& walk, int depth, const Visitor& f) const {
  const auto found = lists_.find(list);
  if (found == lists_.end() || depth >= deepest) return;
  DrawState& state = walk.state;
  for (const Command& command : found->second) {
    switch (command.what) {
      case Command::piece:
        f(command.drawn, state);
        break;
      case Command::call:
        this->walk(command.name, walk, depth + 1, f);
        break;
      case Command::texture:
        state.units[0].texture = state.units[0].textured ? command.name : 0;
        break;
      case Command::flag:
        if (command.name == GL_LIGHTING) state.lighting = command.on;
        if (command.name == GL_BLEND) state.blend = command.on;
        if (command.name == GL_TEXTURE_2D) state.units[0].textured = command.on;
        if (command.name == GL_TEXTURE_2D && !command.on) state.units[0].texture = 0;
        break;
      case Command::matrix_mode:
        walk.in_modelview = command.name == GL_MODELVIEW;
        break;
      case Command::multiply:
        if (walk.in_modelview) state.modelview = product(state.modelview, command.matrix);
        break;
      case Command::load:
        if (walk.in_modelview) state.modelview = command.matrix;
        break;
      case Command::push:
        if (walk.in_modelview) walk.stack.push_back(state.modelview);
        break;
      case Command::pop:
        if (!walk.in_modelview || walk.stack.empty()) break;
        state.modelview = walk.stack.back();
        walk.stack.pop_back();
        break;
      case Command::unknown:
        break;
    }
  }
}

bool Lists::can_be_held(GLuint list, int depth) const {
  const auto found = lists_.find(list);
  if (found == lists_.end() || depth >= deepest) return false;
  return std::all_of(found->second.begin(), found->second.end(), [&](const Command& command) {
    return command.what == Command::piece || command.what == Command::texture || (command.what == Command::call && can_be_held(command.name, depth + 1));
  });
}

}  // namespace sideray::run
