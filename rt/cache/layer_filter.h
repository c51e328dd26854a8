// Filters what rough surfaces in a layer cache reflect, and what is seen through them: one random direction a pixel says little, but the pixels around
// see the same plane of the same surface by directions of their own. Each chunk is collected by one thread while
// tracing; one thread filters afterwards, on the executor. Same bits for any thread count.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "rt/base/executor.h"
#include "rt/cache/temporal_history.h"
#include "rt/layers/layer_request.h"
#include "rt/shading/point_shader.h"

namespace sideray::rt {

class LayerFilter {
 public:
  // Describes the surface of a layer, for its neighbours' comparison: one line of the processor's cache, because each is
  // read by some thirty others (as two lines they took 1.6 times as long).
  struct alignas(64) Place {
    glm::vec3 position, normal, geometric_normal;
    uint32_t surface_id;  // its complement for what is seen through the surface: it has nothing to do with reflections
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
    glm::vec3 noise;         // weight * reflected, as one direction told it
    float spread;            // of the lobe, as a share of a reflection's
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
  uint32_t like(const Place& at, uint32_t head) const;
  // The layers of the eight pixels around at one distance, in the order of rows; none where there is no such layer.
  using Around = std::array<uint32_t, 8>;
  Around around(size_t i, int64_t step) const;
  void prepare(size_t i);
  glm::vec4 blurred(size_t i, const Around& neighbours) const;
  bool filtered(size_t i, glm::vec3& radiance) const;

  std::vector<Chunk> chunks_;
  std::vector<size_t> offsets_;  // where each chunk begins in the arrays below
  std::vector<Place> places_;
  std::vector<Layer> layers_;
  std::vector<glm::vec4> reflected_, next_reflected_;
  std::vector<float> reach_;
  std::array<std::vector<Around>, 2> near_;  // at distances 1 and 2, which are needed twice
  std::vector<uint32_t> first_;  // first layer of every pixel, or none; all are none between frames
  int64_t width_ = 0, height_ = 0;
};

}  // namespace sideray::rt
