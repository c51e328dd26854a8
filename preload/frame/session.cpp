#include "preload/frame/session.h"

#include <algorithm>
#include <cstdlib>

#include "preload/gl/functions.h"

namespace sideray::run {
namespace {

thread_local void* current_context = nullptr;


// Sets the texture and the attributes of a held list's last vertex, as if the list had been drawn.
void leave_as_drawn(const Piece& last) {
  const Functions& gl = real();
  const Vertex& vertex = last.geometry->vertices.back();
  if (last.state.units[0].texture != 0) gl.BindTexture(GL_TEXTURE_2D, last.state.units[0].texture);
  gl.Normal3fv(vertex.normal);
  gl.TexCoord4fv(vertex.uv[0]);
}

void* context_of_thread() {
  static const auto current = real_function<decltype(&::glXGetCurrentContext)>("glXGetCurrentContext");
  if (!current_context && current) current_context = current();
  if (!current_context) current_context = current_egl_context();
  return current_context;
}

}  // namespace

Session& session() {
  static Session* const one = new Session;
  return *one;
}

Session::Session() {
  std::atexit([] { session().frame_.write_report(); });
}

bool Session::looks() {
  if (frame_.gave_up() || frame_.is_flushing()) return false;
  void* const context = context_of_thread();
  if (!context) return false;
  if (!context_) context_ = context;
  if (context == context_) return true;
  frame_.give_up("it draws in several contexts, and one is all that is followed");
  return false;
}

void Session::make_current(void* context) {
  current_context = context;
}

void Session::destroy(void* context) {
  if (!context || context != context_ || frame_.is_flushing()) return;
  frame_.close(context == current_context);
  lists_.clear();
  arrays_.clear();
  context_ = nullptr;
  if (current_context == context) current_context = nullptr;
}

void Session::swap() {
  if (looks()) frame_.end();
}

void Session::begin_list(GLuint list) {
  lists_.begin(list);
  next_ = Vertex();
  colored_ = false;
}

bool Session::begin(GLenum mode) {
  open_ = held_ = false;
  if (!looks()) return false;
  if (!lists_.is_recording()) {
    state_ = read_draw_state();
    decision_ = frame_.decide(state_, nullptr, 0);
    if (!frame_.wants(decision_)) return false;
    next_ = read_attributes();
    held_ = decision_.holds() && !frame_.compares();
  }
  geometry_ = Geometry();
  geometry_.mode = mode;
  open_ = true;
  return held_;
}

void Session::end() {
  if (!open_) return;
  open_ = held_ = false;
  if (geometry_.vertices.empty()) return;
  if (lists_.is_recording()) {
    lists_.add(std::move(geometry_), colored_);
    return;
  }
  const uint64_t hash = hash_of(geometry_, state_.counted());
  Piece piece{std::make_shared<const Geometry>(std::move(geometry_)), hash, state_, decision_};
  if (decision_.holds())
    frame_.hold({std::move(piece)}, 0, untinted);
  else if (!piece.state.blend || !piece.state.shows_colors() || piece.geometry->is_opaque() || piece.decision.taking == Taking::sky)
    frame_.show(std::move(piece), untinted);
}

bool Session::take(const std::function<std::shared_ptr<const Geometry>()>& read) {
  if (lists_.is_recording()) {
    if (const std::shared_ptr<const Geometry> drawn = read()) lists_.add(*drawn, is_enabled(GL_COLOR_ARRAY));
    return false;
  }
  DrawState state = read_draw_state();
  const bool needs_colors = state.blend && state.shows_colors() && is_enabled(GL_COLOR_ARRAY);
  std::shared_ptr<const Geometry> drawn;
  Decision decision;
  if (needs_colors || frame_.names_meshes()) {
    drawn = read();
    if (!drawn) return pass_unread();
    if (state.shows_colors()) state.alpha = drawn->vertices.front().color[3];
    decision = frame_.decide(state, drawn.get(), hash_of(*drawn, state.counted()));
    if (!frame_.wants(decision)) return false;
  } else {
    // All vertices have the current colour, so one vertex stands for all.
    Geometry vertex;
    vertex.vertices.emplace_back().color[3] = state.alpha;
    decision = frame_.decide(state, &vertex, 0);
    if (!frame_.wants(decision)) return false;
    drawn = read();
    if (!drawn) return pass_unread();
  }
  const uint64_t hash = hash_of(*drawn, state.counted());
  Piece piece{std::move(drawn), hash, std::move(state), decision};
  if (decision.holds())
    frame_.hold({std::move(piece)}, 0, untinted);
  else
    frame_.show(std::move(piece), untinted);
  return decision.holds() && !frame_.compares();
}

bool Session::pass_unread() {
  before_other("glDrawElements whose indices lie outside of their buffer");
  return false;
}

bool Session::call_list(GLuint list) {
  std::vector<Piece> pieces;
  lists_.visit(list, read_draw_state(), [&](const ListPiece& piece, DrawState state) {
    if (piece.colored && state.shows_colors()) state.alpha = piece.geometry->vertices.front().color[3];
    const Geometry* known = piece.colored || !state.shows_colors() ? piece.geometry.get() : nullptr;
    pieces.push_back({piece.geometry, piece.hash, state, frame_.decide(state, known, piece.hash)});
  });
  if (pieces.empty()) return false;
  float current[4] = {1, 1, 1, 1};
  real().GetFloatv(GL_CURRENT_COLOR, current);
  bool holds = false;
  for (const Piece& piece : pieces) holds = holds || piece.decision.holds();
  if (holds && lists_.can_be_held(list)) {
    const Piece last = pieces.back();
    frame_.hold(std::move(pieces), list, current);
    if (frame_.compares()) return false;
    leave_as_drawn(last);
    return true;
  }
  const bool waits = std::any_of(pieces.begin(), pieces.end(), [](const Piece& piece) { return piece.decision.holds() && !piece.decision.in_turn; });
  if (waits) frame_.survey().miss("display lists that change more than textures and cannot be held back");
  if (holds) frame_.compare_no_more();
  for (Piece& piece : pieces) {
    const float* tint = piece.state.lighting ? untinted : current;
    frame_.show(std::move(piece), tint);
  }
  return false;
}

void Session::before_other(const char* name) {
  if (!looks() || lists_.is_recording()) return;
  frame_.survey().miss(name);
  before_cut();
}

void Session::uses_shaders(const char* name) {
  if (!looks()) return;
  before_change();
  frame_.give_up(std::string("it uses shaders (") + name + "), and the fixed function is all that is followed");
}

}  // namespace sideray::run
