#include "rt/cache/one_by_one_filter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace sideray::rt {
namespace {

using Place = LayerFilter::Place;
using Layer = LayerFilter::Layer;

constexpr uint32_t none = 0xffffffffu;
constexpr int passes = 4;
constexpr float least_reach_px = 0.5f;

float largest(glm::vec4 v) {
  return std::max({v.x, v.y, v.z});
}

float alpha(float roughness) {
  return roughness * roughness;
}

float samples_averaged(float reach_px) {
  constexpr float variance = 0.5f * ((1 << 2 * passes) - 1) / 3;
  return std::max(12.566f / (1.0f / variance + 1.0f / (reach_px * reach_px)), 1.0f);
}

float bell(float q) {
  const float rest = std::max(1.0f - q * 0.125f, 0.0f);
  return rest * rest * rest * rest;
}

bool on_one_part(const Place& a, const Place& b) {
  const glm::vec3 apart = b.position - a.position, bend = b.geometric_normal - a.geometric_normal;
  const float off = glm::dot(apart, a.geometric_normal), bend2 = glm::dot(bend, bend);
  const float bound = 0.05f + std::sqrt(bend2);
  return bend2 < 0.25f && off * off <= bound * bound * glm::dot(apart, apart);
}

// Rounds to the nearest half, of two the even one; 0 <= value <= 65504.
uint16_t half_of(float value) {
  if (value == 0.0f) return 0;
  int exponent = 0;
  std::frexp(value, &exponent);
  exponent = std::max(exponent - 1, -14);
  const double steps = std::nearbyint(std::ldexp(static_cast<double>(value), 10 - exponent));
  return static_cast<uint16_t>((exponent + 14) * 1024 + static_cast<int>(steps));
}

class OneByOne {
 public:
  OneByOne(const std::vector<LayerFilter::Chunk>& chunks, LayerCache& cache)
      : cache_(cache), first_(size_t{cache.width} * cache.height, none) {
    for (const LayerFilter::Chunk& chunk : chunks)
      for (size_t i = 0; i < chunk.layers.size(); ++i) {
        next_.push_back(std::exchange(first_[chunk.layers[i].pixel], static_cast<uint32_t>(places_.size())));
        places_.push_back(chunk.places[i]);
        layers_.push_back(chunk.layers[i]);
        reflected_.push_back(chunk.reflected[i]);
      }
  }

  void run() {
    std::vector<glm::vec4> next;
    for (size_t i = 0; i < places_.size(); ++i) next.push_back(prepared(i));
    reflected_ = next;
    for (int pass = 0; pass < passes; ++pass) {
      for (size_t i = 0; i < places_.size(); ++i)
        next[i] = reach_[i] < least_reach_px ? reflected_[i] : blurred(i, 1 << pass);
      reflected_.swap(next);
    }
    for (size_t i = 0; i < places_.size(); ++i) {
      glm::vec3 all;
      if (!filtered(i, all)) continue;
      uint16_t* radiance = &cache_.radiance[4 * size_t{layers_[i].texel}];
      for (int k = 0; k < 3; ++k) radiance[k] = half_of(std::clamp(all[k], 0.0f, 65504.0f));
      radiance[3] = half_of(1.0f);
    }
  }

 private:
  uint32_t like(const Place& at, uint32_t head) const {
    uint32_t best = none;
    float least = 0.0f;
    for (uint32_t j = head; j != none; j = next_[j]) {
      const Place& other = places_[j];
      if (other.surface_id != at.surface_id || !on_one_part(at, other)) continue;
      const float off = std::abs(glm::dot(other.position - at.position, at.geometric_normal));
      if (best == none || off < least) {
        best = j;
        least = off;
      }
    }
    return best;
  }

