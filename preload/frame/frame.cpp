#include "preload/frame/frame.h"

#include <algorithm>
#include <chrono>
#include <fstream>

#include "preload/base/png.h"
#include "preload/base/settings.h"
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

bool is_reflector(Kind kind) {
  return kind == Kind::glass || kind == Kind::water || kind == Kind::mirror;
}

std::vector<uint8_t> read_pixels(const std::array<GLint, 4>& viewport) {
  const Functions& gl = real();
  std::vector<uint8_t> pixels(3 * static_cast<size_t>(viewport[2]) * static_cast<size_t>(viewport[3]));
  gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
  gl.ReadPixels(viewport[0], viewport[1], viewport[2], viewport[3], GL_RGB, GL_UNSIGNED_BYTE, pixels.data());
  return pixels;
}

std::vector<uint32_t> read_depth(const std::array<GLint, 4>& viewport) {
  std::vector<uint32_t> depth(static_cast<size_t>(viewport[2]) * static_cast<size_t>(viewport[3]));
  real().ReadPixels(viewport[0], viewport[1], viewport[2], viewport[3], GL_DEPTH_COMPONENT, GL_UNSIGNED_INT, depth.data());
  return depth;
}

// Puts colours and depth back.
void draw_pixels(const std::array<GLint, 4>& viewport, const std::vector<uint8_t>& pixels, const std::vector<uint32_t>& depth) {
  const Functions& gl = real();
  gl.PushAttrib(GL_ALL_ATTRIB_BITS);
  gl.UseProgram(0);
  for (const GLenum off : {GL_LIGHTING, GL_FOG, GL_BLEND, GL_ALPHA_TEST, GL_STENCIL_TEST, GL_DEPTH_TEST, GL_SCISSOR_TEST}) gl.Disable(off);
  for (GLenum unit = 0; unit < 4; ++unit) {
    gl.ActiveTexture(GL_TEXTURE0 + unit);
    gl.Disable(GL_TEXTURE_2D);
    gl.Disable(GL_TEXTURE_CUBE_MAP);
  }
  gl.ColorMask(1, 1, 1, 1);
  gl.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
  gl.PixelZoom(1, 1);
  gl.WindowPos2i(viewport[0], viewport[1]);
  gl.DrawPixels(viewport[2], viewport[3], GL_RGB, GL_UNSIGNED_BYTE, pixels.data());
  gl.ColorMask(0, 0, 0, 0);
  gl.Enable(GL_DEPTH_TEST);
  gl.DepthFunc(GL_ALWAYS);
  gl.DepthMask(1);
  gl.DepthRange(0, 1);
  gl.DrawPixels(viewport[2], viewport[3], GL_DEPTH_COMPONENT, GL_UNSIGNED_INT, depth.data());
  gl.PopAttrib();
}

// Stages of one surface have the same vertices in the same places.
bool is_same_surface(const Piece& a, const Piece& b) {
  const std::vector<Vertex>&u = a.geometry->vertices, &v = b.geometry->vertices;
  if (u.size() != v.size() || a.state.modelview != b.state.modelview || a.geometry->indices != b.geometry->indices) return false;
  return std::equal(u.begin(), u.end(), v.begin(), [](const Vertex& x, const Vertex& y) { return std::equal(x.position, x.position + 4, y.position); });
}

void write_picture(const std::string& path, const std::array<GLint, 4>& viewport, const std::vector<uint8_t>& pixels) {
  const size_t stride = 3 * static_cast<size_t>(viewport[2]);
  std::vector<uint8_t> rows;
  for (size_t y = static_cast<size_t>(viewport[3]); y-- > 0;)
    rows.insert(rows.end(), pixels.begin() + static_cast<std::ptrdiff_t>(y * stride), pixels.begin() + static_cast<std::ptrdiff_t>((y + 1) * stride));
  std::ofstream(path, std::ios::binary) << png(viewport[2], viewport[3], 3, rows);
}

}  // namespace

Frame::Frame() {
  try {
    if (!settings().rules.empty()) rules_ = Rules::read(settings().rules);
  } catch (const std::exception& error) {
    give_up(error.what());
  }
}

Frame::~Frame() = default;

