#include "rt/light/light_around.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "rt/base/largest.h"
#include "rt/base/sampling.h"

namespace sideray::rt {
namespace {

constexpr float cell_width = 2.0f;  // side of the smallest cells, in widths of a pixel
constexpr float least_reach = 4.0f;  // smallest radius of sharing, in widths of a pixel
constexpr float share_of_distance = 0.5f;
constexpr float points_a_path = 8.0f;
constexpr size_t few_cells = 4;
constexpr int most_coarser = 10, least_level = -200;
constexpr int coarser_by_facing = 2;  // cells that were doubled more often hold surfaces that face any way
constexpr uint32_t path_purpose = 72;
constexpr float blur_of_sky = 0.25f;  // roughness of the lobe that a direction's light is averaged over
constexpr int facing_steps = 2;         // steps of a normal's coordinate from 0 to 1
constexpr float least_likeness = 0.8f;  // cosine between normals of surfaces that may be lit alike
constexpr float off_plane = 4.0f;       // a distance off the plane counts as so many times longer

// A cell's name holds its orientation and its position, with so many bits a coordinate.
constexpr int place_bits = 18;
constexpr uint32_t place_mask = (1u << place_bits) - 1u;

int level_of(const PointAround& p) {
  // Cells far from the origin are larger, so that place_bits suffice.
  const float side =
      std::max({p.width * cell_width, largest(glm::abs(p.origin)) * std::ldexp(2.0f, -place_bits), 0x1p-100f});
  int level = 0;
  std::frexp(side, &level);
  return level;
}

uint64_t cell_of(const PointAround& p, int level) {
  const glm::i64vec3 place(glm::floor(glm::dvec3(p.origin) * std::ldexp(1.0, -level)));
  const glm::ivec3 facing(glm::round(p.normal * static_cast<float>(facing_steps)));
  uint64_t name = 0;
  for (int k = 0; k < 3; ++k) name = name * (2 * facing_steps + 1) + static_cast<uint64_t>(facing[k] + facing_steps);
  for (int k = 0; k < 3; ++k) name = name << place_bits | (static_cast<uint64_t>(place[k]) & place_mask);
  return name;
}

uint64_t facing_any_way(uint64_t cell) {
  return cell & ((uint64_t{1} << 3 * place_bits) - 1);
}

// Returns the cell of twice the side that contains this one.
uint64_t coarser_cell(uint64_t cell) {
  constexpr int above_place = 32 - place_bits;
  uint64_t name = cell >> 3 * place_bits << 3 * place_bits;
  for (int shift = 0; shift < 3 * place_bits; shift += place_bits) {
    const auto place = static_cast<int32_t>(static_cast<uint32_t>(cell >> shift) << above_place) >> above_place;
    name |= static_cast<uint64_t>(static_cast<uint32_t>(place >> 1) & place_mask) << shift;
  }
  return name;
}

uint32_t key_of_cell(uint64_t cell, uint32_t of_cell) {
  return random_key({static_cast<uint32_t>(cell), static_cast<uint32_t>(cell >> 32), of_cell, path_purpose});
}

// Returns the two numbers that a path's direction is sampled by. Those of neighbouring cells, and those of successive
// positions in one cell, fill the square evenly (Roberts 2018, "The Unreasonable Effectiveness of Quasirandom
// Sequences": R6 over space, R2 over positions).
glm::vec2 direction_numbers(uint64_t cell, uint32_t of_cell, uint32_t position) {
  constexpr glm::uvec2 steps[] = {{3859688306u, 3468523226u}, {3117001274u, 2801104767u}, {2517223199u, 2262111973u}};
  constexpr glm::uvec2 position_step(3242174889u, 2447445414u);
  const uint32_t key = random_key({static_cast<uint32_t>(cell >> 3 * place_bits), of_cell, path_purpose});
  glm::uvec2 bits = glm::uvec2(key, hash_bits(key)) + position * position_step;
  for (int k = 0; k < 3; ++k) bits += (static_cast<uint32_t>(cell >> k * place_bits) & place_mask) * steps[k];
  return {unit_float(bits.x), unit_float(bits.y)};
}

void drop_doubles(std::vector<uint64_t>& cells) {
  std::ranges::sort(cells);
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
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

void LightAround::begin(const ShadingScene& scene, const Intersector& intersector, bool shadows, uint32_t position,
                        const SeenLight* seen) {
  const model::Environment& environment = *scene.snapshot->environment;
  environment_ = environment.black ? nullptr : &environment;
  lanes_ = {environment, shade_kernels(intersector.isa().c_str())};
  position_ = position;
  scene_ = &scene;
  seen_ = seen;
  intersector_ = &intersector;
  veiled_ = environment_ && veils_sky(*scene.snapshot);
  rays_to_veils_ = 0;
  paths_.begin(scene, intersector, shadows, nullptr);
}

void LightAround::gather(const SurfaceBatch& batch, bool matt) {
  points_.clear(), own_cells_.clear();
  for (uint32_t i = 0; i < batch.size(); ++i) {
    if (matt && !batch.is_matt(i)) continue;
    const PointAround around = batch.point_around(i);
    if (const std::optional<ArrivingLight> light = seen_ ? seen_->at(around) : std::nullopt) {
      arriving_[i] = *light;
      continue;
    }
    own_cells_.push_back({cell_of(around, level_of(around)), 0, static_cast<uint32_t>(points_.size())});
    points_.push_back({.around = around, .number = i});
  }
}

// Makes each point's random numbers those of the smallest cell about it, so that the light there does not flicker where
// the camera moves. Points that share a cell are numbered.
void LightAround::draw_numbers() {
  std::ranges::sort(own_cells_);
  uint32_t of_cell = 0;
  for (size_t i = 0; i < own_cells_.size(); ++i) {
    const uint64_t cell = own_cells_[i].cell;
    of_cell = i > 0 && own_cells_[i - 1].cell == cell ? of_cell + 1 : 0;
    Point& p = points_[own_cells_[i].point];
    p.key = key_of_cell(cell, of_cell);
    p.direction = direction_numbers(cell, of_cell, position_);
  }
}

// Sorts the points by cells of one size, which is doubled until there are at most `most_cells`.
void LightAround::sort_into_cells(size_t most_cells) {
  int level = least_level;
  for (const Point& p : points_) level = std::max(level, level_of(p.around));
  in_cells_.clear(), cells_.clear();
  for (uint32_t i = 0; i < points_.size(); ++i)
    in_cells_.push_back({cell_of(points_[i].around, level), points_[i].key, i});
  for (const InCell& p : in_cells_) cells_.push_back(p.cell);
  drop_doubles(cells_);
  for (int coarser = 0; cells_.size() > most_cells && coarser < most_coarser; ++coarser) {
    const auto grow = [&](uint64_t& cell) {
      cell = coarser_cell(cell);
      if (coarser >= coarser_by_facing) cell = facing_any_way(cell);
    };
    for (uint64_t& cell : cells_) grow(cell);
    for (InCell& p : in_cells_) grow(p.cell);
    drop_doubles(cells_);
  }
  std::ranges::sort(in_cells_);
}

// Chooses one point of each cell to send a path, or more if they weigh much, so that isolated points have a path, too.
// Those with the least keys send: where cells of another size are chosen in the next frame, most still do.
void LightAround::choose_senders() {
  float weights = 0.0f;
  for (const Point& p : points_) weights += p.around.weight;
  sort_into_cells(std::max(static_cast<size_t>(weights / points_a_path), few_cells));
  records_.clear(), rays_.clear(), normals_.clear(), widths_.clear(), keys_.clear();
  const std::span<const InCell> all(in_cells_);
  for (size_t first = 0, end = 0; first < all.size(); first = end) {
    while (end < all.size() && all[end].cell == all[first].cell) ++end;
    choose_senders(all.subspan(first, end - first));
  }
}

void LightAround::choose_senders(std::span<const InCell> points) {
  const float weights = std::accumulate(points.begin(), points.end(), 0.0f, [&](float sum, const InCell& p) {
    return sum + points_[p.point].around.weight;
  });
  const size_t count = points.size(), sent = std::clamp<size_t>(static_cast<size_t>(weights / points_a_path), 1, count);
  for (size_t i = 0; i < count; ++i)
    points_[points[i].point].record = static_cast<uint32_t>(records_.size() + i * sent / count);
  for (size_t i = 0; i < sent; ++i) send_path(points_[points[i].point]);
}

void LightAround::send_path(const Point& point) {
  const PointAround& p = point.around;
  records_.push_back({.position = p.origin, .normal = p.normal, .width = p.width});
  rays_.push_back({p.origin, 0.0f, frame_about(p.normal) * sample_cosine(point.direction), farthest});
  normals_.push_back(p.normal);
  widths_.push_back(p.width);
  keys_.push_back(random_key({point.key, position_}));
}

void LightAround::follow_paths() {
  light_.resize(rays_.size());
  paths_.follow({rays_, normals_, widths_, keys_}, light_.data());
  for (size_t i = 0; i < records_.size(); ++i) {
    Record& r = records_[i];
    r.nearness = light_[i].nearness + light_[i].emitter_nearness;
    r.thrown = light_[i].radiance;
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
    if (light_[i].nearness > 0.0f) continue;
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

// The nearer surface of two points decides: the bright floor around would else brighten that below an object. For the
// sky, averages the visible share of the light in the paths' directions: it is exactly one if nothing occludes.
ArrivingLight LightAround::mean_about(const Record& at) const {
  glm::vec3 thrown(0.0f), sky(0.0f), seen_sky(0.0f);
  float weights = 0.0f;
  for (const Record& r : records_) {
    const float alike = likeness(at.normal, r.normal);
    if (!(alike > 0.0f)) continue;
    const glm::vec3 apart = r.position - at.position;
    const float across = glm::dot(apart, at.normal) * off_plane, off2 = glm::dot(apart, apart) + across * across;
    const float reach = std::min(r.reach, at.reach);
    if (!(off2 < reach * reach)) continue;
    const float weight = (1.0f - std::sqrt(off2) / reach) * alike;
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
  draw_numbers();
  choose_senders();
  follow_paths();
  find_reaches();
  means_.clear();
  for (const Record& r : records_) means_.push_back(mean_about(r));
  for (const Point& p : points_) arriving_[p.number] = means_[p.record];
  return arriving_;
}

}  // namespace sideray::rt
