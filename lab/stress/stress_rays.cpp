// Tests the results of sideray_tracer_trace_rays for pixels with more surfaces than the layer cache holds, and for
// meshes with broken triangles.
#include <cmath>
#include <limits>

#include "lab/stress/stress_scene.h"

namespace sideray::lab {
namespace {

// Returns rays from the origin, through the pixels of a view along -z.
std::vector<sideray_ray> view_rays(const StressStage& stage) {
  const double half = std::tan(glm::radians(22.5));
  std::vector<sideray_ray> rays;
  for (uint32_t y = 0; y < stage.height; ++y)
    for (uint32_t x = 0; x < stage.width; ++x) {
      const double v = half * (1.0 - (y + 0.5) / stage.height * 2.0);
      const double u = half * ((x + 0.5) / stage.width * 2.0 - 1.0) * stage.width / stage.height;
      const glm::vec3 d(glm::normalize(glm::dvec3(u, v, -1.0)));
      sideray_ray ray{};
      for (int c = 0; c < 3; ++c) ray.direction[c] = d[c];
      ray.t_far = std::numeric_limits<float>::max();
      rays.push_back(ray);
    }
  return rays;
}

using Ids = std::vector<std::vector<uint32_t>>;  // the surfaces of each ray, in order

Ids by_multihit(Tracer& tracer, const std::vector<sideray_ray>& rays, uint32_t layers) {
  const std::vector<sideray_hit> hits = tracer.trace(SIDERAY_RAYS_TRANSLUCENT, rays, layers);
  Ids ids(rays.size());
  for (size_t i = 0; i < hits.size(); ++i) ids[i / layers].push_back(hits[i].surface_id);
  return ids;
}

// Steps by listing 50-1: MinT grows by the distance of each hit, although distances are measured from the eye.
Ids by_listing(Tracer& tracer, std::vector<sideray_ray> rays, uint32_t layers) {
  constexpr double epsilon = 1e-6;
  Ids ids(rays.size());
  for (uint32_t event = 0; event < layers; ++event) {
    const std::vector<sideray_hit> hits = tracer.trace(SIDERAY_RAYS_TRANSLUCENT, rays);
    for (size_t i = 0; i < rays.size(); ++i) {
      ids[i].push_back(hits[i].surface_id);
      if (hits[i].surface_id != 0) rays[i].t_near += static_cast<float>(hits[i].distance * (1.0 + epsilon));
    }
  }
  return ids;
}

StressRow count(const StressStage& stage, const Ids& ids, uint32_t layers) {
  StressRow row;
  row.name = "ray-layers";
  row.parameters = {{"panes", layers}};
  row.measure = "surfaces lost or out of order, share";
  row.map = map_of(stage);
  uint64_t wrong = 0;
  for (size_t i = 0; i < ids.size(); ++i)
    for (uint32_t k = 0; k < layers; ++k)
      if (ids[i][k] != k + 1) row.map.wrong[i] = 1, ++wrong;
  row.value = static_cast<double>(wrong) / static_cast<double>(ids.size() * layers);
  return row;
}

constexpr std::array<const char*, 5> broken_kinds{"none", "no area", "NaN corner", "corner at 1e30", "skinny"};

// Returns a wall at z = -2 with 64 triangles of one kind in the same mesh. Broken triangles, which must be dropped, are
// in front of the wall; skinny ones, which are valid, behind it.
Scene wall_with(const std::string& kind) {
  std::vector<glm::vec3> positions{{-8, -8, -2}, {8, -8, -2}, {8, 8, -2}, {-8, -8, -2}, {8, 8, -2}, {-8, 8, -2}};
  for (int i = 0; kind != "none" && i < 64; ++i) {
    const float x = 0.02f * static_cast<float>(i - 32), z = kind == "skinny" ? -3.0f : -1.0f;
    glm::vec3 last(x, 0.0f, z);  // on the line between the others: no area
    if (kind == "NaN corner") last.x = std::numeric_limits<float>::quiet_NaN();
    if (kind == "corner at 1e30") last.x = 1e30f;
    if (kind == "skinny") last.x += 1e-6f;
    positions.insert(positions.end(), {{x, -1.0f, z}, {x, 1.0f, z}, last});
  }
  Scene scene = Scene::create().value();
  sideray_mesh_desc mesh = sideray_mesh_defaults();
  mesh.vertex_count = static_cast<uint32_t>(positions.size());
  mesh.positions.data = &positions[0].x;
  sideray_instance_desc instance{};
  instance.mesh = scene.add_mesh(mesh);
  instance.material = scene.add_material(sideray_material_defaults());
  for (const int diagonal : {0, 4, 8}) instance.world_from_object[diagonal] = 1.0;
  instance.surface_id = 1;
  instance.visibility = SIDERAY_VISIBLE_ALL;
  scene.add_instances({&instance, 1});
  scene.commit();
  return scene;
}

}  // namespace

std::vector<StressRow> ray_layers_case(StressStage& stage) {
  std::vector<StressRow> rows;
  const std::vector<sideray_ray> rays = view_rays(stage);
  for (const double panes : swept(stage, {1, 2, 4, 8, 16, 32, 64}, {2, 64})) {
    const auto layers = static_cast<uint32_t>(panes);
    std::vector<Pane> stack;
    for (uint32_t i = 0; i < layers; ++i) stack.push_back(pane_across(2.0 + 0.05 * i));
    const Scene scene = scene_of_panes(stack);
    Tracer tracer = Tracer::create(scene).value();
    rows.push_back(count(stage, by_multihit(tracer, rays, layers), layers));
    rows.back().variant = "sideray_tracer_trace_rays", rows.back().is_default = true;
    rows.push_back(count(stage, by_listing(tracer, rays, layers), layers));
    rows.back().variant = "one ray a surface, t_near as in listing 50-1";
  }
  return rows;
}

std::vector<StressRow> broken_triangles_case(StressStage& stage) {
  std::vector<StressRow> rows;
  const std::vector<sideray_ray> rays = view_rays(stage);
  for (const std::string kind : broken_kinds) {
    const Scene scene = wall_with(kind);
    Tracer tracer = Tracer::create(scene).value();
    const std::vector<sideray_hit> hits = tracer.trace(SIDERAY_RAYS_OPAQUE, rays);
    StressRow row;
    row.name = "broken-triangles", row.variant = "sideray_tracer_trace_rays", row.is_default = true;
    row.parameters = {{"kind", kind}, {"triangles", 64}};
    row.measure = "rays that do not hit the wall where it is, share";
    row.map = map_of(stage);
    uint64_t wrong = 0;
    for (size_t i = 0; i < rays.size(); ++i) {
      const double exact = -2.0 / double{rays[i].direction[2]};
      if (!(std::abs(hits[i].distance - exact) <= 1e-6 * exact)) row.map.wrong[i] = 1, ++wrong;
    }
    row.value = static_cast<double>(wrong) / static_cast<double>(rays.size());
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace sideray::lab
