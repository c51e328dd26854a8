#include "rt/poses/particle_quads.h"

#include <algorithm>
#include <cmath>

#include "elementary/functions.h"
#include "model/particles.h"
#include "rt/textures/sprite_texel.h"
#include "shaders/shading/shading_cpp.h"

namespace sideray::rt {
namespace {

// Holds the part of a view that sprites need, as in gl/scene/raster_sprites.cpp.
struct SpriteView {
  glm::dvec3 eye{0.0}, x, y, forward;  // unit axes of the picture
  bool perspective;
  double pixel;  // world units a pixel; perspective: at depth 1

  SpriteView(const TraceView& view, uint32_t height) {
    const glm::dmat4& m = view.local_from_clip;
    const glm::dmat4& c = view.clip_from_local;
    perspective = glm::length(glm::dvec3(c[0].w, c[1].w, c[2].w)) > 1e-12 * std::abs(c[3].w);
    if (perspective) eye = glm::dvec3(m[2]) / m[2].w;
    // The axes come from a plane parallel to the picture, between points one unit of clip space apart.
    const double near_clip =
        view.zero_to_one_depth ? (view.reversed_depth ? 1.0 : 0.0) : (view.reversed_depth ? 1.0 : -1.0);
    const auto point = [&](double u, double v) {
      const glm::dvec4 p = m * glm::dvec4(u, v, near_clip, 1.0);
      return glm::dvec3(p) / p.w;
    };
    const glm::dvec3 middle = point(0, 0), right = point(1, 0) - middle, up = point(0, 1) - middle;
    x = glm::normalize(right);
    y = glm::normalize(up);
    forward = glm::normalize(glm::cross(up, right));
    pixel = glm::length(up) * 2.0 / height;
    if (perspective) pixel /= glm::dot(middle - eye, forward);
  }

  double pixel_at(glm::vec3 position) const {
    return perspective ? pixel * glm::dot(glm::dvec3(position) - eye, forward) : pixel;
  }
  glm::vec3 to_eye(glm::vec3 position) const {
    return glm::vec3(perspective ? glm::normalize(eye - glm::dvec3(position)) : -forward);
  }
  // Fills in the corners, counter-clockwise as seen, starting at the lower left.
  void corners(const model::Sprite& s, glm::vec3 (&corner)[4]) const {
    const double cosine = elementary::cos(static_cast<double>(s.rotation)), sine = elementary::sin(static_cast<double>(s.rotation));
    constexpr double sides[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    for (int i = 0; i < 4; ++i) {
      const double u = sides[i][0] * static_cast<double>(s.half_size.x),
                   v = sides[i][1] * static_cast<double>(s.half_size.y);
      corner[i] = glm::vec3(glm::dvec3(s.position) + x * (cosine * u - sine * v) + y * (sine * u + cosine * v));
    }
  }
};

void add_quad(model::Mesh& mesh, const model::Sprite& s, const SpriteView& view, float level) {
  constexpr glm::vec2 places[4] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
  const auto first = static_cast<uint32_t>(mesh.positions.size());
  glm::vec3 corners[4];
  view.corners(s, corners);
  for (int i = 0; i < 4; ++i) {
    mesh.positions.push_back(corners[i]);
    mesh.bounds.add(corners[i]);
    mesh.normals.push_back(view.to_eye(s.position));
    mesh.uv0.push_back(places[i]);
    mesh.uv1.emplace_back(level, 0.0f);
    mesh.colors.push_back(s.color);
  }
  mesh.triangles.emplace_back(first, first + 1, first + 2);
  mesh.triangles.emplace_back(first, first + 2, first + 3);
}

std::shared_ptr<const model::Mesh> quads_of(const model::Snapshot& snapshot, const model::ParticleSystem& system,
                                            const SpriteView& view) {
  auto mesh = std::make_shared<model::Mesh>();
  const model::FlipBook book = model::flip_book(system.desc, sprite_texture(snapshot, system.desc));
  for (const model::Sprite& s : system.sprites) {
    const auto pixel = static_cast<float>(view.pixel_at(s.position));
    add_quad(*mesh, s, view, shading::sr_sprite_level(book.cell_texels, 2.0f * s.half_size, pixel, book.last_level));
  }
  mesh->tangents.assign(mesh->positions.size(), glm::vec4(0.0f));
  mesh->has_colors = true;
  mesh->minimum_alpha = 0.0f;
  return mesh;
}

// Returns a material with the fields that acceleration structures need; sprites are shaded by their own.
model::Material quad_material(const sideray_particles_desc& d) {
  model::Material material{};
  material.desc.size = sizeof(material.desc);
  material.desc.alpha_mode = SIDERAY_BLEND;
  material.desc.blend_mode = d.blend_mode;
  material.desc.ior = 1.0f;
  material.desc.attenuation_distance = INFINITY;
  material.translucent = true;
  material.discards = d.blend_mode != SIDERAY_BLEND_PREMULTIPLIED;
  return material;
}

}  // namespace

bool has_sprites(const model::Snapshot& snapshot) {
  return std::any_of(snapshot.particles.begin(), snapshot.particles.end(),
                     [](const model::ParticleSystem& s) { return !s.sprites.empty(); });
}

uint64_t count_sprites_in_view(const model::Snapshot& snapshot, const TraceView& trace_view) {
  const SpriteView view(trace_view, 1);
  const auto in_view = [&](const model::Sprite& s) {
    glm::vec3 corners[4];
    view.corners(s, corners);
    int outside[6] = {};
    for (const glm::vec3& corner : corners) {
      const glm::dvec4 p = trace_view.clip_from_local * glm::dvec4(corner, 1.0);
      const double low_z = trace_view.zero_to_one_depth ? 0.0 : -p.w;
      outside[0] += p.x < -p.w;
      outside[1] += p.x > p.w;
      outside[2] += p.y < -p.w;
      outside[3] += p.y > p.w;
      outside[4] += p.z < low_z;
      outside[5] += p.z > p.w;
    }
    return std::none_of(std::begin(outside), std::end(outside),
                        [](int corners_outside) { return corners_outside == 4; });
  };
  uint64_t count = 0;
  for (const model::ParticleSystem& system : snapshot.particles)
    count += static_cast<uint64_t>(std::count_if(system.sprites.begin(), system.sprites.end(), in_view));
  return count;
}

std::shared_ptr<const model::Snapshot> with_sprite_quads(const model::Snapshot& snapshot, const TraceView& trace_view,
                                                         uint32_t height) {
  const SpriteView view(trace_view, height);
  auto result = std::make_shared<model::Snapshot>(snapshot);
  for (uint32_t i = 0; i < snapshot.particles.size(); ++i) {
    const model::ParticleSystem& system = snapshot.particles[i];
    if (system.sprites.empty()) continue;
    model::Instance instance{};
    instance.mesh = static_cast<uint32_t>(result->meshes.size());
    instance.material = static_cast<uint32_t>(result->materials.size());
    instance.local_from_object = glm::mat4x3(1.0f);
    instance.normal_from_object = glm::mat3(1.0f);
    instance.sprites = i + 1;
    result->meshes.push_back(quads_of(snapshot, system, view));
    instance.bounds = result->meshes.back()->bounds;
    result->materials.push_back(quad_material(system.desc));
    result->instances.push_back(instance);
  }
  return result;
}

}  // namespace sideray::rt
