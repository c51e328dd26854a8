// A request for what glossy opaque pixels mirror, and the image that answers it. Plain values; any thread. Pixels: row
// 0 is the bottom row.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "rt/opaque/light_request.h"

namespace sideray::rt {

class OlderReflections;

// Shading normals in world space, and the perceptual roughness; 0 where there is no surface: four floats a pixel, or four
// halfs, as the host's texture has them. Drivers that are asked for another format than the texture's convert it on the CPU
// while the host's thread waits: 45 ms for 1920x1080 (NVIDIA 580).
class NormalTexels {
 public:
  NormalTexels() = default;
  explicit NormalTexels(std::span<const glm::vec4> floats) : bytes_(std::as_bytes(floats)) {}
  explicit NormalTexels(std::span<const uint16_t> halfs) : bytes_(std::as_bytes(halfs)), are_halfs_(true) {}

  size_t size() const { return bytes_.size() / (are_halfs_ ? 4 * sizeof(uint16_t) : sizeof(glm::vec4)); }
  std::span<const std::byte> bytes() const { return bytes_; }
  glm::vec4 operator[](size_t texel) const;
  float roughness(size_t texel) const;
  // Returns false where all of some texels are rougher. It may return true there.
  bool any_below(size_t first, size_t count, float roughness) const;

 private:
  std::span<const std::byte> bytes_;
  bool are_halfs_ = false;
};

// Requests what glossy opaque surfaces mirror.
struct ReflectionRequest : LightRequest {
  NormalTexels normals{};
  float max_roughness = 0.0f;         // rougher pixels are not traced
  float error = 0.0f;                 // as LayerRequest::ray_reuse, for lights that are drawn by chance
  bool light_bounces = false;         // as LayerRequest::light_bounces
  OlderReflections* older = nullptr;  // of the sequence: what tiles without a turn show; null: they are not traced
};

struct ReflectionImage {
  uint32_t width = 0, height = 0;
  std::vector<uint16_t> radiance;  // four halfs a texel; alpha: its share beside the prefiltered environment's
  bool changed = true;             // by the last trace
};

}  // namespace sideray::rt
