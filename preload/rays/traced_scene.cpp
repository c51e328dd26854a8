#include "preload/rays/traced_scene.h"

#include <algorithm>
#include <cmath>

#include "preload/base/hash.h"
#include "preload/rays/texture_coordinates.h"

namespace sideray::run {
namespace {

constexpr uint64_t frames_a_cleaning = 8;
constexpr uint64_t frames_kept = 120;  // for materials and textures: longer than for meshes, which refer to none
constexpr float sky_scale = 1000;

bool is_affine_and_invertible(const Matrix& m) {
  if (m[3] != 0 || m[7] != 0 || m[11] != 0 || m[15] != 1) return false;
  const auto d = [&](size_t i) { return static_cast<double>(m[i]); };
  const double determinant = d(0) * (d(5) * d(10) - d(6) * d(9)) - d(4) * (d(1) * d(10) - d(2) * d(9)) + d(8) * (d(1) * d(6) - d(2) * d(5));
  return std::isfinite(determinant) && std::abs(determinant) > 1e-12;
}

void normalize_normals(std::vector<Vertex>& vertices) {
  for (Vertex& vertex : vertices) {
    float* n = vertex.normal;
    const float length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    if (length > 0)
      for (int c = 0; c < 3; ++c) n[c] /= length;
    else
      n[0] = n[1] = 0, n[2] = 1;
  }
}

sideray_wrap wrap_of(GLint mode) {
  return mode == GL_REPEAT ? SIDERAY_REPEAT : mode == GL_MIRRORED_REPEAT ? SIDERAY_MIRROR : SIDERAY_CLAMP;
}

sideray_attribute attribute(const float* data) {
  return {data, sizeof(Vertex)};
}

}  // namespace

TracedScene::TracedScene() : scene_(Scene::create().value()), tracer_(Tracer::create(scene_).value()) {}

void TracedScene::begin_frame() {
  ++frame_;
  wanted_.clear();
  looks_.clear();
  names_.begin_frame();
  bent_names_.begin_frame();
  sheets_ = 0;
  drop_old();
}

void TracedScene::drop_old() {
  if (frame_ % frames_a_cleaning != 0) return;
  // Instances of the last commit hold their meshes until the next one replaces them.
  if (!held_.empty()) {
    scene_.remove_instances(held_);
    held_.clear();
  }
  for (auto at = meshes_.begin(); at != meshes_.end();) {
    const bool old = at->second.is_old(frame_);
    if (old && at->second.name != 0) scene_.remove_mesh(at->second.name);
    at = old ? meshes_.erase(at) : std::next(at);
  }
  const auto drop = [this](auto& kept, auto&& remove) {
    for (auto at = kept.begin(); at != kept.end();) {
      const bool old = frame_ - at->second.last_frame > frames_kept;
      if (old) remove(at->second.name);
      at = old ? kept.erase(at) : std::next(at);
    }
  };
  drop(materials_, [this](sideray_material name) { scene_.remove_material(name); });
  drop(textures_, [this](sideray_texture name) { scene_.remove_texture(name); });
}

sideray_mesh TracedScene::mesh(const SceneDraw& draw, bool colored) {
  const DrawState& state = *draw.state;
  const bool lit = state.lighting;
  colored = colored && state.shows_colors() && !state.shows_texture_alone();
  const int units[2] = {state.unit_of_layer(0), state.unit_of_layer(1)};
  uint64_t key = mix(draw.hash, (lit ? 1u : 0u) + (colored ? 2u : 0u) + 4u * static_cast<unsigned>(units[0] + 1) + 64u * static_cast<unsigned>(units[1] + 1));
  for (const int unit : units) key = mix(key, hash_of_coordinates(state, unit));
  const auto [at, is_new] = meshes_.try_emplace(key);
  at->second.last_frame = frame_;
  if (is_new) at->second.first_frame = frame_;
  if (!is_new) return at->second.name;
  std::vector<Vertex> vertices = draw.geometry->vertices;
  for (const int unit : units) make_coordinates(state, unit, vertices);
  if (lit) normalize_normals(vertices);
  const std::vector<uint32_t> triangles = triangles_of(*draw.geometry);
  sideray_mesh_desc desc = sideray_mesh_defaults();
  desc.vertex_count = static_cast<uint32_t>(vertices.size());
  desc.index_count = static_cast<uint32_t>(triangles.size());
  desc.indices = triangles.data();
  desc.positions = attribute(vertices[0].position);
  if (lit) desc.normals = attribute(vertices[0].normal);
  if (colored) desc.colors = attribute(vertices[0].color);
  desc.uv0 = attribute(vertices[0].uv[std::max(units[0], 0)]);
  desc.uv1 = attribute(vertices[0].uv[std::max(units[1], 0)]);
  uint32_t dropped = 0;
  const sideray_mesh name = scene_.add_mesh(desc, &dropped);
  if (3 * static_cast<size_t>(dropped) >= triangles.size()) {
    scene_.remove_mesh(name);
    return 0;
  }
  at->second.name = name;
  return name;
}

sideray_texture TracedScene::texture(const Texture& texture) {
  const auto [at, is_new] = textures_.try_emplace(texture.hash);
  if (is_new)
    at->second.name = scene_.add_texture(static_cast<uint32_t>(texture.width), static_cast<uint32_t>(texture.height), SIDERAY_RGBA8, texture.texels.data());
  at->second.last_frame = frame_;
  return at->second.name;
}

sideray_texture_slot TracedScene::slot(const Texture& from) {
  sideray_texture_slot slot = sideray_material_defaults().base_color_texture;
  slot.texture = texture(from);
  slot.wrap_u = wrap_of(from.wrap[0]), slot.wrap_v = wrap_of(from.wrap[1]);
  if (from.magnified == GL_NEAREST) slot.filter = SIDERAY_NEAREST;
  return slot;
}

sideray_material TracedScene::opaque_material(const SceneDraw& draw) {
  // Rays hit blended surfaces (clouds, hills before a sky) where their alpha is more than a half.
  const DrawState& state = *draw.state;
  const float cutoff = state.blend ? 0.5f : state.alpha_test ? state.alpha_reference : 0;
  return material({{draw.textures[0]->hash, draw.textures[1]->hash}, Role::opaque, cutoff}, draw);
}

sideray_material TracedScene::material(const MaterialKey& key, const SceneDraw& draw) {
  const auto [at, is_new] = materials_.try_emplace(key);
  at->second.last_frame = frame_;
  for (size_t i = 0; i < 2; ++i)
    if (key.textures[i] != 0) texture(*draw.textures[i]);
  if (is_new) at->second.name = scene_.add_material(describe(key, draw));
  return at->second.name;
}

sideray_material_desc TracedScene::describe(const MaterialKey& key, const SceneDraw& draw) {
  sideray_material_desc desc = sideray_material_defaults();
  desc.double_sided = 1;
  switch (key.role) {
    case Role::opaque:
      desc.alpha_mode = key.value > 0 ? SIDERAY_MASK : SIDERAY_OPAQUE;
      desc.alpha_cutoff = key.value;
      break;
    case Role::caster:
      desc.alpha_mode = SIDERAY_BLEND;
      desc.base_color[3] = key.value;
      break;
    case Role::mirror:
      desc.alpha_mode = SIDERAY_BLEND;
      desc.base_color[3] = 0.5f;
      break;
    case Role::clear_mirror:
    case Role::bent:  // what it mirrors is another surface's
      desc.transmission = 1;
      desc.specular = 0;
      desc.roughness = 0;
      desc.thickness = key.role == Role::bent ? 1.0f : 0.0f;
      desc.ior = key.role == Role::bent ? key.value : 1.5f;
      break;
  }
  // The layers of glass hold only its reflection, so holes of its texture show the program's own picture.
  if (key.textures[0] != 0) desc.base_color_texture = slot(*draw.textures[0]);
  if (key.textures[1] != 0) {
    desc.emissive_texture = slot(*draw.textures[1]);  // a light map: Looks multiplies by it
    desc.emissive_texture.uv_set = 1;
    std::fill_n(desc.emissive, 3, 1.0f);
  }
  return desc;
}

bool TracedScene::place(const SceneDraw& draw, float scale, bool colored, sideray_instance_desc& instance) {
  if (!draw.geometry->is_surface() || !is_affine_and_invertible(draw.state->modelview)) return false;
  instance.mesh = mesh(draw, colored);
  if (instance.mesh == 0) return false;
  for (size_t column = 0; column < 4; ++column)
    for (size_t row = 0; row < 3; ++row)
      instance.world_from_object[3 * column + row] = static_cast<double>(scale) * static_cast<double>(draw.state->modelview[4 * column + row]);
  return true;
}

void TracedScene::add_opaque(const SceneDraw& draw) {
  sideray_instance_desc instance{};
  if (!place(draw, 1, true, instance)) return;
  instance.material = opaque_material(draw);
  instance.user = looks_.add(*draw.state, draw.tint);
  instance.visibility = SIDERAY_VISIBLE_REFLECTION;
  if (has_sun_) instance.visibility |= SIDERAY_VISIBLE_SHADOW;
  wanted_.push_back(instance);
}

void TracedScene::add_sky(const SceneDraw& draw) {
  sideray_instance_desc instance{};
  if (!place(draw, sky_scale * std::pow(0.9f, static_cast<float>(sheets_)), true, instance)) return;
  ++sheets_;
  instance.material = opaque_material(draw);
  instance.user = looks_.add(*draw.state, draw.tint);
  instance.visibility = SIDERAY_VISIBLE_REFLECTION;
  wanted_.push_back(instance);
}

// Adds a refracting surface as two: the reflecting one lies slightly in front, so that the program's own draw of it
// goes between the two.
MirrorIds TracedScene::add_mirror(const SceneDraw& draw, const Rule& rule) {
  constexpr float behind = 1.0001f;
  sideray_instance_desc instance{};
  const bool bends = rule.ior > 1;
  if (!place(draw, 1, !bends, instance)) return {};
  const uint64_t mesh_hash = hash_of(*draw.geometry, {false, false, 0}), texture_hash = draw.textures[0]->hash;
  MirrorIds ids;
  instance.material = material({{0, 0}, bends ? Role::clear_mirror : Role::mirror, 0}, draw);
  instance.user = looks_.add_mirror(*draw.state, draw.tint, rule.reflectance);
  instance.visibility = SIDERAY_VISIBLE_LAYERS;
  instance.surface_id = ids.mirror = 2 * names_.name(mesh_hash, texture_hash) - 1;
  wanted_.push_back(instance);
  if (has_sun_) add_caster(draw);
  if (!bends || !place(draw, behind, false, instance)) return ids;
  instance.material = material({{0, 0}, Role::bent, rule.ior}, draw);
  instance.user = looks_.add_clear();
  instance.surface_id = ids.bent = 2 * bent_names_.name(mesh_hash, texture_hash);
  wanted_.push_back(instance);
  return ids;
}

void TracedScene::add_caster(const SceneDraw& draw) {
  sideray_instance_desc caster{};
  if (!place(draw, 1, true, caster)) return;
  // The mesh has the vertices' alpha.
  const float alpha = draw.state->blend && !draw.state->shows_colors() ? draw.state->alpha : 1.0f;
  caster.material = material({{draw.textures[0]->hash, 0}, Role::caster, alpha}, draw);
  caster.visibility = SIDERAY_VISIBLE_SHADOW;
  wanted_.push_back(caster);
}

void TracedScene::set_sun(const FixedLight* sun) {
  if (!sun || (has_sun_ && std::equal(sun->position, sun->position + 4, sun_.position))) return;
  has_sun_ = true;
  sun_ = *sun;
  sideray_light light = sideray_light_defaults();
  const float w = sun_.position[3];
  light.type = w == 0 ? SIDERAY_LIGHT_DIRECTIONAL : SIDERAY_LIGHT_POINT;
  for (int c = 0; c < 3; ++c) {
    light.direction[c] = -sun_.position[c];
    light.position[c] = w == 0 ? 0 : static_cast<double>(sun_.position[c]) / static_cast<double>(w);
  }
  scene_.set_lights({&light, 1});
}

void TracedScene::set_background(const std::array<float, 3>& color) {
  if (color == background_) return;
  background_ = color;
  std::array<float, 12> linear;  // 2x2 pixels, the smallest environment
  for (size_t i = 0; i < linear.size(); ++i) linear[i] = std::pow(std::clamp(color[i % 3], 0.0f, 1.0f), 2.2f);
  scene_.set_environment(2, 2, linear.data(), 1, 0);
}

void TracedScene::commit() {
  const size_t common = std::min(held_.size(), wanted_.size());
  const std::span wanted(wanted_);
  // Removes surplus instances first, because their surface ids may be used again.
  if (held_.size() > common) scene_.remove_instances(std::span(held_).subspan(common));
  held_.resize(common);
  if (common > 0) scene_.replace_instances(held_, wanted.first(common));
  if (wanted.size() > common) {
    const std::vector<sideray_instance> added = scene_.add_instances(wanted.subspan(common));
    held_.insert(held_.end(), added.begin(), added.end());
  }
  set_looks();
  scene_.commit();
}

// Copies the looks, because frames in flight still read the looks with which they were submitted.
void TracedScene::set_looks() {
  sideray_shader_desc shader = sideray_shader_defaults();
  shader.shade = Looks::shade;
  shader.user = new Looks(looks_);
  shader.release = [](void* looks) { delete static_cast<Looks*>(looks); };
  shader.radiance_space = SIDERAY_SPACE_GAMMA22;  // the fixed function adds display values
  scene_.set_shader(shader);
}

}  // namespace sideray::run
