#include "gl/scene/raster_scene.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <set>
#include <tuple>
#include <type_traits>

#include "elementary/functions.h"
#include "gl/scene/raster_view.h"
#include "model/material.h"
#include "model/material_slots.h"
#include "model/mesh.h"
#include "model/wind.h"

namespace sideray::gl {

uint32_t lobes_of(const sideray_material_desc& d) {
  if (d.unlit) return 0;
  return (d.clearcoat > 0.0f ? lobe::coat : 0) |
         (d.sheen_color[0] > 0.0f || d.sheen_color[1] > 0.0f || d.sheen_color[2] > 0.0f ? lobe::sheen : 0) |
         (d.diffuse_transmission > 0.0f ? lobe::behind : 0) | (d.iridescence > 0.0f ? lobe::film : 0) |
         (d.anisotropy > 0.0f ? lobe::anisotropy : 0);
}

namespace {

// Holds a vertex without its position, which is apart because passes without shading read it alone.
struct VertexAttributes {
  glm::vec3 normal;
  glm::vec4 tangent;
  glm::vec2 uv0, uv1;
  glm::vec4 color;
};

struct InstanceRecord {
  glm::vec3 local_from_object[4];
  glm::vec3 normal_from_object[3];
  uint32_t surface_id, traits;
  float wind_phase;
};

// These are bits of in_id_traits.y in shaders/surface/raster_surface.vert.glsl.
namespace trait {
constexpr uint32_t mirrored = 1, solid = 2;
}

using model::material_slot_count, model::material_slots;

// Has the layout std140 of the block `Material` in shaders/surface/raster_material.glsl.
struct MaterialRecord {
  glm::vec4 base_color;
  glm::vec4 emissive_metallic;
  glm::vec4 specular_color_roughness;
  glm::vec4 absorption_transmission;
  glm::vec4 ior_thickness_specular_normal_scale;
  glm::vec4 occlusion_alpha_cutoff_spread;
  glm::vec4 coat_roughness_normal_scale;
  glm::vec4 sheen_color_roughness;
  glm::vec4 diffuse_transmission_color_share;
  glm::vec4 film_ior_thickness;
  glm::vec4 anisotropy_cosine_sine;
  glm::ivec4 unlit_blend_alpha_mode_maps;
  glm::vec4 texture_from_uv[2 * material_slot_count];
};
static_assert(sizeof(MaterialRecord) == 16 * (12 + 2 * material_slot_count));

// Returns the textures of a material's active lobes.
uint32_t maps_of(const sideray_material_desc& d) {
  uint32_t maps = 0;
  for (size_t i = 0; i < material_slot_count; ++i)
    if ((d.*material_slots[i].slot).texture != 0) maps |= 1u << i;
  const uint32_t lobes = lobes_of(d);
  if (!(lobes & lobe::coat)) maps &= ~coat_maps;
  if (!(lobes & lobe::sheen)) maps &= ~sheen_maps;
  if (!(lobes & lobe::behind)) maps &= ~behind_maps;
  if (!(lobes & lobe::film)) maps &= ~film_maps;
  if (!(lobes & lobe::anisotropy)) maps &= ~anisotropy_maps;
  return maps;
}

MaterialRecord record_of(const sideray_material_desc& d, uint32_t maps) {
  MaterialRecord r{};
  r.base_color = {d.base_color[0], d.base_color[1], d.base_color[2], d.base_color[3]};
  r.emissive_metallic = {d.emissive[0], d.emissive[1], d.emissive[2], d.metallic};
  r.specular_color_roughness = {d.specular_color[0], d.specular_color[1], d.specular_color[2], d.roughness};
  r.absorption_transmission = glm::vec4(model::absorption(d), d.transmission);
  r.ior_thickness_specular_normal_scale = {d.ior, d.thickness, d.specular, d.normal_scale};
  r.occlusion_alpha_cutoff_spread = {d.occlusion_strength, d.alpha_cutoff, model::index_spread(d), 0};
  r.unlit_blend_alpha_mode_maps = {d.unlit, d.blend_mode, d.alpha_mode, static_cast<int>(maps)};
  r.coat_roughness_normal_scale = {d.clearcoat, d.clearcoat_roughness, d.clearcoat_normal_scale, 0};
  r.sheen_color_roughness = {d.sheen_color[0], d.sheen_color[1], d.sheen_color[2], d.sheen_roughness};
  const float* behind = d.diffuse_transmission_color;
  r.diffuse_transmission_color_share = {behind[0], behind[1], behind[2], d.diffuse_transmission};
  r.film_ior_thickness = {d.iridescence, d.iridescence_ior, d.iridescence_thickness_min, d.iridescence_thickness_max};
  r.anisotropy_cosine_sine = {d.anisotropy, elementary::cos(d.anisotropy_rotation), elementary::sin(d.anisotropy_rotation), 0};
  for (size_t i = 0; i < material_slot_count; ++i) {
    const sideray_texture_slot& slot = d.*material_slots[i].slot;
    const float* m = slot.texture_from_uv;
    r.texture_from_uv[2 * i] = {m[0], m[2], m[4], static_cast<float>(slot.uv_set)};
    r.texture_from_uv[2 * i + 1] = {m[1], m[3], m[5], 0};
  }
  return r;
}

InstanceRecord record_of(const model::Instance& instance) {
  InstanceRecord r{};
  for (int c = 0; c < 4; ++c) r.local_from_object[c] = instance.local_from_object[c];
  for (int c = 0; c < 3; ++c) r.normal_from_object[c] = instance.normal_from_object[c];
  r.surface_id = instance.surface_id;
  r.traits = (instance.mirrored ? trait::mirrored : 0) | (instance.solid ? trait::solid : 0);
  r.wind_phase = instance.wind_phase;
  return r;
}

template <typename T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
  static_assert(std::is_trivially_copyable_v<T>);
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

// Returns whether all uploaded data is the same, as where only time advances. Padding bytes may differ too, which only
// causes a redundant upload.
bool same_surfaces(const model::Snapshot& a, const model::Snapshot& b) {
  return a.meshes == b.meshes && a.textures == b.textures && same_bytes(a.materials, b.materials) &&
         same_bytes(a.instances, b.instances) && same_bytes(a.thin, b.thin);
}

void add_bounds(model::Bounds& sum, const model::Bounds& bounds) {
  sum.add(bounds.minimum);
  sum.add(bounds.maximum);
}

void fill_buffer(const Functions& gl, uint32_t target, const Buffer& buffer, const void* bytes, size_t size) {
  gl.BindBuffer(target, buffer.id());
  gl.BufferData(target, static_cast<GLsizeiptr>(size), bytes, GL_STATIC_DRAW);
}

void refill_buffer(const Functions& gl, const Buffer& buffer, const void* bytes, size_t size) {
  gl.BindBuffer(GL_ARRAY_BUFFER, buffer.id());
  gl.BufferSubData(GL_ARRAY_BUFFER, 0, static_cast<GLsizeiptr>(size), bytes);
}

std::vector<VertexAttributes> attributes_of(const model::Mesh& mesh) {
  std::vector<VertexAttributes> vertices(mesh.positions.size());
  for (size_t i = 0; i < vertices.size(); ++i)
    vertices[i] = {mesh.normals[i], mesh.tangents[i], mesh.uv0[i], mesh.uv1[i], mesh.colors[i]};
  return vertices;
}

// Holds how a mesh is drawn.
struct Primitives {
  GLenum mode;
  uint32_t corners;  // corners of one primitive
};
Primitives primitives_of(const model::Mesh& mesh) {
  if (mesh.topology == SIDERAY_LINES) return {GL_LINES, 2};
  if (mesh.topology == SIDERAY_POINTS) return {GL_POINTS, 1};
  return {GL_TRIANGLES, 3};
}

// Returns the indices of lines and points; none for triangles, whose own indices are uploaded.
std::vector<uint32_t> thin_indices(const model::Mesh& mesh) {
  std::vector<uint32_t> indices;
  const uint32_t corners = primitives_of(mesh).corners;
  if (corners == 3) return indices;
  indices.reserve(corners * mesh.triangles.size());
  for (const glm::uvec3& t : mesh.triangles)
    for (uint32_t k = 0; k < corners; ++k) indices.push_back(t[static_cast<int>(k)]);
  return indices;
}

const void* offset_pointer(size_t bytes) {
  return reinterpret_cast<const void*>(bytes);
}

constexpr uint32_t location_before = 15;  // vertex attribute: the position in the frame before

void enable_floats(const Functions& gl, uint32_t location, int components, size_t stride, size_t offset) {
  gl.EnableVertexAttribArray(location);
  gl.VertexAttribPointer(location, components, GL_FLOAT, GL_FALSE, static_cast<GLsizei>(stride),
                         offset_pointer(offset));
}

}  // namespace

RasterScene::RasterScene(const Functions& gl)
    : gl_(gl), textures_(gl), materials_(gl), instances_(gl), positions_before_(gl), gathered_(gl) {
  GLint alignment = 1;
  gl.GetIntegerv(GL_UNIFORM_BUFFER_OFFSET_ALIGNMENT, &alignment);
  const auto step = static_cast<uint32_t>(std::max(alignment, 1));
  material_stride_bytes_ = (static_cast<uint32_t>(sizeof(MaterialRecord)) + step - 1) / step * step;
}

RasterScene::MeshBuffers RasterScene::upload(const std::shared_ptr<const model::Mesh>& mesh) const {
  MeshBuffers b{mesh, Buffer(gl_), Buffer(gl_), Buffer(gl_), VertexArray(gl_)};
  const std::vector<VertexAttributes> vertices = attributes_of(*mesh);
  gl_.BindVertexArray(b.vertex_array.id());
  fill_buffer(gl_, GL_ARRAY_BUFFER, b.positions, mesh->positions.data(), mesh->positions.size() * sizeof(glm::vec3));
  enable_floats(gl_, 0, 3, sizeof(glm::vec3), 0);
  fill_buffer(gl_, GL_ARRAY_BUFFER, b.attributes, vertices.data(), vertices.size() * sizeof(VertexAttributes));
  constexpr size_t stride = sizeof(VertexAttributes);
  enable_floats(gl_, 1, 3, stride, offsetof(VertexAttributes, normal));
  enable_floats(gl_, 2, 4, stride, offsetof(VertexAttributes, tangent));
  enable_floats(gl_, 3, 2, stride, offsetof(VertexAttributes, uv0));
  enable_floats(gl_, 4, 2, stride, offsetof(VertexAttributes, uv1));
  enable_floats(gl_, 5, 4, stride, offsetof(VertexAttributes, color));
  const std::vector<uint32_t> thin = thin_indices(*mesh);
  if (thin.empty())
    fill_buffer(gl_, GL_ELEMENT_ARRAY_BUFFER, b.indices, mesh->triangles.data(),
                mesh->triangles.size() * sizeof(glm::uvec3));
  else
    fill_buffer(gl_, GL_ELEMENT_ARRAY_BUFFER, b.indices, thin.data(), thin.size() * sizeof(uint32_t));
  return b;
}

RasterScene::MeshBuffers RasterScene::with_vertices(MeshBuffers buffers,
                                                    const std::shared_ptr<const model::Mesh>& mesh) const {
  const std::vector<VertexAttributes> vertices = attributes_of(*mesh);
  refill_buffer(gl_, buffers.positions, mesh->positions.data(), mesh->positions.size() * sizeof(glm::vec3));
  refill_buffer(gl_, buffers.attributes, vertices.data(), vertices.size() * sizeof(VertexAttributes));
  buffers.source = mesh;
  return buffers;
}

void RasterScene::set_meshes() {
  std::set<const model::Mesh*> present;
  for (const std::shared_ptr<const model::Mesh>& mesh : snapshot_->meshes) present.insert(mesh.get());
  // Returns the buffers that a mesh of this name had in the last snapshot, if no other mesh has them and the triangles
  // are the same.
  const auto moved = [&](size_t i) -> MeshBuffers* {
    const uint32_t before = model::find_name(mesh_names_, mesh_at_.size(), snapshot_->mesh_names[i]);
    MeshBuffers* buffers = before != model::no_index ? mesh_at_[before] : nullptr;
    if (!buffers || !buffers->source || present.contains(buffers->source.get())) return nullptr;
    return model::same_triangles(*buffers->source, *snapshot_->meshes[i]) ? buffers : nullptr;
  };
  std::map<const model::Mesh*, MeshBuffers> meshes;
  for (size_t i = 0; i < snapshot_->meshes.size(); ++i) {
    const std::shared_ptr<const model::Mesh>& mesh = snapshot_->meshes[i];
    if (meshes.count(mesh.get()) || mesh->triangles.empty()) continue;
    const auto known = meshes_.find(mesh.get());
    if (known != meshes_.end())
      meshes.emplace(mesh.get(), std::move(known->second));
    else if (MeshBuffers* before = moved(i))
      meshes.emplace(mesh.get(), with_vertices(std::move(*before), mesh));
    else
      meshes.emplace(mesh.get(), upload(mesh));
  }
  meshes_ = std::move(meshes);
  mesh_at_.assign(snapshot_->meshes.size(), nullptr);
  mesh_names_ = snapshot_->mesh_names;
  for (size_t i = 0; i < mesh_at_.size(); ++i) {
    const auto found = meshes_.find(snapshot_->meshes[i].get());
    if (found != meshes_.end()) mesh_at_[i] = &found->second;
  }
}

void RasterScene::set_materials() {
  const std::vector<model::Material>& materials = snapshot_->materials;
  std::vector<std::byte> bytes(std::max<size_t>(materials.size(), 1) * material_stride_bytes_);
  for (size_t i = 0; i < materials.size(); ++i) {
    const MaterialRecord record = record_of(materials[i].desc, maps_of(materials[i].desc));
    std::copy_n(reinterpret_cast<const std::byte*>(&record), sizeof(record), &bytes[i * material_stride_bytes_]);
  }
  fill_buffer(gl_, GL_UNIFORM_BUFFER, materials_, bytes.data(), bytes.size());
}

// Sets which lobes are shaded: all opaque surfaces share those of their G-buffer; a translucent one has none, or all
// those that any translucent surface of the scene has.
void RasterScene::set_shadings() {
  const std::vector<model::Material>& materials = snapshot_->materials;
  const uint32_t available = available_maps(static_cast<uint32_t>(gl_.texture_units));
  uint32_t scene_maps = 0, translucent_lobes = 0;
  opaque_lobes_ = 0;
  leaves_textures_out_ = false;
  for (const std::vector<model::Instance>* instances : {&snapshot_->instances, &snapshot_->thin})
    for (const model::Instance& instance : *instances) {
      const model::Material& material = materials[instance.material];
      scene_maps |= maps_of(material.desc) & available;
      leaves_textures_out_ |= (maps_of(material.desc) & ~available) != 0;
      (material.translucent ? translucent_lobes : opaque_lobes_) |= lobes_of(material.desc);
    }
  material_shadings_.clear();
  for (const model::Material& m : materials) {
    const uint32_t maps = map_set_for(maps_of(m.desc) & available, scene_maps);
    const uint32_t lobes = m.translucent ? (lobes_of(m.desc) ? translucent_lobes : 0) : opaque_lobes_;
    material_shadings_.push_back({maps, lobes});
  }
}

// Groups opaque instances into draws, and returns their order in the instance buffer.
std::vector<uint32_t> RasterScene::group(const std::vector<uint32_t>& opaque) {
  const model::Snapshot& s = *snapshot_;
  const auto casts = [&](uint32_t i) { return (s.instances[i].visibility & SIDERAY_VISIBLE_SHADOW) != 0; };
  const auto key = [&](uint32_t i) {
    const model::Instance& instance = s.instances[i];
    return std::make_tuple(material_shadings_[instance.material].maps, instance.wind != 0,
                           s.materials[instance.material].cull_back, instance.mirrored, instance.material,
                           instance.mesh, instance.wind, casts(i));
  };
  // A group holds the instances of one draw; groups are far fewer than instances.
  std::map<decltype(key(0)), std::vector<uint32_t>> groups;
  for (const uint32_t i : opaque) groups[key(i)].push_back(i);
  std::vector<uint32_t> order;
  order.reserve(opaque.size());
  for (const auto& [of_draw, members] : groups) {
    const model::Instance& front = s.instances[members.front()];
    opaque_.push_back({front.mesh,
                       front.material,
                       static_cast<uint32_t>(order.size()),
                       static_cast<uint32_t>(members.size()),
                       front.mirrored,
                       casts(members.front()),
                       0,
                       0,
                       {},
                       front.wind,
                       0});
    for (const uint32_t i : members) add_bounds(opaque_.back().bounds, s.instances[i].bounds);
    order.insert(order.end(), members.begin(), members.end());
  }
  return order;
}

void RasterScene::set_instances() {
  const model::Snapshot& s = *snapshot_;
  opaque_.clear();
  translucent_.clear();
  std::vector<uint32_t> opaque, translucent;
  for (uint32_t i = 0; i < s.instances.size(); ++i) {
    if (!mesh_at_[s.instances[i].mesh]) continue;
    (s.materials[s.instances[i].material].translucent ? translucent : opaque).push_back(i);
  }
  std::vector<uint32_t> order = group(opaque);
  for (const uint32_t i : translucent) {
    const model::Instance& instance = s.instances[i];
    translucent_.push_back({instance.mesh, instance.material, static_cast<uint32_t>(order.size()), 1, instance.mirrored,
                            false, instance.surface_id, instance.visibility, instance.bounds, instance.wind, i});
    order.push_back(i);
  }
  std::vector<InstanceRecord> records;
  records.reserve(order.size() + s.thin.size());
  instance_bounds_.clear();
  block_bounds_.clear();
  const auto add = [&](const model::Instance& instance) {
    records.push_back(record_of(instance));
    if (instance_bounds_.size() % block_size == 0) block_bounds_.emplace_back();
    add_bounds(block_bounds_.back(), instance.bounds);
    instance_bounds_.push_back(instance.bounds);
  };
  for (const uint32_t i : order) add(s.instances[i]);
  thin_.clear();
  for (const model::Instance& instance : s.thin) {
    if (!mesh_at_[instance.mesh]) continue;
    thin_.push_back({instance.mesh, instance.material, static_cast<uint32_t>(records.size()), 1, instance.mirrored,
                     false, instance.surface_id, instance.visibility, instance.bounds, 0, 0});
    add(instance);
  }
  fill_buffer(gl_, GL_ARRAY_BUFFER, instances_, records.data(), records.size() * sizeof(InstanceRecord));
  instance_order_ = std::move(order);
}

void RasterScene::set_gathered() {
  std::vector<std::shared_ptr<const model::Mesh>> meshes;
  for (const Draw& draw : opaque_)
    if (draw.casts_shadow && draw.wind == 0 && !material(draw).discards) meshes.push_back(snapshot_->meshes[draw.mesh]);
  gathered_.set(meshes, {instances_.id(), sizeof(InstanceRecord)});
}

void RasterScene::set_snapshot(std::shared_ptr<const model::Snapshot> snapshot) {
  if (snapshot == snapshot_) return;
  kept_surfaces_ = snapshot_ && same_surfaces(*snapshot_, *snapshot);
  snapshot_ = std::move(snapshot);
  try {
    textures_.set_scene(*snapshot_);
    if (!kept_surfaces_) upload_surfaces();
  } catch (...) {
    // A partial upload counts as none: the next call uploads everything that is missing.
    snapshot_.reset();
    throw;
  }
}

void RasterScene::upload_surfaces() {
  set_meshes();
  set_materials();
  set_shadings();
  set_instances();
  set_gathered();
  gl_.BindVertexArray(0);
  forget_bindings();
  check_allocation(gl_, "meshes and instances");
}

void RasterScene::bind_material(uint32_t material, uint32_t maps) {
  if (material == bound_material_ && maps == bound_maps_) return;
  gl_.BindBufferRange(GL_UNIFORM_BUFFER, block::material, materials_.id(),
                      static_cast<GLintptr>(size_t{material} * material_stride_bytes_), sizeof(MaterialRecord));
  for (uint32_t i = 0; i < material_slot_count; ++i) {
    if (!(maps & (1u << i))) continue;
    const sideray_texture_slot& slot = snapshot_->materials[material].desc.*material_slots[i].slot;
    textures_.bind(unit::material + i, slot.texture ? snapshot_->textures[slot.texture - 1].get() : nullptr, slot);
  }
  bound_material_ = material;
  bound_maps_ = maps;
}

void RasterScene::set_wind(const Program& program, const Draw& draw) const {
  if (draw.wind == 0) return;
  const model::Wind& wind = snapshot_->winds[draw.wind - 1];
  const sideray_wind_desc& d = wind.desc;
  program.set("wind_direction_amplitude", glm::vec4(d.direction[0], d.direction[1], d.direction[2], d.amplitude));
  program.set("wind_sizes", glm::vec4(d.height, d.branch_amplitude, d.leaf_amplitude, d.wavelength));
  program.set("wind_cycles", model::wind_phase(wind, snapshot_->time_s, 0.0f));
}

void RasterScene::point_at_instance(MeshBuffers& mesh, uint32_t first_instance) const {
  if (mesh.instance_offset == first_instance) return;
  // Sets attributes once a mesh from OpenGL 4.2 on, which has base instances; before, pointers move for each draw.
  gl_.BindBuffer(GL_ARRAY_BUFFER, instances_.id());
  constexpr size_t stride = sizeof(InstanceRecord);
  const size_t start = first_instance * stride;
  for (uint32_t c = 0; c < 7; ++c) enable_floats(gl_, 6 + c, 3, stride, start + c * sizeof(glm::vec3));
  gl_.EnableVertexAttribArray(13);
  gl_.VertexAttribIPointer(13, 2, GL_UNSIGNED_INT, stride,
                           offset_pointer(start + offsetof(InstanceRecord, surface_id)));
  enable_floats(gl_, 14, 1, stride, start + offsetof(InstanceRecord, wind_phase));
  if (mesh.instance_offset == 0xffffffffu)
    for (uint32_t location = 6; location <= 14; ++location) gl_.VertexAttribDivisor(location, 1);
  mesh.instance_offset = first_instance;
}

model::Bounds RasterScene::seen_bounds(const glm::mat4& clip_from_local) const {
  model::Bounds seen;
  for (size_t block = 0; block < block_bounds_.size(); ++block) {
    if (is_outside(clip_from_local, block_bounds_[block])) continue;
    const size_t end = std::min((block + 1) * block_size, instance_bounds_.size());
    for (size_t i = block * block_size; i < end; ++i)
      if (!is_outside(clip_from_local, instance_bounds_[i])) add_bounds(seen, instance_bounds_[i]);
  }
  for (const model::ParticleSystem& system : snapshot_->particles) {
    if (!system.desc.lit || system.sprites.empty()) continue;
    model::Bounds centers;
    for (const model::Sprite& s : system.sprites) centers.add(s.position);
    if (!is_outside(clip_from_local, centers)) add_bounds(seen, centers);
  }
  return seen;
}

void RasterScene::set_positions_before(const Draw& draw, const model::Mesh& before) {
  gl_.BindVertexArray(mesh_at_[draw.mesh]->vertex_array.id());
  gl_.BindBuffer(GL_ARRAY_BUFFER, positions_before_.id());
  gl_.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(before.positions.size() * sizeof(glm::vec3)),
                 before.positions.data(), GL_STREAM_DRAW);
  enable_floats(gl_, location_before, 3, sizeof(glm::vec3), 0);
}

void RasterScene::forget_positions_before(const Draw& draw) {
  gl_.BindVertexArray(mesh_at_[draw.mesh]->vertex_array.id());
  gl_.DisableVertexAttribArray(location_before);
}

void RasterScene::draw_range(const Draw& draw, uint32_t first_instance, uint32_t count) {
  MeshBuffers& mesh = *mesh_at_[draw.mesh];
  if (gathers_ && gathered_.holds(mesh.source.get())) return gathered_.add(mesh.source.get(), first_instance, count);
  gl_.BindVertexArray(mesh.vertex_array.id());
  const auto [mode, corners] = primitives_of(*mesh.source);
  const auto indices = static_cast<GLsizei>(corners * mesh.source->triangles.size());
  const auto instances = static_cast<GLsizei>(count);
  if (gl_.version >= 42) {
    point_at_instance(mesh, 0);
    gl_.DrawElementsInstancedBaseInstance(mode, indices, GL_UNSIGNED_INT, nullptr, instances, first_instance);
  } else {
    point_at_instance(mesh, first_instance);
    gl_.DrawElementsInstanced(mode, indices, GL_UNSIGNED_INT, nullptr, instances);
  }
}

}  // namespace sideray::gl
