// Filters what rough surfaces in a layer cache reflect: one random direction a pixel says little, but the pixels around
// see the same plane of the same surface by directions of their own. Each chunk is collected by one thread while
// tracing; one thread filters afterwards, on the executor. Same bits for any thread count.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "rt/base/executor.h"
#include "rt/layers/layer_request.h"
#include "rt/layers/temporal_history.h"
#include "rt/shading/point_shader.h"

namespace sideray::rt {

class LayerFilter {
 public:
  // Describes the surface of a layer, for its neighbours' comparison.
  struct Place {
    glm::vec3 position, normal, geometric_normal;
    uint32_t surface_id;
    uint32_t next;    // next layer of the same pixel, or none
    float roughness;  // perceptual
    float width;      // width of the pixel there, world units
    float spread;     // spread of the pixel per unit of distance
    float nearness;   // nearness of what it reflects
    float reach_px;   // how far, in pixels, neighbours reflect about the same
  };
  struct Layer {
    uint32_t pixel, texel;   // index in the picture, index in the cache
    glm::vec3 rest, weight;  // the layer's radiance is rest + weight * reflected
  };
  // Holds what one chunk of pixels found, in its order.
  struct Chunk {
    std::vector<Place> places;
    std::vector<Layer> layers;
    std::vector<glm::vec4> reflected;  // radiance; w: 1 where a surface was hit, 0 where the environment was
    void add(uint32_t pixel, uint32_t texel, uint32_t surface_id, const SurfacePoint& point, glm::vec3 radiance,
             const RoughReflection& rough);
  };

  // Forgets the frame before.
  void begin(size_t chunks);
  Chunk& chunk(size_t index) { return chunks_[index]; }
  // Writes the filtered radiance of all that was collected; the history, where there is one, keeps it for the next
  // frame.
  void apply(Executor& executor, LayerCache& cache, LayerHistory* history = nullptr);

 private:
  static constexpr uint32_t none = 0xffffffffu;

  size_t gather(Executor& executor, size_t pixels);
  uint32_t neighbour(const Place& at, int64_t x, int64_t y) const;
  template <typename Visit>
  void for_neighbours(size_t i, int64_t step, const Visit& visit) const;
  void prepare(size_t i);
  glm::vec4 blurred(size_t i, int64_t step) const;

  std::vector<Chunk> chunks_;
  std::vector<size_t> offsets_;  // where each chunk begins in the arrays below
  std::vector<Place> places_;
  std::vector<Layer> layers_;
  std::vector<glm::vec4> reflected_, next_reflected_;
  std::vector<float> reach_;
  std::vector<uint32_t> first_;  // first layer of every pixel, or none; all are none between frames
  int64_t width_ = 0, height_ = 0;
};

}  // namespace sideray::rt
