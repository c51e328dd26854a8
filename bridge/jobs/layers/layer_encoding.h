// The form in which a host's shaders want the layers: transfer function, scale, numbers of surfaces. Plain memory.
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

// model::encode_radiance() for halfs; there are few enough of them for a table. Alpha, every fourth, stays.
class RadianceTable {
 public:
  void encode(const uint16_t* rgba, uint16_t* encoded, size_t texels, const LayerEncoding& encoding);

 private:
  std::vector<uint16_t> table_;
  sideray_radiance_space space_ = SIDERAY_SPACE_LINEAR;
  float scale_ = 0.0f;
};

}  // namespace sideray::bridge
