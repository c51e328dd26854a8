// Small scenes, cameras and depth buffers for the tests of the tracer.
#pragma once

#include <cstring>
#include <glm/glm.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/packing.hpp>
#include <memory>
#include <vector>

#include "model/material.h"
#include "model/scene.h"
#include "rt/tracer.h"

namespace sideray::rt::test {

inline sideray_texture_slot no_texture() {
  return model::default_material().base_color_texture;
}

inline sideray_material_desc plain_material() {
  sideray_material_desc m = model::default_material();
  m.double_sided = 1;
  return m;
}

inline sideray_material_desc blended(glm::vec3 color, float alpha) {
  sideray_material_desc m = plain_material();
  m.alpha_mode = SIDERAY_BLEND;
  m.base_color[0] = color.x, m.base_color[1] = color.y, m.base_color[2] = color.z, m.base_color[3] = alpha;
  return m;
}

inline sideray_material_desc glass() {
  sideray_material_desc m = plain_material();
  m.transmission = 1.0f;
  m.roughness = 0.0f;
  return m;
}

inline sideray_material_desc mirror() {
  sideray_material_desc m = blended(glm::vec3(1.0f), 1.0f);
  m.metallic = 1.0f;
  m.roughness = 0.0f;
  return m;
}

inline sideray_material_desc glowing(glm::vec3 radiance) {
  sideray_material_desc m = plain_material();
  m.base_color[0] = m.base_color[1] = m.base_color[2] = 0.0f;
  m.specular = 0.0f;
  m.emissive[0] = radiance.x, m.emissive[1] = radiance.y, m.emissive[2] = radiance.z;
  return m;
}

inline sideray_material_desc matt(float albedo, glm::vec3 emission = glm::vec3(0.0f)) {
  sideray_material_desc m = glowing(emission);
  for (int c = 0; c < 3; ++c) m.base_color[c] = albedo;
  m.unlit = 0;
  m.specular = 0.0f;
  m.roughness = 1.0f;
  m.double_sided = 1;
  return m;
}

// Parallelograms added one by one; surface ids count from 1.
class TestScene {
 public:
  // Corners center -+ u -+ v; the front faces along u x v. Returns the surface id.
  uint32_t quad(glm::vec3 center, glm::vec3 u, glm::vec3 v, const sideray_material_desc& material,
                uint32_t visibility = SIDERAY_VISIBLE_ALL) {
    const std::vector<glm::vec3> positions{center - u - v, center + u - v, center + u + v, center - u + v};
    const std::vector<glm::vec2> uv{{0, 1}, {1, 1}, {1, 0}, {0, 0}};
    const std::vector<uint32_t> indices{0, 1, 2, 0, 2, 3};
    return add(positions, uv, indices, material, glm::dmat4(1.0), visibility);
  }

  uint32_t add(const std::vector<glm::vec3>& positions, const std::vector<glm::vec2>& uv,
               const std::vector<uint32_t>& indices, const sideray_material_desc& material,
               const glm::dmat4& world_from_object, uint32_t visibility = SIDERAY_VISIBLE_ALL) {
    sideray_mesh_desc mesh{};
    mesh.size = sizeof(mesh);
    mesh.vertex_count = static_cast<uint32_t>(positions.size());
    mesh.index_count = static_cast<uint32_t>(indices.size());
    mesh.indices = indices.data();
    mesh.positions = {&positions[0].x, 0};
    mesh.uv0 = {&uv[0].x, 0};
    sideray_instance_desc instance{};
    instance.mesh = scene.add_mesh(mesh, nullptr);
    instance.material = scene.add_material(material);
    for (int c = 0; c < 4; ++c)
      for (int r = 0; r < 3; ++r) instance.world_from_object[3 * c + r] = world_from_object[c][r];
    instance.surface_id = next_id_++;
    instance.visibility = visibility;
    scene.add_instances(&instance, 1);
    return instance.surface_id;
  }

  void environment(glm::vec3 radiance) {
    std::vector<glm::vec3> texels(32 * 16, radiance);
    scene.set_environment(32, 16, &texels[0].x, 1.0f, 0.0f);
  }

  void lights(const std::vector<sideray_light>& all) { scene.set_lights(all.data(), all.size()); }

  std::shared_ptr<const model::Snapshot> commit() {
    scene.commit();
    return scene.snapshot();
  }

