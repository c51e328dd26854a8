#include "gl/passes/shadow_filter_pass.h"

#include <string>
#include <utility>

#include "gl/resources/raster_textures.h"
#include "model/failure.h"

namespace sideray::gl {
namespace {

constexpr uint32_t tile_side = 16;
constexpr int passes = 4;

enum Unit { visibility_unit, hit_unit, depth_unit, motion_unit, tile_unit, guide_unit, filtered_unit, history_unit };
constexpr const char* samplers[] = {"noisy_visibility", "hit_distances", "view_depth", "motion_vectors",
                                    "tile_map",         "guide",         "filtered",   "history"};

Program make_program(const Functions& gl, int stage) {
  const ShaderSpec fragment{{"shadow_filter.h", "raster_shadow_filter.frag.glsl"}, {"STAGE " + std::to_string(stage)}};
  Program program(gl, "shadow filter " + std::to_string(stage), {{"raster_screen.vert.glsl"}, {}}, fragment);
  program.use();
  int unit = 0;
  for (const char* name : samplers) program.set(name, unit++);
  return program;
}

}  // namespace

ShadowFilterPass::ShadowFilterPass(const Functions& gl) : gl_(gl), screen_(gl), framebuffer_(gl) {
  for (int stage = 0; stage < stage_count; ++stage) programs_[stage] = make_program(gl, stage);
}

Texture ShadowFilterPass::make_texture(GLint format, GLenum channels, uint32_t width, uint32_t height) const {
  Texture texture(gl_);
  gl_.ActiveTexture(GL_TEXTURE0);
  gl_.BindTexture(GL_TEXTURE_2D, texture.id());
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
  gl_.TexImage2D(GL_TEXTURE_2D, 0, format, static_cast<GLsizei>(width), static_cast<GLsizei>(height), 0, channels,
                 GL_FLOAT, nullptr);
  return texture;
}

void ShadowFilterPass::release() {
  tiles_.reset(), around_.reset(), guide_.reset();
  for (Texture* pair : {visibility_, history_}) pair[0].reset(), pair[1].reset();
  width_ = height_ = 0;
}

void ShadowFilterPass::fit(uint32_t width, uint32_t height) {
  if (width == width_ && height == height_) return;
  width_ = width, height_ = height, follows_ = filtered_ = false;
  try {
    gl_.BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    const uint32_t tiles_x = (width + tile_side - 1) / tile_side, tiles_y = (height + tile_side - 1) / tile_side;
    tiles_ = make_texture(GL_RGBA32F, GL_RGBA, tiles_x, tiles_y);
    around_ = make_texture(GL_RGBA32F, GL_RGBA, tiles_x, tiles_y);
    guide_ = make_texture(GL_RGBA32F, GL_RGBA, width, height);
    for (Texture& texture : visibility_) texture = make_texture(GL_R32F, GL_RED, width, height);
    for (Texture& texture : history_) texture = make_texture(GL_RGBA32F, GL_RGBA, width, height);
    check_allocation(gl_, "shadow filter");
  } catch (...) {
    release();
    throw;
  }
}

void ShadowFilterPass::abandon() {
  for (Program& program : programs_) program.abandon();
  screen_.abandon(), framebuffer_.abandon();
  tiles_.abandon(), around_.abandon(), guide_.abandon();
  for (Texture* pair : {visibility_, history_}) pair[0].abandon(), pair[1].abandon();
  width_ = height_ = 0;
}

void ShadowFilterPass::bind(int unit, uint32_t texture) const {
  gl_.ActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  gl_.BindTexture(GL_TEXTURE_2D, texture);
}

// The target must not stay bound where a sampler could read it.
const Program& ShadowFilterPass::begin(Stage stage, const Texture& target, const ShadowFilterTextures& input) const {
  gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
  gl_.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, target.id(), 0);
  if (const GLenum status = gl_.CheckFramebufferStatus(GL_FRAMEBUFFER); status != GL_FRAMEBUFFER_COMPLETE)
    fail(SIDERAY_UNSUPPORTED, "shadow filter's framebuffer: incomplete ({:#x}) on {}; use another device", status,
         gl_.renderer);
  const bool of_tiles = stage == tile_stage || stage == around_stage;
  const auto share = [&](uint32_t pixels) {
    return static_cast<GLsizei>(of_tiles ? (pixels + tile_side - 1) / tile_side : pixels);
  };
  gl_.Viewport(0, 0, share(width_), share(height_));
  const Program& program = programs_[stage];
  program.use();
  const shading::SfView& view = input.view;
  program.set("size", glm::ivec2(width_, height_));
  program.set("view.origin_x", view.origin_x), program.set("view.origin_y", view.origin_y);
  program.set("view.step_x", view.step_x), program.set("view.step_y", view.step_y);
  program.set("view.before", view.before), program.set("view.before_offset", view.before_offset);
  program.set("light.position", input.light.position), program.set("light.radius", input.light.radius);
  program.set("light.tan_radius", input.light.tan_radius);
  program.set("light.most_penumbra", input.light.most_penumbra);
  program.set("light.most_frames", input.light.most_frames);
  program.set("has_motion", static_cast<int>(input.motion != 0));
  for (const int unit : {tile_unit, guide_unit, filtered_unit, history_unit}) bind(unit, 0);
  return program;
}

void ShadowFilterPass::draw() const {
  gl_.BindVertexArray(screen_.id());
  gl_.DrawArrays(GL_TRIANGLES, 0, 3);
}

void ShadowFilterPass::draw_guide(const ShadowFilterTextures& input) {
  begin(tile_stage, tiles_, input);
  draw();
  begin(around_stage, around_, input);
  bind(tile_unit, tiles_.id());
  draw();
  begin(guide_stage, guide_, input);
  bind(tile_unit, around_.id());
  draw();
}

void ShadowFilterPass::spatial(const ShadowFilterTextures& input) {
  fit(input.width, input.height);
  bind(visibility_unit, input.visibility), bind(hit_unit, input.hit_distance);
  bind(depth_unit, input.depth), bind(motion_unit, 0);
  draw_guide(input);
  for (int pass = 0; pass < passes; ++pass) {
    const Program& program = begin(blur_stage, visibility_[1], input);
    program.set("filter_step", 1 << pass);
    bind(tile_unit, around_.id()), bind(guide_unit, guide_.id());
    bind(filtered_unit, pass == 0 ? input.visibility : visibility_[0].id());
    draw();
    std::swap(visibility_[0], visibility_[1]);
  }
  filtered_ = true;
}

void ShadowFilterPass::follow(const shading::SfLight& light) {
  if (!filtered_ || follows_) return;
  ShadowFilterTextures last;
  last.width = width_, last.height = height_, last.light = light;
  temporal(last);
}

void ShadowFilterPass::temporal(const ShadowFilterTextures& input, bool again) {
  if (input.width != width_ || input.height != height_)
    fail(SIDERAY_INVALID_ARGUMENT, "shadow filter: no frame of {} x {} was filtered; call spatial() first", input.width,
         input.height);
  if (!follows_) {
    gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    gl_.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, history_[current_].id(), 0);
    const float none[4] = {};
    gl_.ClearBufferfv(GL_COLOR, 0, none);
  }
  if (!again || !follows_) current_ = 1 - current_;
  begin(accumulate_stage, history_[current_], input);
  bind(motion_unit, input.motion);
  bind(tile_unit, around_.id()), bind(guide_unit, guide_.id());
  bind(filtered_unit, visibility_[0].id()), bind(history_unit, history_[1 - current_].id());
  draw();
  follows_ = true;
}

}  // namespace sideray::gl
