#include "rt/shading/host_points.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "rt/base/float_mode.h"
#include "rt/shading/mirror_rays.h"

namespace sideray::rt {
namespace {

// Rays stop before the light by this share of the distance, so that rounding does not carry them past it.
constexpr float short_of_light = 1e-5f;
constexpr uint32_t most_numbered_lights = 32;

template <size_t N, typename Vector>
void store(float (&to)[N], const Vector& from) {
  static_assert(Vector::length() == N);
  for (size_t i = 0; i < N; ++i) to[i] = from[static_cast<int>(i)];
}

glm::vec3 to_vec3(const float (&v)[3]) {
  return {v[0], v[1], v[2]};
}

glm::vec3 mirrored(const SurfacePoint& p) {
  const glm::vec3 n = p.surface.normal;
  return shading::sr_lifted(n * (2.0f * glm::dot(p.to_eye, n)) - p.to_eye, p.geometric_normal);
}

bool is_finite(const sideray_shading_result& r) {
  float sum = r.alpha * 0.0f;  // not 0 if any of the numbers is not finite
  for (size_t c = 0; c < 3; ++c)
    sum += (r.radiance[c] * 0.0f + r.transmittance[c] * 0.0f) + (r.reflectance[c] * 0.0f + r.reflection[c] * 0.0f);
  return sum == 0.0f;
}

}  // namespace

void HostPoints::begin(const ShadingScene& scene, const Intersector& intersector, const HostCalls& calls,
                       bool shadows) {
  scene_ = &scene;
  intersector_ = &intersector;
  calls_ = calls;
  shadows_ = shadows;
  straight_.begin(scene, intersector);
  rays_shadow = asked = not_finite = 0;
  end = TraceEnd::complete;
}

void HostPoints::ask(std::span<const SurfacePoint> points, Kind kind, std::vector<HostAnswer>& answers) {
  answers.clear();
  for (size_t first = 0; first < points.size() && end == TraceEnd::complete; first += SIDERAY_SHADING_BATCH) {
    const std::span<const SurfacePoint> batch =
        points.subspan(first, std::min<size_t>(SIDERAY_SHADING_BATCH, points.size() - first));
    points_.resize(batch.size());
    results_.resize(batch.size());
    find_lights(batch, kind.shadows && shadows_);
    for (size_t i = 0; i < batch.size(); ++i) describe(batch[i], i, kind);
    if (!call()) break;
    for (size_t i = 0; i < batch.size(); ++i) answers.push_back(answer(batch[i], results_[i]));
  }
  answers.resize(points.size());
}

void HostPoints::find_lights(std::span<const SurfacePoint> points, bool shadows) {
  lights_.assign(points.size(), 0);
  if (straight_.is_tinted()) {
    tints_.assign(points.size() * most_numbered_lights * 3, 1.0f);
    tinted_.assign(points.size(), 0);
  }
  for (size_t i = 0; i < scene_->lights.size(); ++i) {
    const uint32_t number = scene_->light_numbers[i];
    if (number >= most_numbered_lights) break;
    const uint32_t bit = 1u << number;
    find_light(points, scene_->lights[i], bit, shadows && (scene_->snapshot->shader.shadow_lights & bit) != 0);
  }
}

void HostPoints::find_light(std::span<const SurfacePoint> points, const shading::SrLight& light, uint32_t bit,
                            bool trace) {
  rays_.clear();
  of_points_.clear();
  for (size_t i = 0; i < points.size(); ++i) {
    const SurfacePoint& p = points[i];
    const shading::SrIncidence in = shading::sr_incidence(light, p.position);
    if (!(std::max({in.irradiance.x, in.irradiance.y, in.irradiance.z}) > 0.0f)) continue;
    lights_[i] |= bit;
    if (!trace) continue;
    const bool behind = glm::dot(p.geometric_normal, in.to_light) < 0.0f;
    const glm::vec3 origin = p.position + p.geometric_normal * (behind ? -p.offset : p.offset);
    rays_.push_back({origin, 0.0f, in.to_light, in.distance * (1.0f - short_of_light)});
    of_points_.push_back(static_cast<uint32_t>(i));
  }
  if (rays_.empty()) return;
  blocked_.assign(rays_.size(), 0);
  intersector_->occluded(rays_, false, blocked_.data());
  rays_shadow += rays_.size();
  for (size_t r = 0; r < rays_.size(); ++r)
    if (blocked_[r]) lights_[of_points_[r]] &= ~bit;
  if (straight_.is_tinted()) pass_glass(bit);
}

// Finds the transmittance of translucent surfaces along the traced rays.
void HostPoints::pass_glass(uint32_t bit) {
  free_.clear();
  of_free_.clear();
  for (size_t r = 0; r < rays_.size(); ++r) {
    if (blocked_[r]) continue;
    free_.push_back(rays_[r]);
    of_free_.push_back(of_points_[r]);
  }
  straight_.follow(free_);
  const auto number = static_cast<size_t>(std::countr_zero(bit));
  for (size_t i = 0; i < free_.size(); ++i) {
    const glm::vec3& through = straight_.through(i);
    if (through == glm::vec3(1.0f)) continue;
    const size_t point = of_free_[i];
    tinted_[point] = 1;
    for (int c = 0; c < 3; ++c)
      tints_[(point * most_numbered_lights + number) * 3 + static_cast<size_t>(c)] = through[c];
  }
}

void HostPoints::describe(const SurfacePoint& p, size_t i, const Kind& kind) {
  const model::Snapshot& snapshot = *scene_->snapshot;
  const model::Instance& instance = snapshot.instances[p.hit.instance];
  const SurfaceAttributes a = surface_attributes(snapshot, p);
  sideray_shading_point& to = points_[i];
  std::memset(&to, 0, sizeof(to));  // clears padding too, so that equal points have equal bytes
  for (int c = 0; c < 3; ++c) to.position[c] = snapshot.origin[c] + double{p.position[c]};
  store(to.to_eye, p.to_eye);
  store(to.geometric_normal, p.geometric_normal);
  store(to.normal, p.surface.normal);
  store(to.tangent, a.tangent);
  store(to.uv0, a.uv[0]);
  store(to.uv1, a.uv[1]);
  store(to.uv0_footprint, glm::vec4(a.footprint[0][0], a.footprint[0][1]));
  store(to.uv1_footprint, glm::vec4(a.footprint[1][0], a.footprint[1][1]));
  store(to.color, a.color);
  store(to.base_color, glm::vec4(p.surface.albedo, p.surface.alpha));
  store(to.emissive, p.surface.emissive);
  to.distance = static_cast<float>(p.hit.distance);
  to.footprint = p.cone.width;
  to.u = p.hit.u;
  to.v = p.hit.v;
  to.primitive = a.primitive;
  to.instance = snapshot.instance_names[p.hit.instance].name;
  to.material = snapshot.material_names[instance.material].name;
  to.surface_id = instance.surface_id;
  to.user = instance.user;
  to.lights = lights_[i];
  if (straight_.is_tinted() && tinted_[i]) to.tints = &tints_[i * most_numbered_lights * 3];
  to.bounce = kind.bounce;
  to.front = p.hit.front;
  to.translucent = kind.translucent;

  const shading::SrBlend blend = shading::sr_blend(p.surface, p.to_eye, p.blend);
  sideray_shading_result& result = results_[i];
  result = {};
  result.alpha = blend.cover;
  store(result.transmittance, blend.through);
  store(result.reflection, mirrored(p));
}

bool HostPoints::is_cancelled() const {
  return calls_.cancelled && calls_.cancelled->load();
}

// Returns false if the shader was not called.
bool HostPoints::call() {
  const sideray_shader_desc& shader = scene_->snapshot->shader;
  const sideray_shading_point* points = host_points_.laid_out(points_, shader.point_stride_bytes);
  sideray_shading_result* results = host_results_.laid_out(results_, shader.result_stride_bytes);
  const auto batch = [&] {
    const FlushDenormals flush;
    shader.shade(shader.user, points, points_.size(), results);
  };
  bool called = !is_cancelled();
  if (called && calls_.queue)
    called = calls_.queue->run(batch, calls_.cancelled);
  else if (called)
    batch();
  if (!called) {
    end = TraceEnd::cancelled;
    return false;
  }
  host_results_.read_back(results_, shader.result_stride_bytes);
  asked += points_.size();
  return true;
}

HostAnswer HostPoints::answer(const SurfacePoint& p, const sideray_shading_result& r) {
  const glm::vec3 zero(0.0f), one(1.0f), reflection = to_vec3(r.reflection);
  const float squared = glm::dot(reflection, reflection);
  if (!is_finite(r) || !(squared > 1e-12f) || !std::isfinite(squared)) {
    ++not_finite;
    return {zero, shading::sr_blend(p.surface, p.to_eye, p.blend), zero, p.geometric_normal};
  }
  return {glm::max(to_vec3(r.radiance), zero),
          {glm::clamp(r.alpha, 0.0f, 1.0f), glm::clamp(to_vec3(r.transmittance), zero, one)},
          glm::max(to_vec3(r.reflectance), zero),
          shading::sr_lifted(reflection * (1.0f / std::sqrt(squared)), p.geometric_normal)};
}

}  // namespace sideray::rt
