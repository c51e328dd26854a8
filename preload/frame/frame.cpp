#include "preload/frame/frame.h"

#include <algorithm>
#include <chrono>

#include "preload/base/settings.h"
#include "preload/base/signals.h"
#include "preload/gl/functions.h"

namespace sideray::run {
namespace {

constexpr int frames_of_interest = 60;    // after so many frames without reflectors the scene is no longer captured
constexpr auto time_between_reports = std::chrono::seconds(3);  // so that a killed program leaves a report, too
constexpr uint64_t frames_a_picture = 30;

// Returns whether a draw is alpha-blended, premultiplied or not.
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
  if (rule.kind == Kind::ignore || !state.writes_color) return joins_later && holds_later() ? Taking::held : Taking::left;
  if (is_reflector(rule.kind)) return Taking::reflects;
  const bool behind_all = !state.depth_test || !state.depth_write;
  const bool may_be_sky = behind_all && !drew_opaque_ && !is_holding();
  if (rule.kind == Kind::sky || (may_be_sky && (!state.blend || blends_by_alpha(state)))) return Taking::sky;
  if (rule.kind == Kind::opaque || !joins_later) return Taking::opaque;
  return holds_later() ? Taking::held : Taking::left;
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
    decision.rule = rules_.guess(), decision.rule.guessed = true;
  decision.taking = taking_of(state, decision.rule);
  if (bool has_holes = false; decision.rule.kind == Kind::unknown && covers(state, geometry, has_holes)) {
    decision.is_seen = true;
    // A draw without holes looks the same before and after the held draws. At glBegin its vertices are not known yet.
    if (!is_holding() || (geometry && !has_holes)) decision.taking = Taking::opaque;
  }
  const bool is_solid = !state.blend && state.depth_test && state.depth_write && state.depth_func != GL_EQUAL;
  decision.is_seen = decision.is_seen || decision.taking == Taking::opaque || decision.taking == Taking::sky ||
                     (decision.taking == Taking::held && is_solid && state.writes_color && decision.rule.kind != Kind::ignore);
  const bool casts = decision.taking == Taking::opaque && is_lit_by_sun(state);
  if ((decision.holds() || casts) && is_waiting() && has_other_view(state)) flush();
  if (decision.taking == Taking::opaque && state.depth_write) drew_opaque_ = true;
  if (casts && !settings().off) {
    if (!is_waiting()) projection_ = state.projection, viewport_ = state.viewport;
    tracing_ = casts_ = true, frames_without_ = 0;
  }
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

// Returns whether a piece is the second stage of the pending opaque surface and multiplies it, as light maps do.
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
  if (pending_->decision.taking == Taking::opaque && rules_.sun() >= 0) {
    note_shadows(receivers_.add(pending_->state, pending_->geometry, draw.textures[0]->hash, pending_->decision.rule,
                                rules_.sun()));
  }
  pending_.reset();
}

void Frame::note_shadows(Receivers::Taken taken) {
  if (taken == Receivers::Taken::other_sun)
    survey_.miss("draws that the sun lights from another place than others: no shadows fall on them");
  scene_->set_sun(receivers_.sun());
}

// SignalsWait keeps the scene's threads from handling the program's signals.
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
  if (!is_waiting()) projection_ = pieces.front().state.projection, viewport_ = pieces.front().state.viewport;
  Held& held = held_.emplace_back();
  held.state = SavedState::read();
  held.list = list;
  held.in_turn = std::all_of(pieces.begin(), pieces.end(), [](const Piece& piece) { return piece.decision.in_turn; });
  held.pieces = std::move(pieces);
  holds_stencil_ = holds_stencil_ || (!held.in_turn && held.pieces.front().state.stencil_test);
  for (Piece& piece : held.pieces) {
    add_shadows(held, piece);
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
  const Rule& rule = piece.decision.rule;
  const MirrorIds ids = scene_->add_mirror(draw, rule);
  if (ids.mirror == 0) return;
  held.reflectors.push_back({piece.geometry.get(), piece.state.modelview, ids, rule.reflectance, rule.kind != Kind::mirror});
  if (ids.bent != 0) held.bending.push_back(held.reflectors.back());
}

// Lets shadows fall on a held draw. A draw that multiplies the picture needs none, as the picture is in shadow already.
void Frame::add_shadows(Held& held, Piece& piece) {
  const bool waits = piece.decision.taking == Taking::held || piece.decision.taking == Taking::reflects;
  if (!waits || rules_.sun() < 0 || !piece.state.lighting || multiplies(piece.state) ||
      piece.decision.rule.kind == Kind::ignore)
    return;
  piece.state.lights = read_lighting();
  const Receivers::Taken taken =
      receivers_.hold(piece.state, piece.geometry, textures_.find(piece.state.texture()).hash, rules_.sun());
  note_shadows(taken);
  if (taken != Receivers::Taken::receives) return;
  held.in_shadow = held.state.free_unit() >= 0;
  if (!held.in_shadow) survey_.miss("draws of four textures that are held back: no shadows fall on them");
}

HeldDraw Frame::Held::draw() const {
  HeldDraw draw{&state, list, {}};
  for (const Piece& piece : pieces) draw.geometry.push_back(piece.geometry.get());
  return draw;
}

void Frame::pass_on_reflectors(Held& next) {
  Held& before = held_[held_.size() - 2];
  if (before.reflectors.empty() || next.in_turn || next.pieces.size() != 1 || before.pieces.size() != 1) return;
  if (!is_same_surface(before.pieces[0], next.pieces[0])) return;
  next.reflectors = std::move(before.reflectors);
  before.reflectors.clear();
}

// Returns whether the previous held draw shows the same surface and reflects already.
bool Frame::is_later_stage(const Piece& piece) const {
  const Held& before = held_[held_.size() - 2];
  return !before.reflectors.empty() && before.pieces.size() == 1 && is_same_surface(before.pieces[0], piece);
}

Batch Frame::batch() const {
  Batch batch;
  batch.number = static_cast<uint32_t>(figures_.batches);
  for (const Held& held : held_) {
    for (const Reflector& reflector : held.reflectors) batch.reflectors.push_back(reflector), batch.states.push_back(&held.state);
    if (held.in_shadow) batch.shadowed.push_back(held.draw());
  }
  batch.receivers = &receivers_;
  batch.sun = rules_.sun();
  batch.projection = projection_;
  batch.viewport = viewport_;
  return batch;
}

bool Frame::trace(const Batch& batch) {
  if (batch.is_empty()) return false;
  if (batch.number >= Reflections::most_batches) {
    survey_.miss("parts of a frame beyond the sixteenth: nothing is traced for them");
    return false;
  }
  GLfloat clear[4] = {};
  real().GetFloatv(GL_COLOR_CLEAR_VALUE, clear);
  scene_->set_background({clear[0], clear[1], clear[2]});
  scene_->commit();
  if (!reflections_) reflections_ = std::make_unique<Reflections>(*scene_);
  reflections_->trace(batch);
  count(reflections_->stats());
  if (!batch.shadowed.empty()) count(reflections_->held_shadows()->stats(batch.number));
  figures_.instances = scene_->instances();
  figures_.meshes = scene_->meshes();
  ++figures_.batches;
  write_scene();
  return true;
}

void Frame::count(const sideray_frame_stats& stats) {
  figures_.trace_ms += stats.trace_ms;
  figures_.rays += stats.rays_reflection;
  figures_.shadow_rays += stats.rays_shadow;
  figures_.layers += stats.layers_found;
}

void Frame::write_scene() {
  if (!capture_) return;
  capture_->set_camera(projection_);
  if (!capture_->write(settings().capture)) say("--capture: " + settings().capture + " cannot be written; name a file in a folder that is there");
  capture_.reset();
  captured_ = true;
}

void Frame::draw_held(Draws which, bool with_rays) {
  for (const Held& held : held_) {
    if (which != Draws::all && (which == Draws::in_turn) != held.in_turn) continue;
    for (const Reflector& reflector : held.bending) {
      if (!with_rays) break;
      held.state.apply();
      reflections_->draw_behind(reflector);
    }
    held.state.apply();
    HeldShadows* shadows = with_rays && held.in_shadow ? reflections_->held_shadows() : nullptr;
    if (shadows) shadows->begin(held.state);
    held.draw().make();
    if (shadows) shadows->end(held.state);
    if (!with_rays) continue;
    for (const Reflector& reflector : held.reflectors) reflections_->draw(reflector);
  }
}

void Frame::write_picture(const Picture& picture, const char* which) const {
  const std::string path = settings().pictures + "/" + std::to_string(number_) + "-" + which + ".png";
  if (!picture.write(path)) say("--pictures: " + path + " cannot be written; name a folder that is there");
}

// Draws white where answers are drawn, and black elsewhere.
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
  reflections_->mark_shadows(viewport_);
}

