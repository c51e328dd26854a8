// Requests reflections of glossy opaque pixels, and holds their image. Plain values; any thread. Row 0 of pixels is the
// bottom row.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "rt/opaque/light_request.h"

namespace sideray::rt {

class OlderReflections;

// Holds world-space shading normals and perceptual roughness, 0 without a surface: four floats or four halfs a pixel,
// in the format of the host's texture. If asked for another format, drivers convert it on the CPU while the host's
// thread waits: 45 ms for 1920x1080 (NVIDIA 580).
class NormalTexels {
 public:
  NormalTexels() = default;
  explicit NormalTexels(std::span<const glm::vec4> floats) : bytes_(std::as_bytes(floats)) {}
  explicit NormalTexels(std::span<const uint16_t> halfs) : bytes_(std::as_bytes(halfs)), are_halfs_(true) {}

  size_t size() const { return bytes_.size() / (are_halfs_ ? 4 * sizeof(uint16_t) : sizeof(glm::vec4)); }
  std::span<const std::byte> bytes() const { return bytes_; }
  glm::vec4 operator[](size_t texel) const;
  float roughness(size_t texel) const;
  // Sets for each of `count` texels whether it has a reflection_share(). Returns whether any has.
  bool find_reflecting(size_t first, size_t count, float max_roughness, uint8_t* reflects) const;

 private:
  std::span<const std::byte> bytes_;
  bool are_halfs_ = false;
};

// Requests reflections of glossy opaque surfaces.
struct ReflectionRequest : LightRequest {
  NormalTexels normals{};
  float max_roughness = 0.0f;         // rougher pixels are not traced
  float error = 0.0f;                 // as LayerRequest::ray_reuse, for sampled lights
  bool light_bounces = false;         // as LayerRequest::light_bounces
  OlderReflections* older = nullptr;  // of the sequence: skipped tiles show history; null: they have none
};

struct ReflectionImage {
  uint32_t width = 0, height = 0;
  std::vector<uint16_t> radiance;  // four halfs a texel; alpha: weight against the prefiltered environment
  bool changed = true;             // by the last trace
};

}  // namespace sideray::rt
