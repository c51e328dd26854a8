#include "rt/poses/particle_quads.h"

#include <algorithm>
#include <cmath>

#include "model/particles.h"
#include "rt/textures/texture_sample.h"

namespace sideray::rt {
namespace {

// The part of a view that sprites need, as gl/scene/raster_sprites.cpp has it.
struct SpriteView {
  glm::dvec3 eye{0.0}, x, y, forward;  // unit axes of the picture
  bool perspective;
  double pixel;  // world units a pixel; perspective: at depth 1

  SpriteView(const TraceView& view, uint32_t height) {
    const glm::dmat4& m = view.local_from_clip;
    const glm::dmat4& c = view.clip_from_local;
    perspective = glm::length(glm::dvec3(c[0].w, c[1].w, c[2].w)) > 1e-12 * std::abs(c[3].w);
    if (perspective) eye = glm::dvec3(m[2]) / m[2].w;
    // From the middle of a plane parallel to the picture, one unit of clip space each way.
    const double near_clip =
        view.zero_to_one_depth ? (view.reversed_depth ? 1.0 : 0.0) : (view.reversed_depth ? 1.0 : -1.0);
    const auto point = [&](double u, double v) {
      const glm::dvec4 p = m * glm::dvec4(u, v, near_clip, 1.0);
      return glm::dvec3(p) / p.w;
    };
    const glm::dvec3 middle = point(0, 0), right = point(1, 0) - middle, up = point(0, 1) - middle;
    x = glm::normalize(right), y = glm::normalize(up);
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
  // Corners from the lower left, counter-clockwise as seen.
  void corners(const model::Sprite& s, glm::vec3 (&corner)[4]) const {
    const double cosine = std::cos(static_cast<double>(s.rotation)), sine = std::sin(static_cast<double>(s.rotation));
    constexpr double sides[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    for (int i = 0; i < 4; ++i) {
      const double u = sides[i][0] * static_cast<double>(s.half_size.x),
                   v = sides[i][1] * static_cast<double>(s.half_size.y);
      corner[i] = glm::vec3(glm::dvec3(s.position) + x * (cosine * u - sine * v) + y * (sine * u + cosine * v));
    }
  }
};

const model::Texture* texture_of(const model::Snapshot& snapshot, const sideray_particles_desc& d) {
  return d.texture ? snapshot.textures[d.texture - 1].get() : nullptr;
}

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
  const model::FlipBook book = model::flip_book(system.desc, texture_of(snapshot, system.desc));
  for (const model::Sprite& s : system.sprites) {
    const auto pixel = static_cast<float>(view.pixel_at(s.position));
    add_quad(*mesh, s, view, shading::sr_sprite_level(book.cell_texels, 2.0f * s.half_size, pixel, book.last_level));
  }
  mesh->tangents.assign(mesh->positions.size(), glm::vec4(0.0f));
  mesh->has_colors = true;
  mesh->minimum_alpha = 0.0f;
  return mesh;
}

// The acceleration structures ask this of a material; sprites are shaded by their own.
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

struct QuadPlace {
  const sideray_particles_desc& desc;
  const model::Sprite& sprite;
  const model::Mesh& mesh;
  uint32_t vertex;  // the first of four
  glm::vec4 color;  // texel times colour
};

QuadPlace quad_place(const model::Snapshot& snapshot, const Hit& hit) {
  const model::Instance& instance = snapshot.instances[hit.instance];
  const model::ParticleSystem& system = snapshot.particles[instance.sprites - 1];
  const model::Mesh& mesh = *snapshot.meshes[instance.mesh];
  const glm::uvec3 t = mesh.triangles[hit.primitive];
  QuadPlace place{system.desc, system.sprites[hit.primitive / 2], mesh, t.x, mesh.colors[t.x]};
  const model::Texture* texture = texture_of(snapshot, system.desc);
  if (!texture) return place;
  const glm::vec2 corner = mesh.uv0[t.x] * (1.0f - hit.u - hit.v) + mesh.uv0[t.y] * hit.u + mesh.uv0[t.z] * hit.v;
  const model::FlipBook book = model::flip_book(system.desc, texture);
  const float level = mesh.uv1[t.x].x;
  const uint32_t columns = system.desc.columns;
  const glm::vec2 cell(static_cast<float>(place.sprite.cell % columns),
                       static_cast<float>(place.sprite.cell / columns));
  const glm::vec2 cells(static_cast<float>(columns), static_cast<float>(system.desc.rows));
  const glm::vec2 uv = shading::sr_sprite_place(corner, cell, cells, book.cell_texels, level);
  place.color *= sample(*texture, model::flip_book_slot(), uv, level);
  return place;
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
      outside[0] += p.x<-p.w, outside[1] += p.x> p.w, outside[2] += p.y<-p.w, outside[3] += p.y> p.w;
      outside[4] += p.z<low_z, outside[5] += p.z> p.w;
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

bool sprite_discards(const model::Snapshot& snapshot, const Hit& hit) {
  const QuadPlace place = quad_place(snapshot, hit);
  return shading::sr_sprite_absent(place.color.w, static_cast<int>(place.desc.blend_mode));
}

SurfacePoint sprite_point(const model::Snapshot& snapshot, const Hit& hit, const Ray& ray, Cone cone) {
  const QuadPlace place = quad_place(snapshot, hit);
  const glm::vec3* corners = &place.mesh.positions[place.vertex];
  const glm::vec3 toward_viewer = glm::normalize(glm::cross(corners[1] - corners[0], corners[3] - corners[0]));
  const float along_axis = std::abs(glm::dot(ray.direction, toward_viewer));
  const float gap = (ray.t_far - static_cast<float>(hit.distance)) * along_axis;
  const glm::vec3 center = place.sprite.position;
  SurfacePoint point{};
  point.blend = static_cast<int>(place.desc.blend_mode);
  point.to_eye = point.geometric_normal = place.mesh.normals[place.vertex];
  point.surface = shading::sr_sprite(place.color, point.to_eye, place.desc.lit != 0,
                                     shading::sr_soft_fade(gap, place.desc.soft_distance), point.blend);
  // Lit where its centre is, whatever part of it is seen.
  point.position = center;
  point.offset = 0x1p-20f * std::max({std::abs(center.x), std::abs(center.y), std::abs(center.z)});
  point.cone = {cone.width + cone.spread * static_cast<float>(hit.distance), cone.spread};
  return point;
}

}  // namespace sideray::rt