// Keeps the picture that the program's own order made. Then draws the frame as usual: opaque draws, rays, held draws.
void Frame::draw_both_ways() {
  const Picture own(viewport_);
  if (start_) start_->restore();
  draw_held(Draws::in_turn, false);
  const bool with_rays = try_to_trace(batch());
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

bool Frame::try_to_trace(const Batch& batch) {
  try {
    if (gave_up() || !trace(batch)) return false;
    reflections_->draw_shadows(batch);
    return true;
  } catch (const std::exception& error) {
    real().BindFramebuffer(GL_FRAMEBUFFER, 0);
    give_up(error.what());
    return false;
  }
}

void Frame::compare_no_more() {
  if (!compares_ || held_.empty()) return;
  if (const AllState all; all.saved() && start_) start_->restore();
  compares_ = false;
  flush();
}

void Frame::trace_and_draw() {
  const AllState all;
  if (!all.saved()) throw std::runtime_error("the program has filled the stack of attributes; it cannot be helped");
  if (compares_)
    draw_both_ways();
  else
    draw_held(Draws::all, try_to_trace(batch()));
}

void Frame::flush() {
  if (!is_waiting() || flushing_) return;
  const SignalsWait signals_wait;
  flushing_ = true;
  try {
    add_pending();
    trace_and_draw();
  } catch (const std::exception& error) {
    give_up(error.what());
  }
  held_.clear();
  receivers_.clear();
  flushing_ = holds_stencil_ = casts_ = false;
  compares_ = false;
  start_.reset();
  if (signals_wait.has_one()) real().Finish();
}

void Frame::end() {
  const SignalsWait signals_wait;
  flush();
  if (renderer_.empty()) renderer_ = reinterpret_cast<const char*>(real().GetString(GL_RENDERER));
  figures_.pixels = static_cast<uint64_t>(viewport_[2]) * static_cast<uint64_t>(viewport_[3]);
  if (reflections_) {
    figures_.reflecting = reflections_->fragments_answered();
    figures_.in_shadow = reflections_->pixels_in_shadow();
    figures_.held_in_shadow = reflections_->held_in_shadow();
    reflections_->advance();
  }
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
  receivers_.begin_frame();
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
  receivers_.clear();
  casts_ = false;
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