  model::Scene scene;

 private:
  uint32_t next_id_ = 1;
};

inline sideray_light point_light(glm::vec3 position, float intensity) {
  sideray_light l{};
  l.size = sizeof(l);
  l.type = SIDERAY_LIGHT_POINT;
  for (int i = 0; i < 3; ++i) l.position[i] = static_cast<double>(position[i]), l.intensity[i] = intensity;
  return l;
}

inline sideray_light directional_light(glm::vec3 direction, float irradiance) {
  sideray_light l{};
  l.size = sizeof(l);
  l.type = SIDERAY_LIGHT_DIRECTIONAL;
  for (int i = 0; i < 3; ++i) l.direction[i] = direction[i], l.intensity[i] = irradiance;
  return l;
}

// Infinite reversed depth with clip z 0..w.
inline TraceView perspective(glm::dvec3 eye, glm::dvec3 target, double yfov, double aspect, double near = 0.1) {
  const double f = 1.0 / std::tan(0.5 * yfov);
  const glm::dmat4 clip_from_view(f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, 0, -1, 0, 0, near, 0);
  const glm::dvec3 up = std::abs(glm::normalize(target - eye).y) > 0.99 ? glm::dvec3(0, 0, -1) : glm::dvec3(0, 1, 0);
  TraceView view;
  view.clip_from_local = clip_from_view * glm::lookAt(eye, target, up);
  view.local_from_clip = glm::inverse(view.clip_from_local);
  view.reversed_depth = view.zero_to_one_depth = true;
  return view;
}

// The same kind of depth; `half_height`: of what is seen.
inline TraceView orthographic(glm::dvec3 eye, glm::dvec3 target, double half_height, double aspect) {
  constexpr double near = 0.1, far = 100.0;
  const glm::dmat4 clip_from_view(1.0 / (half_height * aspect), 0, 0, 0, 0, 1.0 / half_height, 0, 0, 0, 0, 1.0 / (far - near), 0,
                                  0, 0, far / (far - near), 1);
  TraceView view;
  view.clip_from_local = clip_from_view * glm::lookAt(eye, target, glm::dvec3(0, 1, 0));
  view.local_from_clip = glm::inverse(view.clip_from_local);
  view.reversed_depth = view.zero_to_one_depth = true;
  return view;
}

// D32F_S8 as read back: a float and a word with the stencil in its low bits.
class DepthBuffer {
 public:
  DepthBuffer(uint32_t width, uint32_t height, float depth, uint32_t stencil) : width_(width) {
    texels_.resize(size_t{8} * width * height);
    for (uint32_t y = 0; y < height; ++y)
      for (uint32_t x = 0; x < width; ++x) set(x, y, depth, stencil);
  }
  void set(uint32_t x, uint32_t y, float depth, uint32_t stencil) {
    const uint32_t word = 0xabcdef00u | stencil;  // the upper bits are undefined
    std::memcpy(&texels_[8 * (size_t{y} * width_ + x)], &depth, 4);
    std::memcpy(&texels_[8 * (size_t{y} * width_ + x) + 4], &word, 4);
  }
  DepthImage image() const { return {texels_.data(), size_t{8} * width_, DepthFormat::d32f_s8}; }

 private:
  uint32_t width_;
  std::vector<std::byte> texels_;
};

// Nothing opaque, every pixel masked with `count` layers.
struct TestFrame {
  TestFrame(const TraceView& view, uint32_t width, uint32_t height, uint32_t layers, uint32_t count = 63)
      : depth(width, height, 0.0f, count) {
    request.view = view;
    request.width = width, request.height = height;
    request.max_layers = layers;
    request.denoise = 0;
  }
  CacheRequest& get() {
    request.depth = depth.image();
    return request;
  }
  DepthBuffer depth;
  CacheRequest request;
};

inline glm::vec3 rgb(const std::vector<uint16_t>& texels, size_t texel) {
  return {glm::unpackHalf1x16(texels[4 * texel]), glm::unpackHalf1x16(texels[4 * texel + 1]),
          glm::unpackHalf1x16(texels[4 * texel + 2])};
}

inline size_t texel_of(const LayerCache& c, uint32_t x, uint32_t y, uint32_t layer) {
  return (size_t{layer} * c.height + y) * c.width + x;
}

}  // namespace sideray::rt::test
