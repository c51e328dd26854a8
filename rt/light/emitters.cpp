#include "rt/light/emitters.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <numeric>
#include <utility>

#include "model/material.h"
#include "rt/base/largest.h"
#include "rt/textures/texture_sample.h"

namespace sideray::rt {
namespace {

constexpr uint32_t none = 0xffffffffu;
constexpr uint32_t most_in_leaf = 8, bins = 16;
// A triangle counts as facing a point by at least this cosine at its centre, because other parts may face it more.
constexpr float least_turned = 0.1f;
// The point's own cosine counts as at least this, because its lobes need not be centred on one normal.
constexpr float least_facing = 0.03f;

// Returns the mean colour of a texture; white without a texture.
glm::vec3 mean_color(const model::Snapshot& snapshot, const sideray_texture_slot& slot) {
  if (slot.texture == 0) return glm::vec3(1.0f);
  const model::Texture& texture = *snapshot.textures[slot.texture - 1];
  const model::Texture::Level& level = texture.levels.back();
  const size_t texels = level.rgba.size() / 4;
  glm::vec3 sum(0.0f);
  for (size_t i = 0; i < texels; ++i)
    for (int c = 0; c < 3; ++c) {
      const uint8_t code = level.rgba[4 * i + static_cast<size_t>(c)];
      sum[c] += texture.srgb ? srgb_decode_table()[code] : static_cast<float>(code) / 255.0f;
    }
  // A texture with a black mean may still have bright texels.
  return glm::max(sum / static_cast<float>(std::max<size_t>(texels, 1)), glm::vec3(1e-3f));
}

// Returns an emitter's estimated radiance, by the means of its textures; 0 = it is not sampled.
float brightness(const model::Snapshot& snapshot, const model::Instance& instance) {
  const model::Material& material = snapshot.materials[instance.material];
  const sideray_material_desc& d = material.desc;
  const bool is_covered = d.alpha_mode != SIDERAY_BLEND || (d.base_color[3] > 0.0f && !d.unlit);
  if (material.discards || !is_covered || instance.sprites != 0 || !(instance.visibility & SIDERAY_VISIBLE_REFLECTION))
    return 0.0f;
  const float* shines = d.unlit ? d.base_color : d.emissive;
  const sideray_texture_slot& slot = d.unlit ? d.base_color_texture : d.emissive_texture;
  return largest(glm::vec3(shines[0], shines[1], shines[2]) * mean_color(snapshot, slot));
}

// Returns cos(max(a - b, 0)) from the cosines and sines of both.
float cosine_of_difference(float cosine_a, float sine_a, float cosine_b, float sine_b) {
  return cosine_a > cosine_b ? 1.0f : cosine_a * cosine_b + sine_a * sine_b;
}
float sine_of_difference(float cosine_a, float sine_a, float cosine_b, float sine_b) {
  return cosine_a > cosine_b ? 0.0f : sine_a * cosine_b - cosine_a * sine_b;
}
float other_leg(float x) {
  return std::sqrt(std::max(1.0f - x * x, 0.0f));
}

}  // namespace

struct EmitterSampler::Building {
  std::vector<Triangle> triangles;
  std::vector<uint32_t> order;
};

struct EmitterSampler::Box {
  glm::vec3 low{INFINITY}, high{-INFINITY};
  void add(const Triangle& t) {
    for (const glm::vec3& p : {t.corner, t.corner + t.edge1, t.corner + t.edge2})
      low = glm::min(low, p), high = glm::max(high, p);
  }
};

struct EmitterSampler::Bin {
  Box box;
  double power = 0;
  uint32_t count = 0;
  void add(const Triangle& t) {
    box.add(t);
    power += static_cast<double>(t.power), ++count;
  }
  void merge(const Bin& other) {
    box.low = glm::min(box.low, other.box.low), box.high = glm::max(box.high, other.box.high);
    power += other.power, count += other.count;
  }
  double cost() const {
    if (count == 0) return 0.0;
    const glm::dvec3 s(box.high - box.low);
    return power * glm::dot(s, s);
  }
};

// Returns the number of bins before the cheapest border; 0 if no border has triangles on both sides.
uint32_t EmitterSampler::best_border(std::span<const Bin> binned) {
  double best = INFINITY;
  uint32_t border = 0;
  for (uint32_t i = 1; i < binned.size(); ++i) {
    Bin left, right;
    for (const Bin& bin : binned.first(i)) left.merge(bin);
    for (const Bin& bin : binned.subspan(i)) right.merge(bin);
    if (left.count == 0 || right.count == 0) continue;
    const double sum = left.cost() + right.cost();
    if (sum < best) best = sum, border = i;
  }
  return border;
}

EmitterSampler::EmitterSampler(const model::Snapshot& snapshot) {
  first_.assign(snapshot.instances.size(), none);
  shining_ = shining_in(snapshot);
  for (const Shining& shining : shining_) add(shining);
  Building building{std::move(triangles_), {}};
  triangles_.clear();
  building.order.resize(building.triangles.size());
  std::iota(building.order.begin(), building.order.end(), 0u);
  if (building.order.empty()) return;
  nodes_.push_back({});
  nodes_[0].parent = none;
  build(building, 0, 0, static_cast<uint32_t>(building.order.size()));
}

std::vector<EmitterSampler::Shining> EmitterSampler::shining_in(const model::Snapshot& snapshot) {
  std::vector<Shining> shining;
  for (uint32_t i = 0; i < snapshot.instances.size(); ++i) {
    const model::Instance& instance = snapshot.instances[i];
    const float bright = brightness(snapshot, instance);
    if (!(bright > 0.0f) || !std::isfinite(bright)) continue;
    // A solid's far wall is visible through its near one.
    const model::Material& material = snapshot.materials[instance.material];
    const bool two_sided = !material.cull_back || model::has_volume(material.desc);
    shining.push_back({i, snapshot.meshes[instance.mesh], instance.local_from_object, bright, two_sided, instance.mirrored});
  }
  return shining;
}

void EmitterSampler::add(const Shining& s) {
  const model::Mesh& mesh = *s.mesh;
  first_[s.instance] = static_cast<uint32_t>(of_primitive_.size());
  of_primitive_.resize(of_primitive_.size() + mesh.triangles.size(), none);
  const auto place = [&](uint32_t vertex) {
    return glm::vec3(s.local_from_object * glm::vec4(mesh.positions[vertex], 1.0f));
  };
  for (uint32_t primitive = 0; primitive < mesh.triangles.size(); ++primitive) {
    const glm::uvec3 t = mesh.triangles[primitive];
    const glm::vec3 corner = place(t.x), edge1 = place(t.y) - corner, edge2 = place(t.z) - corner;
    const glm::vec3 across = glm::cross(edge1, edge2);
    const float area2 = glm::length(across), power = 0.5f * area2 * s.brightness;
    if (!(power > 0.0f) || !std::isfinite(power)) continue;
    const glm::vec3 normal = s.mirrored ? -across / area2 : across / area2;
    triangles_.push_back({corner, edge1, edge2, normal, 0.5f * area2, power, s.instance, primitive, 0, s.two_sided});
  }
}

// Makes a node of `count` triangles of the order, and its subtree.
void EmitterSampler::build(Building& b, uint32_t node, uint32_t first, uint32_t count) {
  const std::span<uint32_t> order = std::span(b.order).subspan(first, count);
  bound(nodes_[node], b.triangles, order);
  if (count <= most_in_leaf) return make_leaf(node, b.triangles, order);
  const uint32_t split = split_of(b.triangles, order);
  const auto child = static_cast<uint32_t>(nodes_.size());
  nodes_.resize(nodes_.size() + 2);
  nodes_[node].first = child, nodes_[node].count = 0;
  nodes_[child].parent = nodes_[child + 1].parent = node;
  build(b, child, first, split);
  build(b, child + 1, first + split, count - split);
}

// Sets the node's box, cone, power and sides to those of its triangles.
void EmitterSampler::bound(Node& node, std::span<const Triangle> triangles, std::span<const uint32_t> order) {
  Box box;
  glm::vec3 axis(0.0f);
  double power = 0;
  bool two_sided = false;
  for (const uint32_t index : order) {
    const Triangle& t = triangles[index];
    box.add(t);
    axis += t.normal * t.power;
    power += static_cast<double>(t.power);
    two_sided |= t.two_sided;
  }
  const float length = glm::length(axis);
  axis = length > 0.0f ? axis / length : glm::vec3(0, 1, 0);
  float cosine = 1.0f;
  for (const uint32_t index : order) cosine = std::min(cosine, glm::dot(axis, triangles[index].normal));
  node.center = 0.5f * (box.low + box.high), node.half = 0.5f * (box.high - box.low);
  node.axis = axis, node.cosine = std::max(cosine - 1e-5f, -1.0f);
  node.power = static_cast<float>(power), node.two_sided = two_sided;
}

void EmitterSampler::make_leaf(uint32_t node, std::span<const Triangle> triangles, std::span<const uint32_t> order) {
  nodes_[node].first = static_cast<uint32_t>(triangles_.size());
  nodes_[node].count = static_cast<uint32_t>(order.size());
  for (const uint32_t index : order) {
    triangles_.push_back(triangles[index]);
    Triangle& t = triangles_.back();
    t.node = node;
    of_primitive_[first_[t.instance] + t.primitive] = static_cast<uint32_t>(triangles_.size() - 1);
  }
}

// Orders triangles along the longest axis of their middles, and returns how many belong to the first half: it splits
// between bins where the sum of the halves' power times size is smallest, or else in the middle.
uint32_t EmitterSampler::split_of(std::span<const Triangle> triangles, std::span<uint32_t> order) {
  const auto middle = [&](uint32_t index) {
    const Triangle& t = triangles[index];
    return t.corner + (t.edge1 + t.edge2) * (1.0f / 3.0f);
  };
  glm::vec3 low(INFINITY), high(-INFINITY);
  for (const uint32_t index : order) low = glm::min(low, middle(index)), high = glm::max(high, middle(index));
  const glm::vec3 size = high - low;
  const int along = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const auto half = static_cast<uint32_t>(order.size() / 2);
  if (!(size[along] > 0.0f)) return half;
  const auto bin_of = [&](uint32_t index) {
    const float at = (middle(index)[along] - low[along]) / size[along];
    return std::min(static_cast<uint32_t>(at * static_cast<float>(bins)), bins - 1);
  };
  std::array<Bin, bins> binned;
  for (const uint32_t index : order) binned[bin_of(index)].add(triangles[index]);
  if (const uint32_t border = best_border(binned)) {
    const auto is_first = [&](uint32_t index) { return bin_of(index) < border; };
    return static_cast<uint32_t>(std::stable_partition(order.begin(), order.end(), is_first) - order.begin());
  }
  std::ranges::stable_sort(order, [&](uint32_t x, uint32_t y) { return middle(x)[along] < middle(y)[along]; });
  return half;
}

// Bounds the light that a point may receive from any triangle of the node.
float EmitterSampler::importance(const Node& n, const LitPoint& p) const {
  const glm::vec3 away = p.position - n.center;
  const float square = glm::dot(away, away), radius2 = glm::dot(n.half, n.half);
  float turned = 1.0f, facing = 1.0f;
  if (square > radius2) {
    const glm::vec3 w = away * (1.0f / std::sqrt(square));
    const float sine2 = radius2 / square, sine_box = std::sqrt(sine2), cosine_box = std::sqrt(1.0f - sine2);
    float cosine = glm::dot(n.axis, w);
    if (n.two_sided) cosine = std::abs(cosine);
    const float sine = other_leg(cosine), sine_cone = other_leg(n.cosine);
    const float c = cosine_of_difference(cosine, sine, n.cosine, sine_cone);
    const float s = sine_of_difference(cosine, sine, n.cosine, sine_cone);
    turned = cosine_of_difference(c, s, cosine_box, sine_box);
    if (turned <= 0.0f) {
      if (!n.two_sided) return 0.0f;
      turned = 0.0f;
    }
    turned = std::max(turned, least_turned);
    float cosine_point = -glm::dot(p.normal, w);
    if (p.from_behind) cosine_point = std::abs(cosine_point);
    facing = cosine_of_difference(cosine_point, other_leg(cosine_point), cosine_box, sine_box);
    facing = std::max(facing, least_facing);
  }
  return n.power * turned * facing / std::max(square, radius2);
}

float EmitterSampler::importance(const Triangle& t, const LitPoint& p) const {
  const glm::vec3 away = p.position - (t.corner + (t.edge1 + t.edge2) * (1.0f / 3.0f));
  if (!t.two_sided && glm::dot(t.normal, p.position - t.corner) <= 0.0f) return 0.0f;
  const float square = glm::dot(away, away), inverse = square > 0.0f ? 1.0f / std::sqrt(square) : 0.0f;
  const float turned = std::max(std::abs(glm::dot(t.normal, away)) * inverse, least_turned);
  float facing = -glm::dot(p.normal, away) * inverse;
  if (p.from_behind) facing = std::abs(facing);
  return t.power * turned * std::max(facing, least_facing) / std::max(square, 0.5f * t.area);
}

// Returns the probability of choosing the triangle.
float EmitterSampler::chance(uint32_t index, const LitPoint& p) const {
  const float own = importance(triangles_[index], p);
  if (!(own > 0.0f)) return 0.0f;
  uint32_t node = triangles_[index].node;
  float sum = 0.0f;
  for (uint32_t k = nodes_[node].first; k < nodes_[node].first + nodes_[node].count; ++k)
    sum += importance(triangles_[k], p);
  float chance = own / sum;
  for (; nodes_[node].parent != none; node = nodes_[node].parent) {
    const uint32_t first = nodes_[nodes_[node].parent].first;
    const float a = importance(nodes_[first], p), b = importance(nodes_[first + 1], p);
    if (!(a + b > 0.0f)) return 0.0f;
    chance *= (node == first ? a : b) / (a + b);
  }
  return chance;
}

float EmitterSampler::density(uint32_t index, float chance, glm::vec3 direction, float distance) const {
  const Triangle& t = triangles_[index];
  const float cosine = std::abs(glm::dot(t.normal, direction));
  return cosine > 0.0f ? chance / t.area * distance * distance / cosine : 0.0f;
}

EmitterSampler::Sample EmitterSampler::sample(const LitPoint& p, float choice, glm::vec2 u) const {
  Sample s{};
  uint32_t node = 0;
  float chance = 1.0f;
  // The rest of `choice` is rescaled to a uniform number.
  const auto takes_first = [&](float a, float b) {
    const float share = a / (a + b);
    const bool first = choice < share;
    choice = std::min(first ? choice / share : (choice - share) / (1.0f - share), 0x1.fffffep-1f);
    chance *= first ? share : 1.0f - share;
    return first;
  };
  while (nodes_[node].count == 0) {
    const uint32_t first = nodes_[node].first;
    const float a = importance(nodes_[first], p), b = importance(nodes_[first + 1], p);
    if (!(a + b > 0.0f)) return s;
    node = takes_first(a, b) ? first : first + 1;
  }
  const Node& leaf = nodes_[node];
  float weights[most_in_leaf], sum = 0.0f;
  for (uint32_t k = 0; k < leaf.count; ++k) sum += weights[k] = importance(triangles_[leaf.first + k], p);
  if (!(sum > 0.0f)) return s;
  float left = choice * sum;
  uint32_t k = 0, last = 0;
  for (; k < leaf.count; ++k) {
    if (!(weights[k] > 0.0f)) continue;
    last = k;
    if (left < weights[k]) break;
    left -= weights[k];
  }
  const uint32_t index = leaf.first + last;
  const Triangle& t = triangles_[index];
  chance *= weights[last] / sum;
  // Uniform on the triangle (Osada et al. 2002).
  const float root = std::sqrt(u.x), second = root * (1.0f - u.y), third = root * u.y;
  const glm::vec3 way = t.corner + t.edge1 * second + t.edge2 * third - p.position;
  const float distance = glm::length(way);
  if (!(distance > 0.0f)) return s;
  s.ray = {p.position, 0.0f, way / distance, distance};
  s.hit = {static_cast<double>(distance), second, third, t.instance, t.primitive, glm::dot(t.normal, way) < 0.0f};
  s.density = density(index, chance, s.ray.direction, distance);
  return s;
}

bool EmitterSampler::samples(const Hit& hit) const {
  if (hit.instance >= first_.size() || first_[hit.instance] == none) return false;
  const uint32_t index = of_primitive_[first_[hit.instance] + hit.primitive];
  return index != none && (hit.front || triangles_[index].two_sided);
}

float EmitterSampler::density(const LitPoint& p, const Hit& hit, glm::vec3 direction) const {
  if (!samples(hit)) return 0.0f;
  const uint32_t index = of_primitive_[first_[hit.instance] + hit.primitive];
  return density(index, chance(index, p), direction, static_cast<float>(hit.distance));
}

}  // namespace sideray::rt
