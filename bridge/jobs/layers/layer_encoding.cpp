#include "bridge/jobs/layers/layer_encoding.h"

#include <algorithm>
#include <glm/gtc/packing.hpp>

#include "model/environment.h"

namespace sideray::bridge {
namespace {

constexpr uint16_t first_infinite = 0x7c00, sign = 0x8000;
constexpr float largest_half = 65504.0f;

}  // namespace

void RadianceTable::encode(const uint16_t* rgba, uint16_t* encoded, size_t texels, const LayerEncoding& encoding) {
  if (table_.empty() || space_ != encoding.space || scale_ != encoding.scale) {
    space_ = encoding.space, scale_ = encoding.scale;
    table_.assign(size_t{1} << 16, 0);  // codes with the sign bit stay 0: radiance is not negative
    for (uint32_t half = 0; half < first_infinite; ++half)
      table_[half] = glm::packHalf1x16(std::min(
          model::encode_radiance(glm::unpackHalf1x16(static_cast<uint16_t>(half)), space_, scale_), largest_half));
    std::fill(table_.begin() + first_infinite, table_.begin() + sign, table_[first_infinite - 1]);
  }
  for (size_t i = 0; i < 4 * texels; i += 4) {
    for (size_t c = 0; c < 3; ++c) encoded[i + c] = table_[rgba[i + c]];
    encoded[i + 3] = rgba[i + 3];
  }
}

}  // namespace sideray::bridge
