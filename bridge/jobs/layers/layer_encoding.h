// Encodes layers as a host's shaders want them: transfer function, scale, type of surface ids. Plain memory.
#pragma once

#include <sideray/sideray.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace sideray::bridge {

struct LayerEncoding {
  sideray_radiance_space space = SIDERAY_SPACE_LINEAR;
  float scale = 1.0f;
  bool float_ids = false;
  bool changes_radiance() const { return space != SIDERAY_SPACE_LINEAR || scale != 1.0f; }
  bool operator==(const LayerEncoding&) const = default;
};

// Tabulates model::encode_radiance() for all halfs. Keeps alpha, every fourth value.
class RadianceTable {
 public:
  void encode(const uint16_t* rgba, uint16_t* encoded, size_t texels, const LayerEncoding& encoding);

 private:
  std::vector<uint16_t> table_;
  sideray_radiance_space space_ = SIDERAY_SPACE_LINEAR;
  float scale_ = 0.0f;
};

}  // namespace sideray::bridge