Taking Frame::taking_of(const DrawState& state, const Rule& rule) const {
  const bool joins_later = state.blend || state.depth_func == GL_EQUAL;
  if (rule.kind == Kind::ignore || !state.writes_color) return joins_later && is_holding() ? Taking::held : Taking::left;
  if (is_reflector(rule.kind)) return Taking::reflects;
  const bool behind_all = !state.depth_test || !state.depth_write;
  const bool may_be_sky = behind_all && !drew_opaque_ && !is_holding();
  if (rule.kind == Kind::sky || (may_be_sky && (!state.blend || blends_by_alpha(state)))) return Taking::sky;
  if (rule.kind == Kind::opaque || !joins_later) return Taking::opaque;
  return is_holding() ? Taking::held : Taking::left;
}

bool Frame::has_other_view(const DrawState& state) const {
  return state.projection != projection_ || state.viewport != viewport_;
}

Decision Frame::decide(const DrawState& state, uint64_t mesh) {
  if (state.framebuffer != 0 || gave_up()) return {};
  const bool over_all = !state.is_perspective() || (!state.depth_test && (drew_opaque_ || is_holding()));
  if (over_all) {
    flush();
    return {};
  }
  const Texture& texture = textures_.find(state.texture[0]);
  Decision decision;
  decision.rule = rules_.find(texture.hash, mesh);
  if (decision.rule.kind == Kind::unknown && texture.hash == 0 && looks_like_glass(state))
    decision.rule = {Kind::glass, usual_reflectance(Kind::glass), true};
  decision.taking = taking_of(state, decision.rule);
  if (decision.holds() && is_holding() && has_other_view(state)) flush();
  if (decision.taking == Taking::opaque && state.depth_write) drew_opaque_ = true;
  survey_.note(texture, mesh, state, decision.taking, decision.rule);
  if (decision.taking == Taking::reflects) tracing_ = true, frames_without_ = 0;
  if (settings().off && decision.holds()) decision.taking = Taking::left;
  return decision;
}

SceneDraw Frame::scene_draw(const Geometry& geometry, uint64_t hash, const DrawState& state) {
  SceneDraw draw;
  draw.geometry = &geometry;
  draw.hash = hash;
  draw.state = &state;
  for (size_t unit = 0; unit < 2; ++unit) draw.textures[unit] = &textures_.find(state.texture[unit]);
  return draw;
}

// The second stage of an opaque surface, which multiplies: a light map as a rule.
bool Frame::is_light_map_of_pending(const Piece& piece) const {
  if (!pending_ || pending_->state.texture[1] != 0 || piece.state.texture[0] == 0 || !multiplies(piece.state)) return false;
  return is_same_surface(*pending_, piece);
}

void Frame::add_pending() {
  if (!pending_) return;
  SceneDraw draw = scene_draw(*pending_->geometry, hash_of(*pending_->geometry, pending_->state.shows_colors()), pending_->state);
  std::copy_n(pending_tint_, 4, draw.tint);
  if (capture_) capture_->add(*draw.geometry, *draw.state, *draw.textures[0], false);
  if (pending_->decision.taking == Taking::sky)
    scene_->add_sky(draw);
  else
    scene_->add_opaque(draw);
  pending_.reset();
}

void Frame::show(Piece piece, const float tint[4]) {
  if (!wants_scene() || gave_up()) return;
  if (!scene_) scene_ = std::make_unique<TracedScene>();
  if (is_light_map_of_pending(piece)) {
    Geometry both = *pending_->geometry;
    for (size_t i = 0; i < both.vertices.size(); ++i) std::copy_n(piece.geometry->vertices[i].uv[0], 4, both.vertices[i].uv[1]);
    pending_->geometry = std::make_shared<const Geometry>(std::move(both));
    pending_->state.texture[1] = piece.state.texture[0];
    return;
  }
  add_pending();
  if (piece.decision.taking != Taking::opaque && piece.decision.taking != Taking::sky) return;
  pending_ = std::move(piece);
  std::copy_n(tint, 4, pending_tint_);
}

