#include "rt/light/light_around.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "rt/base/largest.h"
#include "rt/base/sampling.h"

namespace sideray::rt {
namespace {

constexpr float cell_width = 2.0f;  // side of the smallest cells, in widths of a pixel
constexpr float least_reach = 4.0f;  // smallest radius of sharing, in widths of a pixel
constexpr float share_of_distance = 0.5f;
constexpr size_t points_a_path = 4, few_cells = 64;
constexpr int most_coarser = 10, least_level = -200;
constexpr uint32_t path_purpose = 72;
constexpr float blur_of_sky = 0.25f;  // roughness of the lobe that averages a direction's light
constexpr float facing_steps = 2.0f;  // steps of a normal's coordinate from 0 to 1
constexpr float least_likeness = 0.8f;  // smallest cosine between normals of surfaces that share light
constexpr float off_plane = 4.0f;       // a distance from the plane counts this many times

int level_of(const PointAround& p) {
  // Distant points have fewer digits.
  const float side = std::max({p.width * cell_width, largest(glm::abs(p.origin)) * 0x1p-18f, 0x1p-100f});
  int level = 0;
  std::frexp(side, &level);
  return level;
}

float likeness(glm::vec3 a, glm::vec3 b) {
  return std::max((glm::dot(a, b) - least_likeness) * (1.0f / (1.0f - least_likeness)), 0.0f);
}

// Returns part / whole by channel; 1 if the whole is 0.
glm::vec3 share_of(glm::vec3 part, glm::vec3 whole) {
  glm::vec3 share(1.0f);
  for (int c = 0; c < 3; ++c)
    if (whole[c] > 0.0f) share[c] = std::min(part[c] / whole[c], 1.0f);
  return share;
}

}  // namespace

void LightAround::begin(const ShadingScene& scene, const Intersector& intersector, bool shadows) {
  const model::Environment& environment = *scene.snapshot->environment;
  environment_ = environment.black ? nullptr : &environment;
  lanes_ = {environment, shade_kernels(intersector.isa().c_str())};
  scene_ = &scene;
  intersector_ = &intersector;
  veiled_ = environment_ && veils_sky(*scene.snapshot);
  rays_to_veils_ = 0;
  paths_.begin(scene, intersector, shadows, nullptr);
}

void LightAround::gather(const SurfaceBatch& batch, bool matt) {
  points_.clear();
  for (uint32_t i = 0; i < batch.size(); ++i)
    if (!matt || batch.is_matt(i)) points_.push_back({batch.point_around(i), i, {}, 0});
}

// Sorts the points by cells of a common size; returns the number of cells.
size_t LightAround::sort_into_cells(int coarser) {
  int level = least_level;
  for (const Point& p : points_) level = std::max(level, level_of(p.around));
  for (Point& p : points_) {
    p.cell.place = glm::i64vec3(glm::floor(glm::dvec3(p.around.origin) * std::ldexp(1.0, -(level + coarser))));
    p.cell.facing = glm::i8vec3(glm::round(p.around.normal * facing_steps));
  }
  const auto order = [](const Point& p) {
    const Cell& c = p.cell;
    return std::tie(c.place.x, c.place.y, c.place.z, c.facing.x, c.facing.y, c.facing.z, p.number);
  };
  std::sort(points_.begin(), points_.end(), [&](const Point& a, const Point& b) { return order(a) < order(b); });
  size_t cells = 1;
  for (size_t i = 1; i < points_.size(); ++i) cells += points_[i].cell == points_[i - 1].cell ? 0 : 1;
  return cells;
}

// Lets one point of each cell send a path, or more if there are few cells, so that isolated points have one too.
void LightAround::choose_senders() {
  const size_t wanted = std::max(points_.size() / points_a_path, few_cells);
  for (int coarser = 0; sort_into_cells(coarser) > wanted && coarser < most_coarser;) ++coarser;
  records_.clear();
  for (size_t first = 0, end = 0; first < points_.size(); first = end) {
    end = first + 1;
    while (end < points_.size() && points_[end].cell == points_[first].cell) ++end;
    const size_t sent = (end - first + points_a_path - 1) / points_a_path;
    const size_t count = end - first;
    for (size_t i = 0; i < count; ++i)
      points_[first + i].record = static_cast<uint32_t>(records_.size() + i * sent / count);
    for (size_t i = 0; i < sent; ++i) {
      const PointAround& p = points_[first + i * count / sent].around;
      records_.push_back({p.origin, p.normal, p.width, 0.0f, 0.0f, {}, {}, {}});
      keys_.push_back(random_key({p.key, path_purpose}));
    }
  }
}

// Consecutive records are near each other, so their directions come from one low-discrepancy sequence (Roberts 2018,
// R2), with a random start.
void LightAround::send_paths() {
  constexpr uint32_t step_x = 3242174889u, step_y = 2447445414u;
  rays_.clear(), cones_.clear();
  uint32_t x = keys_[0], y = hash_bits(x);
  for (size_t i = 0; i < records_.size(); ++i) {
    const Record& r = records_[i];
    const glm::vec2 u(unit_float(x += step_x), unit_float(y += step_y));
    rays_.push_back({r.position, 0.0f, frame_about(r.normal) * sample_cosine(u), farthest});
    cones_.push_back({r.width, 0.0f});
  }
  radiance_.resize(rays_.size());
  nearness_.resize(rays_.size());
  paths_.follow(rays_, cones_, keys_, radiance_.data(), nearness_.data());
  for (size_t i = 0; i < records_.size(); ++i) {
    Record& r = records_[i];
    r.nearness = nearness_[i];
    r.thrown = radiance_[i];
  }
  if (environment_) see_sky();
}

// Finds the visible sky in each path's first direction, through translucent surfaces.
void LightAround::see_sky() {
  clear_.clear(), of_clear_.clear(), directions_.clear();
  for (const Ray& ray : rays_) directions_.push_back(ray.direction);
  sky_.resize(directions_.size());
  lanes_.specular(directions_, blur_of_sky, sky_.data());
  for (uint32_t i = 0; i < records_.size(); ++i) {
    records_[i].sky = sky_[i];
    if (nearness_[i] > 0.0f) continue;
    records_[i].seen_sky = records_[i].sky;
    clear_.push_back(rays_[i]);
    of_clear_.push_back(i);
  }
  if (!veiled_ || clear_.empty()) return;
  veils_.meet(*scene_, *intersector_, clear_, false);
  rays_to_veils_ += clear_.size();
  for (size_t k = 0; k < clear_.size(); ++k) records_[of_clear_[k]].seen_sky *= veils_.color(k);
}

// A single path's distance is noisy, so nearby paths are averaged.
void LightAround::find_reaches() {
  for (Record& r : records_) {
    const float blur = r.width * cell_width;
    float sum = 0.0f, weights = 0.0f;
    for (const Record& other : records_) {
      const glm::vec3 apart = other.position - r.position;
      const float weight = likeness(r.normal, other.normal) / (glm::dot(apart, apart) + blur * blur);
      sum += weight * other.nearness;
      weights += weight;
    }
    r.reach = std::max(share_of_distance * weights / std::max(sum, 1e-20f), least_reach * r.width);
  }
}

// For the sky, averages the visible share of the light in the paths' directions: it is exactly one if nothing occludes.
ArrivingLight LightAround::mean_about(const Record& at) const {
  glm::vec3 thrown(0.0f), sky(0.0f), seen_sky(0.0f);
  float weights = 0.0f;
  for (const Record& r : records_) {
    const float alike = likeness(at.normal, r.normal);
    if (!(alike > 0.0f)) continue;
    const glm::vec3 apart = r.position - at.position;
    const float across = glm::dot(apart, at.normal) * off_plane, off2 = glm::dot(apart, apart) + across * across;
    if (!(off2 < r.reach * r.reach)) continue;
    const float weight = (1.0f - std::sqrt(off2) / r.reach) * alike;
    thrown += r.thrown * weight;
    sky += r.sky * weight;
    seen_sky += r.seen_sky * weight;
    weights += weight;
  }
  if (!(weights > 0.0f)) return {at.thrown, share_of(at.seen_sky, at.sky)};
  return {thrown * (1.0f / weights), share_of(seen_sky, sky)};
}

std::span<const ArrivingLight> LightAround::find(const SurfaceBatch& batch, bool matt) {
  arriving_.assign(batch.size(), {});
  gather(batch, matt);
  if (points_.empty()) return arriving_;
  keys_.clear();
  choose_senders();
  send_paths();
  find_reaches();
  means_.clear();
  for (const Record& r : records_) means_.push_back(mean_about(r));
  for (const Point& p : points_) arriving_[p.number] = means_[p.record];
  return arriving_;
}

}  // namespace sideray::rt
