#include "glass_scene.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "shapes.h"

namespace {

std::string name_of(const mjModel& model, int type, int id) {
  const char* name = id >= 0 ? mj_id2name(&model, type, id) : nullptr;
  return name ? name : "";
}

// Columns are the geom's axes, scaled if its mesh has unit size, and its position.
void set_transform(const mjvGeom& geom, sideray_instance_desc& desc) {
  const bool sized = geom.type == mjGEOM_MESH || geom.type == mjGEOM_CAPSULE;
  for (int column = 0; column < 3; ++column) {
    const bool flat = geom.type == mjGEOM_PLANE && column == 2;
    const float scale = sized || flat ? 1.0f : std::max(geom.size[column], 1e-6f);
    for (int row = 0; row < 3; ++row)
      desc.world_from_object[3 * column + row] = static_cast<double>(geom.mat[3 * row + column] * scale);
  }
  for (int row = 0; row < 3; ++row) desc.world_from_object[9 + row] = static_cast<double>(geom.pos[row]);
}

// Returns the mean colour of a cube texture, because rays do not look up its faces.
std::array<float, 3> mean_color(const mjModel& model, int texture) {
  const size_t texels = static_cast<size_t>(model.tex_width[texture]) * static_cast<size_t>(model.tex_height[texture]);
  std::array<double, 3> sum{};
  for (size_t i = 0; i < 3 * texels; ++i) sum[i % 3] += model.tex_rgb[static_cast<size_t>(model.tex_adr[texture]) + i];
  const auto mean = [&](double s) { return static_cast<float>(s / (255.0 * static_cast<double>(texels))); };
  return {mean(sum[0]), mean(sum[1]), mean(sum[2])};
}

}  // namespace

bool is_glass(const mjModel& model, const mjvGeom& geom, const std::string& also) {
  if (geom.objtype != mjOBJ_GEOM || geom.objid < 0) return false;
  const int material = model.geom_matid[geom.objid];
  if (name_of(model, mjOBJ_MATERIAL, material).rfind("glass", 0) == 0) return true;
  return !also.empty() && (name_of(model, mjOBJ_GEOM, geom.objid) == also ||
                           name_of(model, mjOBJ_BODY, model.geom_bodyid[geom.objid]) == also);
}

GlassScene::GlassScene(const mjModel& model, std::string also_glass)
    : model_(model), also_glass_(std::move(also_glass)) {
  set_sky();
}

// Sets the sky as the environment; mjr_render looks it up by (x, z, -y) of the world.
void GlassScene::set_sky() {
  const auto sky = std::find(model_.tex_type, model_.tex_type + model_.ntex, int{mjTEXTURE_SKYBOX});
  if (sky == model_.tex_type + model_.ntex) return;
  const auto texture = sky - model_.tex_type;
  const auto side = static_cast<uint32_t>(model_.tex_width[texture]);
  const size_t face = size_t{3} * side * side;
  const bool one_for_all = model_.tex_height[texture] == model_.tex_width[texture];
  // The environment is linear light, MuJoCo's texels are display values; rays convert back for the host's shader.
  std::vector<float> texels(one_for_all ? face : 6 * face);
  for (size_t i = 0; i < texels.size(); ++i)
    texels[i] = std::pow(static_cast<float>(model_.tex_rgb[static_cast<size_t>(model_.tex_adr[texture]) + i]) / 255.0f, 2.2f);
  std::array<const float*, 6> faces{};
  for (size_t i = 0; i < 6; ++i) faces[i] = texels.data() + (one_for_all ? 0 : i * face);
  const float cube_from_world[9] = {1, 0, 0, 0, 0, -1, 0, 1, 0};
  scene_.set_environment_cube(side, faces, 1.0f, cube_from_world);
}

sideray_mesh GlassScene::mesh_of(const mjvGeom& geom) {
  const bool capsule = geom.type == mjGEOM_CAPSULE;
  const MeshKey key{static_cast<float>(geom.type), static_cast<float>(geom.dataid), capsule ? geom.size[0] : 0.0f,
                    capsule ? geom.size[2] : 0.0f};
  if (const auto known = meshes_.find(key); known != meshes_.end()) return known->second;
  const Shape shape = shape_of(model_, geom);
  sideray_mesh_desc desc = sideray_mesh_defaults();
  desc.vertex_count = static_cast<uint32_t>(shape.positions.size() / 3);
  desc.positions.data = shape.positions.data();
  desc.normals.data = shape.normals.data();
  if (!shape.uv.empty()) desc.uv0.data = shape.uv.data();
  return meshes_[key] = scene_.add_mesh(desc);
}

sideray_texture GlassScene::texture_of(int texture) {
  if (const auto known = textures_.find(texture); known != textures_.end()) return known->second;
  const auto width = static_cast<uint32_t>(model_.tex_width[texture]), height = static_cast<uint32_t>(model_.tex_height[texture]);
  std::vector<uint8_t> texels(size_t{4} * width * height, 255);
  const mjtByte* rgb = model_.tex_rgb + model_.tex_adr[texture];
  for (size_t i = 0; i < size_t{width} * height; ++i) std::copy_n(rgb + 3 * i, 3, &texels[4 * i]);
  return textures_[texture] = scene_.add_texture(width, height, SIDERAY_RGBA8, texels.data());
}

