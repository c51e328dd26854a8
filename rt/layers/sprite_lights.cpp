#include "rt/layers/sprite_lights.h"

#include <algorithm>
#include <span>

#include "rt/layers/layer_tracer.h"
#include "rt/surfaces/sprite_surface.h"

namespace sideray::rt {
namespace {

constexpr size_t sprites_in_piece = 256;

// Returns the centre of a sprite as a white, diffuse surface. Its ray has no end, so that it does not fade.
SurfacePoint white_sprite(const model::Snapshot& snapshot, uint32_t instance, uint32_t sprite) {
  const Hit hit{.distance = 0.0, .u = 0.0f, .v = 0.5f, .instance = instance, .primitive = 2 * sprite, .front = true};
  const model::Mesh& mesh = *snapshot.meshes[snapshot.instances[instance].mesh];
  const Ray ray{glm::vec3(0.0f), 0.0f, -mesh.normals[mesh.triangles[hit.primitive].x], farthest};
  SurfacePoint point = sprite_point(snapshot, hit, ray, {});
  point.surface = shading::sr_sprite(glm::vec4(1.0f), point.to_eye, true, 1.0f, 0);
  point.hit = hit;
  return point;
}

bool is_lit(const model::Snapshot& snapshot, const model::Instance& instance) {
  return snapshot.particles[instance.sprites - 1].desc.lit != 0;
}

}  // namespace

Counters SpriteLights::light(const ShadingScene& scene, const Intersector& intersector, Rays rays, Executor& executor) {
  const model::Snapshot& snapshot = *scene.snapshot;
  first_.clear();
  white_.clear();
  if (!scene.records.sprites) return {};
  struct Place {
    uint32_t instance, sprite;
  };
  std::vector<Place> lit;
  std::vector<size_t> places;
  first_.assign(snapshot.instances.size(), 0);
  for (uint32_t i = 0; i < snapshot.instances.size(); ++i) {
    const model::Instance& instance = snapshot.instances[i];
    if (instance.sprites == 0) continue;
    first_[i] = static_cast<uint32_t>(white_.size());
    const auto count = static_cast<uint32_t>(snapshot.meshes[instance.mesh]->triangles.size() / 2);
    for (uint32_t s = 0; is_lit(snapshot, instance) && s < count; ++s) {
      lit.push_back({i, s});
      places.push_back(white_.size() + s);
    }
    white_.resize(white_.size() + count, glm::vec3(0.0f));
  }
  const size_t pieces = (lit.size() + sprites_in_piece - 1) / sprites_in_piece;
  std::vector<Counters> counted(executor.threads());
  executor.run(pieces, [&](size_t piece, uint32_t thread) {
    const size_t first = piece * sprites_in_piece, end = std::min(first + sprites_in_piece, lit.size());
    std::vector<SurfacePoint> points;
    for (size_t i = first; i < end; ++i) points.push_back(white_sprite(snapshot, lit[i].instance, lit[i].sprite));
    std::vector<glm::vec3> radiance(points.size());
    FragmentShader& shader = shaders_[thread];
    shader.begin(scene, intersector, rays.shadows, rays.tints);
    shader.shade(points, radiance.data());
    add_work(shader, {}, counted[thread]);
    for (size_t i = first; i < end; ++i) white_[places[i]] = radiance[i - first];
  });
  Counters counters;
  for (const Counters& c : counted) counters += c;
  return counters;
}

}  // namespace sideray::rt
