#include "rt/drawing/composite_over.h"

#include <half.h>

#include "rt/layers/frame_tiles.h"

namespace sideray::rt {
namespace {

glm::vec4 texel_of_halfs(const std::vector<uint16_t>& halfs, size_t texel) {
  const uint16_t* h = &halfs[4 * texel];
  return {imath_half_to_float(h[0]), imath_half_to_float(h[1]), imath_half_to_float(h[2]), imath_half_to_float(h[3])};
}

}  // namespace

// The radiance's alpha excludes surroundings seen by refracted rays.
void composite_over(const CompositeImage& image, Executor& executor, std::vector<glm::vec4>& picture) {
  for_tile_rows(image.width, image.height, image.traced_tiles, executor, [&](size_t first, uint32_t count) {
    for (size_t texel = first; texel < first + count; ++texel) {
      const glm::vec4 radiance = texel_of_halfs(image.radiance, texel);
      const glm::vec3 transmittance(texel_of_halfs(image.transmittance, texel));
      const float through = (transmittance.x + transmittance.y + transmittance.z) * (1.0f / 3.0f);
      glm::vec4& color = picture[texel];
      color = glm::vec4(glm::vec3(radiance) + glm::vec3(color) * transmittance, radiance.w - through + color.w * through);
    }
  });
}

}  // namespace sideray::rt
