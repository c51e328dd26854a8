#include "gl/scene/tint_maps.h"

#include <algorithm>

#include "gl/scene/raster_view.h"
#include "model/material.h"

namespace sideray::gl {
namespace {

constexpr uint64_t bytes_a_texel = 8, most_bytes = uint64_t{64} << 20;  // for each kind of map
constexpr float beyond_all = 65504.0f;

bool tints(const RasterScene& scene, const Draw& draw) {
  return model::tints_light(scene.material(draw), scene.snapshot().instances[draw.instance]);
}

// Returns whether front faces, as the light sees them, are clockwise: some faces of a point light's maps are mirrored.
bool is_mirrored(const glm::mat4& clip) {
  const glm::vec3 x(clip[0][0], clip[1][0], clip[2][0]), y(clip[0][1], clip[1][1], clip[2][1]),
      w(clip[0][3], clip[1][3], clip[2][3]);
  return glm::dot(glm::cross(x, y), w) > 0.0f;
}

}  // namespace

uint32_t TintMaps::side_of(uint32_t shadow_map_side, uint32_t layers) {
  uint64_t side = std::max(shadow_map_side / 2, 1u);
  while (side > 1 && side * side * layers * bytes_a_texel > most_bytes) side /= 2;
  return static_cast<uint32_t>(side);
}

void TintMaps::fit(Maps& maps, uint32_t shadow_map_side, uint32_t layers) const {
  const uint32_t size = side_of(shadow_map_side, layers);
  if (layers == 0) maps = {};
  if (layers == 0 || (maps.size == size && maps.layers == layers)) return;
  maps = {Texture(gl_), size, layers};
  gl_.ActiveTexture(GL_TEXTURE0);
  gl_.BindTexture(GL_TEXTURE_2D_ARRAY, maps.texture.id());
  gl_.TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  gl_.TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  gl_.TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAX_LEVEL, 0);
  gl_.BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
  gl_.TexImage3D(GL_TEXTURE_2D_ARRAY, 0, GL_RGBA16F, static_cast<GLsizei>(size), static_cast<GLsizei>(size),
                 static_cast<GLsizei>(layers), 0, GL_RGBA, GL_HALF_FLOAT, nullptr);
  check_allocation(gl_, "tint maps");
}

void TintMaps::draw(RasterScene& scene, RasterPrograms& programs, const ShadowPlan& plan, const Wanted& wanted) {
  if (drawn_ && wanted == wanted_) return;
  drawn_ = true;
  wanted_ = wanted;
  const bool any = wanted.lights != TintedLights::none && gl_.texture_units > static_cast<int>(unit::tint_maps) + 1 &&
                   std::ranges::any_of(scene.translucent(), [&](const Draw& draw) { return tints(scene, draw); });
  fit(directional_, plan.directional_size, any ? plan.directional_layers : 0);
  fit(local_, plan.local_size, any && wanted.lights == TintedLights::all ? plan.local_layers : 0);
  if (!exist()) return;
  if (!framebuffer_) framebuffer_ = Framebuffer(gl_);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
  gl_.DrawBuffer(GL_COLOR_ATTACHMENT0);
  gl_.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  gl_.Disable(GL_DEPTH_TEST);
  gl_.Disable(GL_POLYGON_OFFSET_FILL);
  gl_.Enable(GL_BLEND);
  gl_.BlendEquationSeparate(GL_FUNC_ADD, GL_MIN);
  gl_.BlendFunc(GL_ONE, GL_ONE);
  scene.textures().bind_environment();
  for (size_t i = 0; i < plan.lights.size(); ++i) {
    const LightShadow& shadow = plan.lights[i];
    const Maps& maps = shadow.map == ShadowMap::directional ? directional_ : local_;
    if (shadow.map == ShadowMap::none || !maps.texture) continue;
    gl_.Viewport(0, 0, static_cast<GLsizei>(maps.size), static_cast<GLsizei>(maps.size));
    for (uint32_t k = 0; k < shadow.clip_from_local.size(); ++k) {
      gl_.FramebufferTextureLayer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, maps.texture.id(), 0,
                                  static_cast<GLint>(shadow.first_layer + k));
      const float nothing[4] = {0.0f, 0.0f, 0.0f, beyond_all};
      gl_.ClearBufferfv(GL_COLOR, 0, nothing);
      draw_layer(scene, programs, scene.snapshot().lights[i], shadow.clip_from_local[k]);
    }
  }
  gl_.FramebufferTextureLayer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, 0, 0, 0);
  gl_.BlendEquation(GL_FUNC_ADD);
  gl_.BlendFunc(GL_ONE, GL_ZERO);
  gl_.Disable(GL_BLEND);
  gl_.FrontFace(GL_CCW);
}

void TintMaps::draw_layer(RasterScene& scene, RasterPrograms& programs, const model::Light& light,
                          const glm::mat4& clip_from_local) const {
  const bool is_directional = light.type == SIDERAY_LIGHT_DIRECTIONAL, mirrored = is_mirrored(clip_from_local);
  const glm::vec4 light_place(is_directional ? -light.direction : light.position, is_directional ? 0.0f : 1.0f);
  const Program* current = nullptr;
  for (const Draw& draw : scene.translucent()) {
    if (!tints(scene, draw) || is_outside(clip_from_local, draw.bounds)) continue;
    Shading shading = scene.shading(draw);
    shading.wind = false;
    const Program& program = programs.tint_map(shading);
    if (&program != current) {
      program.use();
      program.set("clip_from_local", clip_from_local);
      program.set("light_place", light_place);
      program.set("light_radius", is_directional ? 0.0f : light.radius);
      program.set("reversed_depth", static_cast<int>(wanted_.reversed_depth));
      current = &program;
    }
    const glm::vec3 middle = draw.bounds.center();
    program.set("middle_away", is_directional ? glm::dot(middle, light.direction) : glm::length(middle - light.position));
    scene.bind_material(draw.material, shading.maps);
    gl_.FrontFace(draw.mirrored != mirrored ? GL_CW : GL_CCW);
    scene.draw(draw);
  }
}

void TintMaps::bind(const Program& program, RasterTextures& textures) const {
  textures.bind_plain(unit::tint_maps, GL_TEXTURE_2D_ARRAY, directional_.texture.id());
  textures.bind_plain(unit::tint_maps + 1, GL_TEXTURE_2D_ARRAY, local_.texture.id());
  program.set("tint_maps_of", glm::ivec2(directional_.texture ? 1 : 0, local_.texture ? 1 : 0));
  program.set("tints_reversed", static_cast<int>(wanted_.reversed_depth));
}

}  // namespace sideray::gl
