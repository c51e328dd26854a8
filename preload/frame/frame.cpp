#include "preload/frame/frame.h"

#include <algorithm>
#include <chrono>

#include "preload/base/settings.h"
#include "preload/base/signals.h"
#include "preload/gl/functions.h"

namespace sideray::run {
namespace {

constexpr int frames_of_interest = 60;    // without anything that reflects, after which the scene is no longer captured
constexpr auto time_between_reports = std::chrono::seconds(3);  // a program that is killed leaves a report too
constexpr uint64_t frames_a_picture = 30;

// Alpha blending, premultiplied or not: what lies behind is seen through it.
bool blends_by_alpha(const DrawState& state) {
  return state.blend && state.blend_target == GL_ONE_MINUS_SRC_ALPHA && (state.blend_source == GL_SRC_ALPHA || state.blend_source == GL_ONE);
}

bool looks_like_glass(const DrawState& state) {
  return blends_by_alpha(state) && state.alpha < 0.99f && state.lighting && state.depth_test;
}

bool multiplies(const DrawState& state) {
  return state.blend && ((state.blend_source == GL_DST_COLOR && state.blend_target == GL_ZERO) ||
                         (state.blend_source == GL_ZERO && state.blend_target == GL_SRC_COLOR));
}

bool is_compared(uint64_t frame) {
  return !settings().pictures.empty() && !settings().off && frame % frames_a_picture == 0;
}

bool is_reflector(Kind kind) {
  return kind == Kind::glass || kind == Kind::water || kind == Kind::mirror;
}

// Stages of one surface have the same vertices in the same places.
bool is_same_surface(const Piece& a, const Piece& b) {
  const std::vector<Vertex>&u = a.geometry->vertices, &v = b.geometry->vertices;
  if (u.size() != v.size() || a.state.modelview != b.state.modelview || a.geometry->indices != b.geometry->indices) return false;
  return std::equal(u.begin(), u.end(), v.begin(), [](const Vertex& x, const Vertex& y) { return std::equal(x.position, x.position + 4, y.position); });
}

}  // namespace

Frame::Frame() : compares_(is_compared(0)) {
  try {
    if (!settings().rules.empty()) rules_ = Rules::read(settings().rules);
  } catch (const std::exception& error) {
    give_up(error.what());
  }
}

Frame::~Frame() = default;

Taking Frame::taking_of(const DrawState& state, const Rule& rule) const {
  const bool joins_later = state.blend || depends_on_held(state);
  if (rule.kind == Kind::ignore || !state.writes_color) return joins_later && is_holding() ? Taking::held : Taking::left;
  if (is_reflector(rule.kind)) return Taking::reflects;
  const bool behind_all = !state.depth_test || !state.depth_write;
  const bool may_be_sky = behind_all && !drew_opaque_ && !is_holding();
  if (rule.kind == Kind::sky || (may_be_sky && (!state.blend || blends_by_alpha(state)))) return Taking::sky;
  if (rule.kind == Kind::opaque || !joins_later) return Taking::opaque;
  return is_holding() ? Taking::held : Taking::left;
}

bool Frame::depends_on_held(const DrawState& state) const {
  return state.depth_func == GL_EQUAL || (state.stencil_test && holds_stencil_);
}

bool Frame::covers(const DrawState& state, const Geometry* geometry, bool& has_holes) {
  if (!blends_by_alpha(state) || !state.depth_test || !state.depth_write || depends_on_held(state)) return false;
  if (state.shows_colors() && geometry ? !geometry->is_opaque() : state.alpha < 0.99f) return false;
  for (int layer = 0; layer < kept_units; ++layer) has_holes = has_holes || !textures_.find(state.texture(layer)).covers;
  return true;
}

bool Frame::has_other_view(const DrawState& state) const {
  return state.projection != projection_ || state.viewport != viewport_;
}

Decision Frame::decide(const DrawState& state, const Geometry* geometry, uint64_t mesh) {
  if (state.framebuffer != 0 || gave_up()) return {};
  const bool over_all = !state.is_perspective() || (!state.depth_test && (drew_opaque_ || is_holding()));
  if (over_all) {
    flush();
    return {};
  }
  const Texture& texture = textures_.find(state.texture());
  Decision decision;
  decision.rule = rules_.find(texture.hash, mesh);
  if (decision.rule.kind == Kind::unknown && texture.hash == 0 && looks_like_glass(state))
    decision.rule = {Kind::glass, usual_reflectance(Kind::glass), true};
  decision.taking = taking_of(state, decision.rule);
  if (bool has_holes = false; decision.rule.kind == Kind::unknown && covers(state, geometry, has_holes)) {
    decision.is_seen = true;
    // What has no holes looks the same before and behind what is held back; the vertices of glBegin are not known yet.
    if (!is_holding() || (geometry && !has_holes)) decision.taking = Taking::opaque;
  }
  const bool is_solid = !state.blend && state.depth_test && state.depth_write && state.depth_func != GL_EQUAL;
  decision.is_seen = decision.is_seen || decision.taking == Taking::opaque || decision.taking == Taking::sky ||
                     (decision.taking == Taking::held && is_solid && state.writes_color && decision.rule.kind != Kind::ignore);
  if (decision.holds() && is_holding() && has_other_view(state)) flush();
  if (decision.taking == Taking::opaque && state.depth_write) drew_opaque_ = true;
  survey_.note(texture, mesh, state, decision.taking, decision.rule);
  if (decision.taking == Taking::reflects) tracing_ = true, frames_without_ = 0;
  if (settings().off && decision.holds()) decision.taking = Taking::left;
  if (compares_ && !is_holding() && decision.holds()) start_.emplace(state.viewport);
  decision.in_turn = compares_ && is_holding() && !decision.holds();
  return decision;
}

SceneDraw Frame::scene_draw(const Geometry& geometry, uint64_t hash, const DrawState& state) {
  SceneDraw draw;
  draw.geometry = &geometry;
  draw.hash = hash;
  draw.state = &state;
  for (int layer = 0; layer < 2; ++layer) draw.textures[layer] = &textures_.find(state.texture(layer));
  return draw;
}

// The second stage of an opaque surface, which multiplies: a light map as a rule.
bool Frame::is_light_map_of_pending(const Piece& piece) const {
  if (!pending_ || pending_->state.unit_of_layer(0) != 0 || pending_->state.texture(1) != 0) return false;
  if (piece.state.unit_of_layer(0) != 0 || piece.state.units[0].coordinates || !multiplies(piece.state)) return false;
  return is_same_surface(*pending_, piece);
}

void Frame::add_pending() {
  if (!pending_) return;
  SceneDraw draw = scene_draw(*pending_->geometry, hash_of(*pending_->geometry, pending_->state.counted()), pending_->state);
  std::copy_n(pending_tint_, 4, draw.tint);
  if (capture_) capture_->add(*draw.geometry, *draw.state, *draw.textures[0], false);
  if (pending_->decision.taking == Taking::sky)
    scene_->add_sky(draw);
  else
    scene_->add_opaque(draw);
  pending_.reset();
}

// Its threads leave signals to those of the program.
void Frame::make_scene() {
  if (scene_) return;
  const SignalsWait signals_wait;
  scene_ = std::make_unique<TracedScene>();
}

void Frame::show(Piece piece, const float tint[4]) {
  if (!wants_scene() || gave_up()) return;
  if (piece.state.lighting) piece.state.lights = read_lighting();
  make_scene();
  if (is_light_map_of_pending(piece)) {
    Geometry both = *pending_->geometry;
    both.hashes.clear();
    for (size_t i = 0; i < both.vertices.size(); ++i) std::copy_n(piece.geometry->vertices[i].uv[0], 4, both.vertices[i].uv[1]);
    pending_->geometry = std::make_shared<const Geometry>(std::move(both));
    pending_->state.units[1] = piece.state.units[0];
    return;
  }
  add_pending();
  if (!piece.decision.is_seen) return;
  pending_ = std::move(piece);
  std::copy_n(tint, 4, pending_tint_);
}

void Frame::hold(std::vector<Piece> pieces, GLuint list, const float tint[4]) {
  make_scene();
  if (held_.empty()) projection_ = pieces.front().state.projection, viewport_ = pieces.front().state.viewport;
  Held& held = held_.emplace_back();
  held.state = SavedState::read();
  held.list = list;
  held.in_turn = std::all_of(pieces.begin(), pieces.end(), [](const Piece& piece) { return piece.decision.in_turn; });
  held.pieces = std::move(pieces);
  holds_stencil_ = holds_stencil_ || (!held.in_turn && held.pieces.front().state.stencil_test);
  for (const Piece& piece : held.pieces) {
    if (piece.decision.taking == Taking::reflects)
      add_reflector(held, piece);
    else
      show(piece, piece.state.lighting ? untinted : tint);
  }
  if (held_.size() > 1) pass_on_reflectors(held);
  if (!held.in_turn) ++figures_.held;
}

void Frame::add_reflector(Held& held, const Piece& piece) {
  if (held_.size() > 1 && is_later_stage(piece)) return;
  add_pending();
  const SceneDraw draw = scene_draw(*piece.geometry, piece.hash, piece.state);
  if (capture_) capture_->add(*draw.geometry, *draw.state, *draw.textures[0], true);
  const uint32_t id = scene_->add_mirror(draw);
  if (id == 0) return;
  const Rule& rule = piece.decision.rule;
  held.reflectors.push_back({piece.geometry.get(), piece.state.modelview, id, rule.reflectance, rule.kind != Kind::mirror});
}

void Frame::pass_on_reflectors(Held& next) {
  Held& before = held_[held_.size() - 2];
  if (before.reflectors.empty() || next.in_turn || next.pieces.size() != 1 || before.pieces.size() != 1) return;
  if (!is_same_surface(before.pieces[0], next.pieces[0])) return;
  next.reflectors = std::move(before.reflectors);
  before.reflectors.clear();
}

// Whether the draw held before is of the same surface and reflects already.
bool Frame::is_later_stage(const Piece& piece) const {
  const Held& before = held_[held_.size() - 2];
  return !before.reflectors.empty() && before.pieces.size() == 1 && is_same_surface(before.pieces[0], piece);
}

bool Frame::trace() {
  std::vector<Reflector> reflectors;
  std::vector<const SavedState*> states;
  for (const Held& held : held_)
    for (const Reflector& reflector : held.reflectors) reflectors.push_back(reflector), states.push_back(&held.state);
  if (reflectors.empty()) return false;
  add_pending();
  GLfloat clear[4] = {};
  real().GetFloatv(GL_COLOR_CLEAR_VALUE, clear);
  scene_->set_background({clear[0], clear[1], clear[2]});
  scene_->commit();
  if (!reflections_) reflections_ = std::make_unique<Reflections>(*scene_);
  reflections_->trace(static_cast<uint32_t>(figures_.batches), reflectors, states, projection_, viewport_);
  const sideray_frame_stats& stats = reflections_->stats();
  figures_.trace_ms += stats.trace_ms;
  figures_.rays += stats.rays_reflection;
  figures_.layers += stats.layers_found;
  figures_.instances = scene_->instances();
  figures_.meshes = scene_->meshes();
  ++figures_.batches;
  write_scene();
  return true;
}

void Frame::write_scene() {
  if (!capture_) return;
  capture_->set_camera(projection_);
  if (!capture_->write(settings().capture)) say("--capture: " + settings().capture + " cannot be written; name a file in a folder that is there");
  capture_.reset();
  captured_ = true;
}

void Frame::draw_held(Draws which, bool with_rays) {
  const Functions& gl = real();
  for (const Held& held : held_) {
    if (which != Draws::all && (which == Draws::in_turn) != held.in_turn) continue;
    held.state.apply();
    if (held.list != 0)
      gl.CallList(held.list);
    else
      for (const Piece& piece : held.pieces) run::draw(*piece.geometry);
    if (!with_rays) continue;
    for (const Reflector& reflector : held.reflectors) reflections_->draw(reflector);
  }
}

void Frame::write_picture(const Picture& picture, const char* which) const {
  const std::string path = settings().pictures + "/" + std::to_string(number_) + "-" + which + ".png";
  if (!picture.write(path)) say("--pictures: " + path + " cannot be written; name a folder that is there");
}

// White where answers are drawn, black elsewhere.
void Frame::draw_marks() {
  const Functions& gl = real();
  gl.Disable(GL_SCISSOR_TEST);
  gl.ColorMask(1, 1, 1, 1);
  gl.ClearColor(0, 0, 0, 0);
  gl.Clear(GL_COLOR_BUFFER_BIT);
  for (const Held& held : held_)
    for (const Reflector& reflector : held.reflectors) {
      held.state.apply();
      reflections_->mark(reflector);
    }
}

// The program has drawn all in its order; now as ever: what is opaque, rays, what waited for them.
void Frame::draw_both_ways() {
  const Picture own(viewport_);
  start_->restore();
  draw_held(Draws::in_turn, false);
  const bool with_rays = try_to_trace();
  const Picture opaque(viewport_);
  draw_held(Draws::waiting, with_rays);
  if (!with_rays) return;
  const Picture rays(viewport_);
  opaque.restore();
  draw_marks();
  write_picture(own, "own");
  write_picture(rays, "rays");
  write_picture(Picture(viewport_), "marks");
  rays.restore();
}

bool Frame::try_to_trace() {
  try {
    return !gave_up() && trace();
  } catch (const std::exception& error) {
    real().BindFramebuffer(GL_FRAMEBUFFER, 0);
    give_up(error.what());
    return false;
  }
}

void Frame::compare_no_more() {
  if (!compares_ || held_.empty()) return;
  if (const AllState all; all.saved()) start_->restore();
  compares_ = false;
  flush();
}

void Frame::trace_and_draw() {
  const AllState all;
  if (!all.saved()) throw std::runtime_error("the program has filled the stack of attributes; it cannot be helped");
  if (compares_)
    draw_both_ways();
  else
    draw_held(Draws::all, try_to_trace());
}

void Frame::flush() {
  if (held_.empty() || flushing_) return;
  const SignalsWait signals_wait;
  flushing_ = true;
  try {
    trace_and_draw();
  } catch (const std::exception& error) {
    give_up(error.what());
  }
  held_.clear();
  flushing_ = holds_stencil_ = false;
  compares_ = false;
  start_.reset();
}

void Frame::end() {
  const SignalsWait signals_wait;
  flush();
  if (renderer_.empty()) renderer_ = reinterpret_cast<const char*>(real().GetString(GL_RENDERER));
  figures_.pixels = static_cast<uint64_t>(viewport_[2]) * static_cast<uint64_t>(viewport_[3]);
  if (reflections_) figures_.reflecting = reflections_->fragments_answered(), reflections_->advance();
  const auto now = std::chrono::steady_clock::now();
  if (number_ > 0) figures_.frame_ms = std::chrono::duration<double, std::milli>(now - began_).count();
  began_ = now;
  survey_.end_frame(figures_);
  figures_ = {};
  ++number_;
  compares_ = is_compared(number_);
  pending_.reset();
  capture_.reset();
  if (tracing_ && !captured_ && !settings().capture.empty()) capture_ = std::make_unique<SceneFile>();
  if (scene_) scene_->begin_frame();
  drew_opaque_ = false;
  if (++frames_without_ > frames_of_interest) tracing_ = false;
  if (now - reported_ < time_between_reports) return;
  reported_ = now;
  write_report();
}

void Frame::close(bool current) {
  const SignalsWait signals_wait;
  if (current) flush();
  held_.clear();
  if (reflections_ && !current) reflections_->abandon();
  pending_.reset();
  reflections_.reset();
  scene_.reset();
  textures_.clear();
  write_report();
}

void Frame::give_up(const std::string& reason) {
  if (gave_up()) return;
  ended_ = reason;
  say("the program is passed through: " + reason);
}

void Frame::write_report() const {
  if (settings().report.empty()) return;
  if (!survey_.write(settings().report, renderer_, ended_)) say("--report: " + settings().report + " cannot be written; name a file in a folder that is there");
}

}  // namespace sideray::run
