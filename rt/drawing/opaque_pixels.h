// Finds the opaque surface that each pixel of a view shows, by a ray through the pixel's sample position: what a rasterizer's
// depth buffer and G-buffer hold. Lines and points are drawn over them, where they are nearer. Rays hit the scene in the
// poses that it has (TracedScene). Pixels: row 0 is the bottom row. One call at a time.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "rt/base/counters.h"
#include "rt/base/ray.h"
#include "rt/base/view.h"
#include "rt/embree/intersector.h"
#include "rt/scene/traced_scene.h"

namespace sideray::rt {

struct OpaqueRequest {
  TraceView view;
  uint32_t width = 0, height = 0;
  bool normals = false;  // fill OpaquePixels::normals
};

// Hits of lines and points name their instances so: by their places in Snapshot::thin.
inline constexpr uint32_t thin_instance = 0x80000000u;
inline bool is_thin(const Hit& hit) {
  return hit.instance != no_instance && (hit.instance & thin_instance) != 0;
}
// Returns the instance by which a hit names its record in ShadingScene::records.
inline uint32_t record_of(const Hit& hit, const model::Snapshot& snapshot) {
  const auto surfaces = static_cast<uint32_t>(snapshot.instances.size());
  return is_thin(hit) ? surfaces + (hit.instance & ~thin_instance) : hit.instance;
}

struct OpaquePixels {
  uint32_t width = 0, height = 0;
  std::vector<float> depths;       // in the window, as DepthFormat::d32f
  std::vector<Hit> hits;           // the instance is no_instance where nothing is seen, or see is_thin()
  std::vector<glm::vec4> normals;  // shading normal, perceptual roughness; 0 where nothing is seen; empty unless asked for

  DepthImage depth() const {
    return {reinterpret_cast<const std::byte*>(depths.data()), size_t{width} * sizeof(float), DepthFormat::d32f};
  }
};

// Returns a window depth as OpaquePixels::depths has it: never that of the background, however far away the surface is
// (an infinitely far plane has none).
float stored_depth(const TraceView& view, double window_depth);

// Refills `pixels`. Throws Failure.
Counters trace_opaque_pixels(const OpaqueRequest& request, TracedScene& scene, OpaquePixels& pixels);

// Holds what a G-buffer shows of the opaque surfaces; 0 where nothing is seen.
struct OpaqueMaterials {
  std::vector<glm::vec4> albedo_metallic, normal_roughness;
  std::vector<glm::uvec2> ids;  // surface id, triangle + 1
};
std::vector<glm::uvec2> ids_of(const OpaquePixels& pixels, TracedScene& scene);
OpaqueMaterials materials_of(const OpaqueRequest& request, const OpaquePixels& pixels, TracedScene& scene);

// Counts the translucent surfaces before the opaque ones, at most `most`, up to 64, a pixel. `sprites` count too.
std::vector<uint8_t> count_translucent(const OpaqueRequest& request, const OpaquePixels& pixels, bool sprites, uint32_t most,
                                       TracedScene& scene);

}  // namespace sideray::rt
