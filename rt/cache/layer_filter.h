// Filters what rough surfaces in a layer cache reflect, and what is seen through them: one random direction a pixel
// says little, but the pixels around see the same plane of the same surface by directions of their own. Each chunk is
// collected by one thread while tracing; one thread filters afterwards, on the executor. Same bits for any thread
// count.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "rt/base/executor.h"
#include "rt/cache/layer_filter_kernels.h"
#include "rt/layers/layer_request.h"
#include "rt/shading/point_shader.h"

namespace sideray::rt {

class LayerFilter {
 public:
  explicit LayerFilter(const LayerFilterKernels& kernels = layer_filter_kernels()) : kernels_(&kernels) {}

  // Describes the surface of a layer, for its neighbours' comparison.
  struct Place {
    glm::vec3 position, normal, geometric_normal;
    uint32_t surface_id;  // its complement for what is seen through the surface: it has nothing to do with reflections
    float roughness;      // perceptual
    float width;          // width of the pixel there, world units
    float spread;         // spread of the pixel per unit of distance
    float nearness;       // nearness of what it reflects
  };
  struct Layer {
    uint32_t pixel, texel;   // index in the picture, index in the cache
    glm::vec3 rest, weight;  // the layer's radiance is rest + weight * reflected
    glm::vec3 noise;         // weight * reflected, of one direction
    float spread;            // of the lobe, as a share of a reflection's
    bool is_sampled;         // as in RoughReflection
    glm::vec3 surroundings;  // likewise
  };
  // Holds what one chunk of pixels found, in its order.
  struct Chunk {
    std::vector<Place> places;
    std::vector<Layer> layers;
    std::vector<glm::vec4> reflected;  // radiance; w: 1 where a surface was hit, 0 where the environment was
    std::vector<int32_t> ranks;        // how many layers of the pixel come before it, the last that was found being 0
    void add(uint32_t pixel, uint32_t texel, uint32_t surface_id, const SurfacePoint& point, glm::vec3 radiance,
             const RoughReflection& rough);
  };

  // Resets the filter for a frame.
  void begin(size_t chunks);
  Chunk& chunk(size_t index) { return chunks_[index]; }
  // Writes the filtered radiance of all that was collected.
  void apply(Executor& executor, LayerCache& cache);

 private:
  template <typename Value>
  struct alignas(64) Line {
    Value values[layers_at_once];
  };
  // Part of the picture whose layers lie together.
  struct Tile {
    int32_t first, count;
  };

  void fit(uint32_t width, uint32_t height);
  void fit_columns(size_t count);
  int32_t place_of(uint32_t pixel) const;
  int32_t& first_of(uint32_t pixel);
  template <typename Work>
  void for_rows(size_t tile, const Work& work);
  size_t gather(Executor& executor);
  void rank(Chunk& chunk);
  void count(size_t tile);
  void link(size_t tile);
  void scatter(const Chunk& chunk);
  bool filtered(int32_t i, glm::vec3& radiance) const;

  const LayerFilterKernels* kernels_;
  uint32_t width_ = 0, height_ = 0, tiles_x_ = 0;
  std::vector<Chunk> chunks_;
  std::vector<Chunk*> filled_;  // those that hold layers: under a deadline few do
  std::vector<Tile> tiles_;
  // Layers lie by tile, row, rank and column there, so that neighbours in the picture mostly follow each other.
  LayerColumns columns_{};
  std::vector<Line<float>> floats_;
  std::vector<Line<int32_t>> integers_;
  std::vector<int32_t> first_;  // all are none between frames
  std::vector<const Layer*> layers_;
};

}  // namespace sideray::rt
