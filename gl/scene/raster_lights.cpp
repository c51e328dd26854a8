#include "gl/scene/raster_lights.h"

#include <algorithm>
#include <bit>
#include <tuple>

#include "gl/scene/raster_view.h"
#include "model/failure.h"

namespace sideray::gl {
namespace {

constexpr uint64_t most_kept_bits = uint64_t{1} << 28;  // layers times instances: two bits each, 64 MiB
constexpr size_t lights_in_row = 256, texels_a_light = 8;  // in the texture of many lights

// Has the layout std140 of shaders/light/raster_lighting.glsl.
struct LightRecord {
  glm::vec4 position_range, direction_inner, intensity_outer;
  glm::ivec4 type_map_layer_texel;
};
static_assert(sizeof(LightRecord) == 64);

LightRecord record_of(const model::Light& light, const LightShadow& shadow) {
  return {glm::vec4(light.position, light.range),
          glm::vec4(light.direction, light.cos_inner),
          glm::vec4(light.intensity, light.cos_outer),
          {light.type, static_cast<int>(shadow.map), static_cast<int>(shadow.first_layer),
           std::bit_cast<int>(shadow.texel)}};
}

// Returns the distance from a light to the far end of a box: casters that end nearer often hide those that end farther.
float reach_from(const model::Light& light, const model::Bounds& bounds) {
  if (light.type != SIDERAY_LIGHT_DIRECTIONAL)
    return glm::length(glm::max(glm::abs(bounds.minimum - light.position), glm::abs(bounds.maximum - light.position)));
  const glm::vec3 last = glm::mix(bounds.minimum, bounds.maximum, glm::greaterThan(light.direction, glm::vec3(0.0f)));
  return glm::dot(last, light.direction);
}

std::vector<const Draw*> casters_of(const RasterScene& scene) {
  std::vector<const Draw*> casters;
  for (const Draw& draw : scene.opaque())
    if (draw.casts_shadow) casters.push_back(&draw);
  return casters;
}

// Sorts casters by the distance at which they end, so that those that hide others from the light come first: fragments
// that fail the depth test write nothing. Still casters precede those in wind, since their programs differ.
std::vector<const Draw*> by_reach(std::span<const Draw* const> casters, const model::Light& light) {
  std::vector<std::tuple<bool, float, const Draw*>> keyed;
  keyed.reserve(casters.size());
  for (const Draw* draw : casters) keyed.emplace_back(draw->wind != 0, reach_from(light, draw->bounds), draw);
  std::sort(keyed.begin(), keyed.end());
  std::vector<const Draw*> order;
  order.reserve(keyed.size());
  for (const auto& key : keyed) order.push_back(std::get<const Draw*>(key));
  return order;
}

void set_block(const Functions& gl, const Buffer& buffer, const void* bytes, size_t size) {
  gl.BindBuffer(GL_UNIFORM_BUFFER, buffer.id());
  gl.BufferData(GL_UNIFORM_BUFFER, static_cast<GLsizeiptr>(size), bytes, GL_STATIC_DRAW);
}

}  // namespace

RasterLights::RasterLights(const Functions& gl) : gl_(gl), lights_(gl), shadows_(gl), tints_(gl) {
  GLint layers = 0, side = 0;
  gl.GetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &layers);
  gl.GetIntegerv(GL_MAX_TEXTURE_SIZE, &side);
  limits_ = {gl.clip_control, static_cast<uint32_t>(layers), static_cast<uint32_t>(side)};
}

void RasterLights::set_scene(const RasterScene& scene) {
  const model::Snapshot& snapshot = scene.snapshot();
  drawn_ = false;
  follow_casters(scene);
  if (!scene.kept_surfaces()) casters_ = casters_of(scene);
  if (scene.kept_surfaces() && snapshot.lights == planned_) return;
  tints_.forget();
  planned_.reset();
  if (snapshot.lights.size() > most_in_blocks && gl_.texture_units <= static_cast<int>(unit::many_lights))
    fail(SIDERAY_UNSUPPORTED, "{} lights: this driver ({}) has {} texture units, and more than {} lights need {}; use "
         "fewer lights", snapshot.lights.size(), gl_.renderer, gl_.texture_units, most_in_blocks, unit::many_lights + 1);
  plan_ = plan_shadow_maps(snapshot.lights, shadow_casters(snapshot), limits_);
  light_count_ = static_cast<uint32_t>(snapshot.lights.size());
  if (are_many())
    upload_texture(snapshot.lights);
  else
    upload_blocks(snapshot.lights);
  planned_ = snapshot.lights;
}