void Frame::hold(std::vector<Piece> pieces, GLuint list) {
  if (!scene_) scene_ = std::make_unique<TracedScene>();
  add_pending();
  Held& held = held_.emplace_back();
  held.state = SavedState::read();
  held.list = list;
  held.pieces = std::move(pieces);
  if (held_.size() == 1) projection_ = held.pieces.front().state.projection, viewport_ = held.pieces.front().state.viewport;
  for (const Piece& piece : held.pieces) {
    if (piece.decision.taking != Taking::reflects) continue;
    if (held_.size() > 1 && is_later_stage(piece)) continue;
    const SceneDraw draw = scene_draw(*piece.geometry, piece.hash, piece.state);
    if (capture_) capture_->add(*draw.geometry, *draw.state, *draw.textures[0], true);
    const uint32_t id = scene_->add_mirror(draw);
    if (id == 0) continue;
    const Rule& rule = piece.decision.rule;
    held.reflectors.push_back({piece.geometry.get(), piece.state.modelview, id, rule.reflectance, rule.kind != Kind::mirror});
  }
  if (held_.size() > 1) pass_on_reflectors(held);
  ++figures_.held;
}

void Frame::pass_on_reflectors(Held& next) {
  Held& before = held_[held_.size() - 2];
  if (before.reflectors.empty() || next.pieces.size() != 1 || before.pieces.size() != 1) return;
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
  reflections_->trace(reflectors, states, projection_, viewport_);
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

void Frame::draw_held(bool with_rays) {
  const Functions& gl = real();
  for (const Held& held : held_) {
    held.state.apply();
    if (held.list != 0)
      gl.CallList(held.list);
    else
      for (const Piece& piece : held.pieces) run::draw(*piece.geometry);
    if (!with_rays) continue;
    for (const Reflector& reflector : held.reflectors) reflections_->draw(reflector);
  }
}

std::string Frame::picture_path(const char* which) const {
  return settings().pictures + "/" + std::to_string(number_) + "-" + which + ".png";
}

// The held draws without rays and with them, each as a picture.
void Frame::draw_both_ways() {
  const std::vector<uint8_t> behind = read_pixels(viewport_);
  const std::vector<uint32_t> depth = read_depth(viewport_);
  draw_held(false);
  write_picture(picture_path("before"), viewport_, read_pixels(viewport_));
  draw_pixels(viewport_, behind, depth);
  draw_held(true);
  write_picture(picture_path("after"), viewport_, read_pixels(viewport_));
}

void Frame::trace_and_draw() {
  const AllState all;
  if (!all.saved()) throw std::runtime_error("the program has filled the stack of attributes; it cannot be helped");
  bool with_rays = false;
  try {
    with_rays = !gave_up() && trace();
  } catch (const std::exception& error) {
    real().BindFramebuffer(GL_FRAMEBUFFER, 0);
    give_up(error.what());
  }
  if (with_rays && !settings().pictures.empty() && number_ % frames_a_picture == 0 && figures_.batches == 1)
    draw_both_ways();
  else
    draw_held(with_rays);
}

void Frame::flush() {
  if (held_.empty() || flushing_) return;
  flushing_ = true;
  try {
    trace_and_draw();
  } catch (const std::exception& error) {
    give_up(error.what());
  }
  held_.clear();
  flushing_ = false;
}

void Frame::end() {
  flush();
  if (renderer_.empty()) renderer_ = reinterpret_cast<const char*>(real().GetString(GL_RENDERER));
  figures_.pixels = static_cast<uint64_t>(viewport_[2]) * static_cast<uint64_t>(viewport_[3]);
  if (reflections_) figures_.reflecting = reflections_->fragments_answered();
  survey_.end_frame(figures_);
  figures_ = {};
  ++number_;
  pending_.reset();
  capture_.reset();
  if (tracing_ && !captured_ && !settings().capture.empty()) capture_ = std::make_unique<SceneFile>();
  if (scene_) scene_->begin_frame();
  drew_opaque_ = false;
  if (++frames_without_ > frames_of_interest) tracing_ = false;
  const auto now = std::chrono::steady_clock::now();
  if (now - reported_ < time_between_reports) return;
  reported_ = now;
  write_report();
}

void Frame::close(bool current) {
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
