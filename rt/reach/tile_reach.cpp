#include "rt/reach/tile_reach.h"

#include <algorithm>
#include <cmath>

#include "rt/base/view_rays.h"

namespace sideray::rt {
namespace {

// Is an interval of a ray, in lengths of its direction.
struct Part {
  float from, to;
  bool empty() const { return !(from <= to); }
};

float largest_of(glm::vec3 v) {
  return std::max(std::max(v.x, v.y), v.z);
}

// Returns the part of a line q + t v within a cube around 0; `inverse` is 1 / v.
Part within(glm::vec3 q, glm::vec3 inverse, float half, Part whole) {
  const glm::vec3 a = (-half - q) * inverse, b = (half - q) * inverse;
  const glm::vec3 enters = glm::min(a, b), leaves = -glm::max(a, b);
  return {std::max(whole.from, largest_of(enters)), std::min(whole.to, -largest_of(leaves))};
}

// Marks the cells along a part of a line, in a cube with `side` cells a side and `per_unit` cells per unit of q. It
// takes one sample for each cell that the line advances along its longest axis, so that on every axis the line is
// within half a cell of a sample.
template <int side, typename Row>
void walk(Row* rows, glm::vec3 q, glm::vec3 v, float per_unit, Part part) {
  constexpr float middle = 0.5f * static_cast<float>(side);
  // Fixed point is safe: between two points inside the cube, the whole line is inside.
  constexpr int bits = 16;
  constexpr float one = 1 << bits, last = static_cast<float>((side << bits) - 64);
  const glm::ivec3 start(glm::clamp(((q + v * part.from) * per_unit + middle) * one, 0.0f, last));
  const glm::ivec3 end(glm::clamp(((q + v * part.to) * per_unit + middle) * one, 0.0f, last));
  const glm::ivec3 way = end - start;
  const int steps = (std::max(std::max(std::abs(way.x), std::abs(way.y)), std::abs(way.z)) >> bits) + 1;
  const float share = 1.0f / static_cast<float>(steps);
  const glm::ivec3 step(glm::vec3(way) * share);
  int x = start.x, y = start.y, z = start.z;
  const auto mark = [&] { rows[(z >> bits) * side + (y >> bits)] |= static_cast<Row>(Row{1} << (x >> bits)); };
  for (int i = 0; i < steps; ++i, x += step.x, y += step.y, z += step.z) mark();
  x = end.x, y = end.y, z = end.z;
  mark();
}

// Returns whether any cell is marked in a box that is widened by half a cell.
template <int side, typename Row>
bool is_marked(const Row* rows, float per_unit, glm::vec3 low, glm::vec3 high) {
  constexpr float middle = 0.5f * static_cast<float>(side), around = 0.51f;
  const auto cell = [](float x) { return static_cast<int>(std::clamp(x, 0.0f, static_cast<float>(side - 1))); };
  low = low * per_unit + (middle - around);
  high = high * per_unit + (middle + around);
  const uint32_t row = (~0u << cell(low.x)) & (~0u >> (31 - cell(high.x)));
  for (int z = cell(low.z); z <= cell(high.z); ++z)
    for (int y = cell(low.y); y <= cell(high.y); ++y)
      if (rows[z * side + y] & row) return true;
  return false;
}

}  // namespace

void RayCells::add(const ReachCube& cube, const Ray& ray, float from, float to) {
  constexpr float least = 1e-20f;
  const float scale = 1.0f / cube.half;
  const glm::vec3 q = (ray.origin - cube.middle) * scale, v = ray.direction * scale;
  const Part whole{from, to};
  if (whole.empty()) return;
  glm::vec3 inverse;
  for (int i = 0; i < 3; ++i) inverse[i] = 1.0f / (std::abs(v[i]) < least ? least : v[i]);
  const Part far = within(q, inverse, outer_half, whole);
  beyond_ = beyond_ || far.empty() || far.from > from || far.to < to;
  if (far.empty()) return;
  constexpr float inner_cells = 0.5f * inner_side, outer_cells = 0.5f * outer_side / outer_half;
  const Part near = within(q, inverse, 1.0f, far);
  const auto walk_outer = [&](Part part) {
    if (!part.empty()) walk<outer_side>(outer_.data(), q, v, outer_cells, part);
  };
  if (near.empty()) return walk_outer(far);
  walk<inner_side>(inner_.data(), q, v, inner_cells, near);
  if (near.from > far.from) walk_outer({far.from, near.from});
  if (near.to < far.to) walk_outer({near.to, far.to});
}

void RayCells::add(const RayCells& other) {
  for (size_t i = 0; i < inner_.size(); ++i) inner_[i] |= other.inner_[i];
  for (size_t i = 0; i < outer_.size(); ++i) outer_[i] |= other.outer_[i];
  beyond_ = beyond_ || other.beyond_;
}

bool RayCells::meets(const ReachCube& cube, const model::Bounds& box) const {
  if (box.empty()) return false;
  const glm::vec3 low = (box.minimum - cube.middle) / cube.half, high = (box.maximum - cube.middle) / cube.half;
  const float farthest_out = std::max(largest_of(-low), largest_of(high));
  if (!(farthest_out <= outer_half) && beyond_) return true;
  constexpr float inner_cells = 0.5f * inner_side, outer_cells = 0.5f * outer_side / outer_half;
  constexpr float inner_around = 1.0f + 1.0f / inner_side;  // rays are sampled to within half a cell
  const bool is_near = largest_of(low) <= inner_around && largest_of(-high) <= inner_around;
  if (is_near && is_marked<inner_side>(inner_.data(), inner_cells, low, high)) return true;
  return farthest_out > 1.0f && is_marked<outer_side>(outer_.data(), outer_cells, low, high);
}

// Fits the inner cube to the depths without outliers: surfaces in few pixels (the far end of the ground) may lie
// outside.
void TileReach::fit(const TraceView& view, uint32_t width, uint32_t height, const DepthImage& depth) {
  if (is_fit_ || !depth.texels) return;
  is_fit_ = true;
  constexpr uint32_t across = 64;
  constexpr size_t share = 50;  // of the samples, as many are left out at either end
  constexpr float margin = 1.2f;
  const ViewRays rays(view, width, height);
  std::array<std::vector<float>, 3> seen;
  for (uint32_t y = 0; y < height; y += std::max(height / across, 1u))
    for (uint32_t x = 0; x < width; x += std::max(width / across, 1u)) {
      const double stored = read_depth(depth, x, y).depth;
      const bool nothing = view.reversed_depth ? stored <= 0.0 : stored >= 1.0;
      if (nothing) continue;
      const Ray ray = rays.ray(x, y);
      const glm::vec3 p = ray.origin + ray.direction * static_cast<float>(rays.distance(x, y, stored));
      for (int i = 0; i < 3; ++i)
        if (std::isfinite(p[i])) seen[static_cast<size_t>(i)].push_back(p[i]);
    }
  glm::vec3 low(0.0f), high(0.0f);
  for (int i = 0; i < 3; ++i) {
    std::vector<float>& values = seen[static_cast<size_t>(i)];
    if (values.empty()) return;
    std::sort(values.begin(), values.end());
    low[i] = values[values.size() / share];
    high[i] = values[values.size() - 1 - values.size() / share];
  }
  const float half = 0.5f * margin * largest_of(high - low);
  if (half > 0.0f) cube_ = {0.5f * (low + high), half};
}

bool TileReach::meets(const Cells& cells, size_t tile, const model::Bounds& box) const {
  return cells[tile] && cells[tile]->meets(cube_, box);
}

bool TileReach::meets_occluders(size_t tile, const model::Bounds& box) const {
  return meets(masks_, tile, box);
}

bool TileReach::meets_mirrored(size_t tile, const model::Bounds& box) const {
  return meets(mirrored_, tile, box);
}

bool TileReach::meets_sprites(size_t tile, const model::Bounds& box) const {
  return meets(sprites_, tile, box);
}

constinit thread_local Following* Following::now_ = nullptr;

Following::Following(TileReach* reach, Rays rays) : reach_(reach), rays_(rays) {
  now_ = reach ? this : nullptr;
}

Following::~Following() {
  now_ = nullptr;
}

void Following::add_to(size_t tile) {
  if (!any_ && !any_sprites_) return;
  const std::lock_guard lock(reach_->mutex_);
  const auto add = [&](TileReach::Cells& to, const RayCells& cells) {
    if (!to[tile]) to[tile] = std::make_unique<RayCells>();
    to[tile]->add(cells);
  };
  if (any_) add(rays_ == Rays::of_masks ? reach_->masks_ : reach_->mirrored_, cells_);
  if (any_sprites_) add(reach_->sprites_, sprites_);
}

void Following::follow(std::span<const Ray> rays, bool meet_sprites) {
  if (rays_ != Rays::of_layers) {
    any_ = any_ || !rays.empty();
    for (const Ray& ray : rays) cells_.add(reach_->cube_, ray, ray.t_near, ray.t_far);
  }
  if (!meet_sprites) return;
  any_sprites_ = any_sprites_ || !rays.empty();
  for (const Ray& ray : rays) sprites_.add(reach_->cube_, ray, ray.t_near, ray.t_far);
}

void Following::follow(const RayColumns& rays) {
  if (rays_ == Rays::of_layers) return;
  any_ = any_ || rays.count > 0;
  for (size_t i = 0; i < rays.count; ++i) {
    const Ray ray = rays[i];
    cells_.add(reach_->cube_, ray, ray.t_near, ray.t_far);
  }
}

void Following::follow(std::span<const Ray> rays, const Hit* hits) {
  if (rays_ == Rays::of_layers) return;
  any_ = any_ || !rays.empty();
  for (size_t i = 0; i < rays.size(); ++i)
    cells_.add(reach_->cube_, rays[i], rays[i].t_near, std::min(rays[i].t_far, static_cast<float>(hits[i].distance)));
}

}  // namespace sideray::rt