  std::array<uint32_t, 8> around(size_t i, int64_t step) const {
    const int64_t width = cache_.width, height = cache_.height;
    const int64_t x = layers_[i].pixel % width, y = layers_[i].pixel / width;
    std::array<uint32_t, 8> result{};
    size_t k = 0;
    for (int64_t v = y - step; v <= y + step; v += step)
      for (int64_t u = x - step; u <= x + step; u += step) {
        if (u == x && v == y) continue;
        const bool inside = u >= 0 && v >= 0 && u < width && v < height;
        result[k++] = inside ? like(places_[i], first_[static_cast<size_t>(v * width + u)]) : none;
      }
    return result;
  }

  glm::vec4 prepared(size_t i) {
    const Place& at = places_[i];
    float nearness = at.nearness, light = largest(reflected_[i]), count = 1.0f;
    for (const int64_t step : {1, 2})
      for (const uint32_t j : around(i, step)) {
        if (j == none) continue;
        nearness += places_[j].nearness;
        light += largest(reflected_[j]);
        count += 1.0f;
      }
    nearness /= count;
    light /= count;
    reach_.push_back(share_of_lobe * 2.0f * layers_[i].spread * alpha(at.roughness) /
                     (at.width * nearness + at.spread));
    const float most = std::max(0.5f * samples_averaged(reach_[i]), 4.0f) * light, own = largest(reflected_[i]);
    const float kept = reach_[i] >= least_reach_px && own > most ? most / own : 1.0f;
    return reflected_[i] * glm::vec4(kept, kept, kept, 1.0f);
  }

  float likeness(size_t i, size_t j) const {
    const Place &a = places_[i], &b = places_[j];
    const glm::vec3 apart = b.position - a.position, bend = b.normal - a.normal;
    const float reach = std::min(reach_[i] * a.width, reach_[j] * b.width), turn = share_of_lobe * alpha(a.roughness);
    const float rougher = (b.roughness - a.roughness) / (0.2f * std::min(a.roughness, b.roughness));
    return bell(glm::dot(apart, apart) / (reach * reach) + glm::dot(bend, bend) / (turn * turn) + rougher * rougher);
  }

  glm::vec4 blurred(size_t i, int64_t step) const {
    constexpr std::array<float, 8> kernel{0.25f, 0.5f, 0.25f, 0.5f, 0.5f, 0.25f, 0.5f, 0.25f};
    const std::array<uint32_t, 8> neighbours = around(i, step);
    glm::vec4 sum = reflected_[i];
    float weights = 1.0f;
    for (size_t k = 0; k < neighbours.size(); ++k) {
      const uint32_t j = neighbours[k];
      if (j == none || reach_[j] < least_reach_px) continue;
      const float weight = kernel[k] * likeness(i, j);
      sum += reflected_[j] * weight;
      weights += weight;
    }
    return sum / weights;
  }

  bool filtered(size_t i, glm::vec3& radiance) const {
    bool is_filtered = false;
    uint32_t first = none;
    for (uint32_t j = first_[layers_[i].pixel]; j != none; j = next_[j]) {
      const Layer& other = layers_[j];
      if (other.texel != layers_[i].texel) continue;
      if (first == none && j != i) return false;
      const bool stays = reflected_[j].w == 0.0f;
      is_filtered = is_filtered || !stays;
      const glm::vec3 now = stays ? other.noise : other.weight * glm::vec3(reflected_[j]);
      radiance = first == none ? other.rest + now : radiance + (now - other.noise);
      first = static_cast<uint32_t>(i);
    }
    return is_filtered;
  }

  LayerCache& cache_;
  std::vector<uint32_t> first_, next_;
  std::vector<Place> places_;
  std::vector<Layer> layers_;
  std::vector<glm::vec4> reflected_;
  std::vector<float> reach_;
};

}  // namespace

void filter_one_by_one(const std::vector<LayerFilter::Chunk>& chunks, LayerCache& cache) {
  Executor executor(1);  // it sets the floating-point mode
  executor.run(1, [&](size_t, uint32_t) { OneByOne(chunks, cache).run(); });
}

}  // namespace sideray::rt