// Returns the look that mjr_render gives: colours are both ambient and diffuse, the exponent is 128 times the
// shininess.
sideray_fixed_material GlassScene::look_of(const mjvGeom& geom, bool glass) const {
  sideray_fixed_material look = sideray_fixed_material_defaults();
  std::array<float, 3> mean{1, 1, 1};
  if (geom.texid >= 0 && model_.tex_type[geom.texid] != mjTEXTURE_2D) mean = mean_color(model_, geom.texid);
  for (int c = 0; c < 3; ++c) {
    look.ambient[c] = look.diffuse[c] = glass ? 0.0f : geom.rgba[c] * mean[static_cast<size_t>(c)];
    look.emission[c] = glass ? 0.0f : geom.emission * geom.rgba[c];
    look.specular[c] = geom.specular;
  }
  look.shininess = 128.0f * geom.shininess;
  return look;
}

// Repeats a plane's texture `texrepeat` times across it. Glass reflects by its index of refraction.
sideray_material GlassScene::material_of(const mjvGeom& geom, bool glass) {
  const bool flat = geom.texid >= 0 && model_.tex_type[geom.texid] == mjTEXTURE_2D && geom.type == mjGEOM_PLANE;
  const MaterialKey key{static_cast<float>(geom.texid), geom.texrepeat[0], geom.texrepeat[1], geom.rgba[0],
                        geom.rgba[1],                   geom.rgba[2],      geom.emission,     geom.specular,
                        geom.shininess,                 glass ? 1.0f : 0,  flat ? 1.0f : 0};
  if (const auto known = materials_.find(key); known != materials_.end()) return known->second;
  sideray_material_desc desc = sideray_material_defaults();
  desc.double_sided = 1;
  if (glass) {
    desc.transmission = 1.0f;
    desc.thickness = 1.0f;
    desc.roughness = 0.0f;
    for (int c = 0; c < 3; ++c) desc.base_color[c] = geom.rgba[c];
  } else if (flat) {
    desc.base_color_texture.texture = texture_of(geom.texid);
    desc.base_color_texture.texture_from_uv[0] = geom.texrepeat[0];
    desc.base_color_texture.texture_from_uv[3] = geom.texrepeat[1];
  }
  const sideray_material material = scene_.add_material(desc);
  scene_.set_fixed_material(material, look_of(geom, glass));
  return materials_[key] = material;
}

sideray_instance_desc GlassScene::instance_of(const mjvGeom& geom, size_t index) {
  const bool glass = is_glass(model_, geom, also_glass_);
  sideray_instance_desc desc{};
  desc.mesh = mesh_of(geom);
  desc.material = material_of(geom, glass);
  desc.surface_id = static_cast<uint32_t>(index) + 1;
  desc.visibility = SIDERAY_VISIBLE_ALL;
  set_transform(geom, desc);
  return desc;
}

// The headlight is at the camera.
void GlassScene::update_lights(const mjvScene& drawn) {
  std::vector<sideray_fixed_light> lights;
  std::vector<sideray_light> casters;
  for (int i = 0; i < drawn.nlight; ++i) {
    const mjvLight& from = drawn.lights[i];
    sideray_fixed_light& light = lights.emplace_back(sideray_fixed_light_defaults());
    for (int c = 0; c < 3; ++c) {
      light.ambient[c] = from.ambient[c], light.diffuse[c] = from.diffuse[c], light.specular[c] = from.specular[c];
      light.position[c] = static_cast<double>(from.directional ? -from.dir[c] : from.pos[c]);
      light.spot_direction[c] = from.dir[c];
    }
    light.position[3] = from.directional ? 0.0 : 1.0;
    // A light that is off may have no direction.
    if (from.directional && light.position[0] == 0 && light.position[1] == 0 && light.position[2] == 0) light.position[2] = 1;
    if (from.directional) {
      light.constant_attenuation = 1;
    } else {
      light.spot_cutoff_deg = from.cutoff, light.spot_exponent = from.exponent;
      light.constant_attenuation = from.attenuation[0];
      light.linear_attenuation = from.attenuation[1], light.quadratic_attenuation = from.attenuation[2];
    }
    light.casts_shadows = from.castshadow && casters.size() < 32;
    if (!light.casts_shadows) continue;
    sideray_light& caster = casters.emplace_back(sideray_light_defaults());
    caster.type = from.directional ? SIDERAY_LIGHT_DIRECTIONAL : SIDERAY_LIGHT_POINT;
    for (int c = 0; c < 3; ++c)
      caster.position[c] = static_cast<double>(from.pos[c]), caster.direction[c] = from.dir[c];
  }
  scene_.set_lights(casters);
  sideray_fixed_function model = sideray_fixed_function_defaults();
  model.lights = lights.data(), model.light_count = lights.size();
  model.local_viewer = 1;
  for (float& c : model.ambient) c = 0;
  scene_.set_fixed_function(model);
}

void GlassScene::update(const mjvScene& drawn) {
  update_lights(drawn);
  std::vector<sideray_instance_desc> descs;
  for (int i = 0; i < drawn.ngeom; ++i)
    if (has_shape(drawn.geoms[i])) descs.push_back(instance_of(drawn.geoms[i], static_cast<size_t>(i)));
  const size_t kept = std::min(descs.size(), instances_.size());
  scene_.replace_instances(std::span(instances_).first(kept), std::span(descs).first(kept));
  scene_.remove_instances(std::span(instances_).subspan(kept));
  instances_.resize(kept);
  const std::vector<sideray_instance> added = scene_.add_instances(std::span(descs).subspan(kept));
  instances_.insert(instances_.end(), added.begin(), added.end());
  scene_.commit();
}
