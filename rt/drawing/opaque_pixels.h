// Finds the opaque surface of each pixel of a view, by a ray through the pixel's sample position: the content of a
// rasterizer's depth buffer and G-buffer. Lines and points are drawn over it where they are nearer. Rays hit the scene
// in its current poses (TracedScene). Row 0 of pixels is the bottom row. One call at a time.
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

// Marks the instance of hits on lines and points, combined with its index in Snapshot::thin.
inline constexpr uint32_t thin_instance = 0x80000000u;
inline bool is_thin(const Hit& hit) {
  return hit.instance != no_instance && (hit.instance & thin_instance) != 0;
}
// Returns the index of a hit's instance in ShadingScene::records.
inline uint32_t record_of(const Hit& hit, const model::Snapshot& snapshot) {
  const auto surfaces = static_cast<uint32_t>(snapshot.instances.size());
  return is_thin(hit) ? surfaces + (hit.instance & ~thin_instance) : hit.instance;
}

struct OpaquePixels {
  uint32_t width = 0, height = 0;
  std::vector<float> depths;       // window depth, as DepthFormat::d32f
  std::vector<Hit> hits;           // instance: no_instance without a surface; see is_thin()
  std::vector<glm::vec4> normals;  // shading normal, perceptual roughness; 0 without a surface; empty unless requested

  DepthImage depth() const {
    return {reinterpret_cast<const std::byte*>(depths.data()), size_t{width} * sizeof(float), DepthFormat::d32f};
  }
};

// Returns a window depth as stored in OpaquePixels::depths. It never equals the background's, however far away the
// surface is, because an infinitely far plane has no surface.
float stored_depth(const TraceView& view, double window_depth);

// Refills `pixels`. Throws Failure.
Counters trace_opaque_pixels(const OpaqueRequest& request, TracedScene& scene, OpaquePixels& pixels);

// Holds the G-buffer of opaque surfaces; 0 where there is none.
struct OpaqueMaterials {
  std::vector<glm::vec4> albedo_metallic, normal_roughness;
  std::vector<glm::uvec2> ids;  // surface id, triangle + 1
};
std::vector<glm::uvec2> ids_of(const OpaquePixels& pixels, TracedScene& scene);
OpaqueMaterials materials_of(const OpaqueRequest& request, const OpaquePixels& pixels, TracedScene& scene);

// Counts each pixel's translucent surfaces in front of opaque ones, up to `most`, which is at most 64. `sprites`:
// counts sprites too.
std::vector<uint8_t> count_translucent(const OpaqueRequest& request, const OpaquePixels& pixels, bool sprites, uint32_t most,
                                       TracedScene& scene);

}  // namespace sideray::rt