void RasterLights::upload_blocks(const std::vector<model::Light>& lights) {
  std::vector<LightRecord> records(most_in_blocks);
  std::vector<glm::mat4> matrices(most_in_blocks);
  for (size_t i = 0; i < lights.size(); ++i) {
    records[i] = record_of(lights[i], plan_.lights[i]);
    matrices[i] = plan_.lights[i].shadow_from_local;
  }
  set_block(gl_, lights_, records.data(), records.size() * sizeof(LightRecord));
  set_block(gl_, shadows_, matrices.data(), matrices.size() * sizeof(glm::mat4));
  texels_ = {};
}

void RasterLights::upload_texture(const std::vector<model::Light>& lights) {
  const size_t rows = (lights.size() + lights_in_row - 1) / lights_in_row, width = lights_in_row * texels_a_light;
  std::vector<glm::vec4> texels(rows * width, glm::vec4(0.0f));
  for (size_t i = 0; i < lights.size(); ++i) {
    const LightShadow& shadow = plan_.lights[i];
    const LightRecord record = record_of(lights[i], shadow);
    glm::vec4* to = &texels[i * texels_a_light];
    to[0] = record.position_range;
    to[1] = record.direction_inner;
    to[2] = record.intensity_outer;
    to[3] = glm::vec4(glm::vec3(record.type_map_layer_texel), shadow.texel);
    for (int c = 0; c < 4; ++c) to[4 + c] = shadow.shadow_from_local[c];
  }
  texels_ = Texture(gl_);
  gl_.BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
  gl_.PixelStorei(GL_UNPACK_ALIGNMENT, 4);
  gl_.ActiveTexture(GL_TEXTURE0);
  gl_.BindTexture(GL_TEXTURE_2D, texels_.id());
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  gl_.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
  gl_.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, static_cast<GLsizei>(width), static_cast<GLsizei>(rows), 0, GL_RGBA,
                 GL_FLOAT, texels.data());
  check_allocation(gl_, "lights");
}

