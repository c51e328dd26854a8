// How far off the light of each layer may be where a pixel may be off by so much: which rays are skipped. Holds
// scratch memory: one object per thread.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <span>
#include <vector>

#include "rt/base/pixels.h"
#include "rt/layers/frame_context.h"
#include "rt/surfaces/surface.h"

namespace sideray::rt {

// Returns whether a ray that hit a triangle passes its edges, as it is seen, by more than `near`, in world units.
bool is_off_edges(const ShadingScene& scene, const Hit& hit, const Ray& ray, float near);

// A pixel is the sum of its layers' light, each times its weight: an equal share of the threshold for each layer, over
// its weight, keeps the pixel within the threshold.
class LayerNeeds {
 public:
  void begin(const FrameContext& frame, size_t pixels);
  bool active() const { return threshold_ > 0.0f; }

  // Describes a layer as it is hit; those of a pixel come nearest first.
  struct Met {
    uint32_t pixel, layer;
    const Hit* hit;
    const Ray* ray;
    const SurfacePoint* point;
    glm::vec3 weight;  // composite: in the picture; in a cache: estimated, never too small
  };
  // Returns by how much the radiance may err. `request` is that of the layer's pixel.
  float allowance(const PixelRequest& request, const Met& met);

 private:
  static constexpr uint32_t most_in_front = 8;
  // Describes a surface that attenuates layers that lie behind it or are drawn before it.
  struct Cover {
    uint32_t drawn;  // larger = later
    float distance, margin;
    glm::vec3 through;
  };
  struct PixelCovers {
    uint32_t count;
    std::array<Cover, most_in_front> covers;
  };

  float share(const PixelRequest& request, uint32_t layer) const;
  float weight_in_cache(const PixelRequest& request, const Met& met);
  glm::vec3 attenuation(const PixelCovers& covers, uint32_t drawn, float distance, float margin) const;
  uint32_t drawn(const Hit& hit) const;

  const FrameContext* frame_ = nullptr;
  float threshold_ = 0.0f;
  LayerWeights weights_ = LayerWeights::unknown;
  std::vector<PixelCovers> covers_;
};

// Bounds the light from mirrors: the brightest of environment and emission, and no less than 16, which stands for lit
// surfaces.
float brightest_mirrored(const model::Snapshot& snapshot);

// Looks once at each environment: those of panoramas have millions of texels, and whatever moves makes a new snapshot.
// One thread at a time.
class BrightestMirrored {
 public:
  float of(const model::Snapshot& snapshot);

 private:
  std::shared_ptr<const model::Environment> measured_;
  float environment_ = 0.0f;
};

}  // namespace sideray::rt