void RasterLights::allocate(Maps& maps, uint32_t size, uint32_t layers) {
  if (layers == 0) maps = {};
  if (layers == 0 || (maps.size == size && maps.layers == layers)) return;
  maps = {Texture(gl_), Framebuffer(gl_), size, layers, std::vector<LayerCasters>(layers)};
  gl_.ActiveTexture(GL_TEXTURE0);
  gl_.BindTexture(GL_TEXTURE_2D_ARRAY, maps.texture.id());
  const auto set = [&](GLenum parameter, GLenum value) {
    gl_.TexParameteri(GL_TEXTURE_2D_ARRAY, parameter, static_cast<GLint>(value));
  };
  set(GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  set(GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  set(GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  set(GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  set(GL_TEXTURE_MAX_LEVEL, 0);
  set(GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  set(GL_TEXTURE_COMPARE_FUNC, limits_.reversed_depth ? GL_GEQUAL : GL_LEQUAL);
  gl_.TexImage3D(GL_TEXTURE_2D_ARRAY, 0, GL_DEPTH_COMPONENT32F, static_cast<GLsizei>(size), static_cast<GLsizei>(size),
                 static_cast<GLsizei>(layers), 0, GL_DEPTH_COMPONENT, GL_FLOAT, nullptr);
  check_allocation(gl_, "shadow maps");
}

void RasterLights::begin_pass() const {
  if (gl_.clip_control)
    gl_.ClipControl(GL_LOWER_LEFT, limits_.reversed_depth ? GL_ZERO_TO_ONE : GL_NEGATIVE_ONE_TO_ONE);
  gl_.ColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  gl_.Disable(GL_BLEND);
  gl_.Disable(GL_STENCIL_TEST);
  gl_.Disable(GL_SCISSOR_TEST);
  gl_.Disable(GL_CULL_FACE);  // rays hit both sides too
  gl_.Enable(GL_DEPTH_TEST);
  gl_.DepthMask(GL_TRUE);
  gl_.DepthFunc(limits_.reversed_depth ? GL_GREATER : GL_LESS);
  // Moves depth by one texel of slope and a few units of rounding; the lookup adds its offset along the normal.
  gl_.Enable(GL_POLYGON_OFFSET_FILL);
  const float away = limits_.reversed_depth ? -1.0f : 1.0f;
  gl_.PolygonOffset(1.0f * away, 4.0f * away);
}

// Draws the casters that the layer does not hold yet; calls `begin` before each.
template <typename Begin>
void RasterLights::draw_casters(LayerCasters& held, const Pass& pass, const Layer& layer,
                                std::span<const Draw* const> order, const Begin& begin) {
  RasterScene& scene = pass.scene;
  const auto matters = [&](const model::Bounds& bounds) {
    return layer.casters.may_matter(bounds) && !is_outside(layer.clip_from_local, bounds);
  };
  const auto block_matters = [&](uint32_t block) {
    return !held.is_block_settled(block) && matters(scene.bounds_of_block(block));
  };
  const auto is_wanted = [&](uint32_t place) {
    if (held.is_settled(place) || !layer.casters.may_matter(scene.bounds_at(place))) return false;
    if (is_outside(layer.clip_from_local, scene.bounds_at(place))) {
      held.add_outside(place);
      return false;
    }
    held.add_drawn(place);
    begin();
    return true;
  };
  for (const bool alpha : {false, true}) {
    const Program* program = nullptr;
    for (const Draw* next : order) {
      const Draw& draw = *next;
      if (scene.material(draw).discards != alpha) continue;
      if (held.are_settled(draw.first_instance, draw.instance_count) || !matters(draw.bounds)) continue;
      const Program& wanted = pass.programs.coverage({.alpha = alpha, .wind = draw.wind != 0});
      if (program != &wanted) {
        scene.draw_gathered();
        program = &wanted;
        program->use();
        program->set("clip_from_local", layer.clip_from_local);
      }
      if (alpha) scene.bind_material(draw.material, base_color_map);
      scene.set_wind(*program, draw);
      scene.gather_draws(!alpha && draw.wind == 0);
      scene.draw_places(draw, block_matters, is_wanted);
      scene.gather_draws(false);
    }
    scene.draw_gathered();
  }
}

// Adds casters to those that the layer already holds: depth tests give the same result in any order.
void RasterLights::draw_layer(const Maps& maps, LayerCasters& held, const Pass& pass, const Layer& layer,
                              std::vector<const Draw*>& order) {
  bool attached = false;
  const auto attach = [&] {
    if (attached) return;
    gl_.FramebufferTextureLayer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, maps.texture.id(), 0,
                                static_cast<GLint>(layer.index));
    attached = true;
  };
  const bool is_held = held.begin(layer.clip_from_local, pass.scene.instance_order().size());
  if (!is_held) {
    if (order.empty()) order = by_reach(casters_, layer.light);
    const float clear = limits_.reversed_depth ? 0.0f : 1.0f;
    attach();
    gl_.ClearBufferfv(GL_DEPTH, 0, &clear);
  }
  draw_casters(held, pass, layer, is_held ? casters_ : order, attach);
}

// Keeps the content of a light's maps where neither the light nor its casters moved.
void RasterLights::follow_casters(const RasterScene& scene) {
  const CasterChanges::Changes changes = changes_.take(scene);
  if (changes.all) return forget_shadow_maps();
  for (Maps* maps : {&directional_, &local_})
    for (LayerCasters& held : maps->casters)
      for (const uint32_t place : changes.places) held.change(place);
}

void RasterLights::forget_shadow_maps() {
  for (Maps* maps : {&directional_, &local_})
    for (LayerCasters& held : maps->casters) held.forget();
  tints_.forget();
}

void RasterLights::draw_shadow_maps(RasterScene& scene, RasterPrograms& programs, const glm::dmat4& clip_from_local,
                                    TintedLights tinted, const std::function<void()>& between) {
  drawn_ = true;
  allocate(directional_, plan_.directional_size, plan_.directional_layers);
  allocate(local_, plan_.local_size, plan_.local_layers);
  if (plan_.directional_layers + plan_.local_layers == 0) return;
  keeps_ = (uint64_t{plan_.directional_layers} + plan_.local_layers) * scene.instance_order().size() <= most_kept_bits;
  if (!keeps_) forget_shadow_maps();
  const model::Bounds seen = scene.seen_bounds(glm::mat4(clip_from_local));
  if (seen.empty()) return;
  const Pass pass{scene, programs, make_receivers(clip_from_local, seen), between};
  begin_pass();
  scene.forget_bindings();
  // Draws one framebuffer and one size at a time, the larger first. NVIDIA's driver (580.159) left the directional map
  // empty in the first frame where it was attached after two point lights' maps of another size.
  draw_into(directional_, ShadowMap::directional, pass);
  draw_into(local_, ShadowMap::frustum, pass);
  draw_into(local_, ShadowMap::faces, pass);
  gl_.Disable(GL_POLYGON_OFFSET_FILL);
  gl_.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  tints_.draw(scene, programs, plan_, {tinted, limits_.reversed_depth});
}

void RasterLights::draw_into(Maps& maps, ShadowMap kind, const Pass& pass) {
  if (maps.layers == 0) return;
  gl_.BindFramebuffer(GL_FRAMEBUFFER, maps.framebuffer.id());
  gl_.DrawBuffer(GL_NONE);
  gl_.ReadBuffer(GL_NONE);
  gl_.Viewport(0, 0, static_cast<GLsizei>(maps.size), static_cast<GLsizei>(maps.size));
  for (size_t i = 0; i < plan_.lights.size(); ++i) {
    const LightShadow& shadow = plan_.lights[i];
    if (shadow.map != kind) continue;
    const model::Light& light = pass.scene.snapshot().lights[i];
    const ShadowCasters casters(light, shadow, pass.receivers);
    std::vector<const Draw*> order;  // filled once a layer is drawn anew
    for (uint32_t k = 0; k < shadow.clip_from_local.size(); ++k) {
      const uint32_t layer = shadow.first_layer + k;
      LayerCasters& held = keeps_ ? maps.casters[layer] : once_;
      if (!keeps_) held.forget();
      draw_layer(maps, held, pass, {layer, light, casters, shadow.clip_from_local[k]}, order);
    }
    if (pass.between) pass.between();
  }
  // A later pass samples the map, so it must not stay attached.
  gl_.FramebufferTextureLayer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, 0, 0, 0);
}

void RasterLights::bind(const Program& program, RasterTextures& textures, bool shadows) const {
  if (are_many()) {
    textures.bind_plain(unit::many_lights, GL_TEXTURE_2D, texels_.id());
  } else {
    gl_.BindBufferBase(GL_UNIFORM_BUFFER, block::lights, lights_.id());
    gl_.BindBufferBase(GL_UNIFORM_BUFFER, block::shadows, shadows_.id());
  }
  const auto bind_maps = [&](uint32_t texture_unit, const Maps& maps) {
    textures.bind_plain(texture_unit, GL_TEXTURE_2D_ARRAY, maps.texture ? maps.texture.id() : textures.empty_shadow());
  };
  bind_maps(unit::directional_shadows, directional_);
  bind_maps(unit::local_shadows, local_);
  textures.bind_environment();
  program.set("light_count", static_cast<int>(light_count_));
  program.set("shadows_on", static_cast<int>(shadows && drawn_));
  program.set("environment_last_level", textures.environment_last_level());
}

}  // namespace sideray::gl
