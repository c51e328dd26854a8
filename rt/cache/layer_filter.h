// Filters the reflections of rough surfaces in a layer cache, and the light seen through them. One random direction a
// pixel is noisy, but the pixels around sample the same plane of the same surface in other directions. One thread
// collects each chunk during tracing; one thread filters afterwards, on the executor. The bits do not depend on the
// thread count.
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

  // Describes the surface of a layer, so that neighbours can be compared.
  struct Place {
    glm::vec3 position, normal, geometric_normal;
    uint32_t surface_id;  // its complement for light seen through the surface, which is never mixed with reflections
    float roughness;      // perceptual
    float width;          // of the pixel's footprint there, in world units
    float spread;         // of the footprint, per unit of distance
    float nearness;       // of the reflected surface
  };
  struct Layer {
    uint32_t pixel, texel;   // index in the picture, index in the cache
    glm::vec3 rest, weight;  // the layer's radiance is rest + weight * reflected
    glm::vec3 noise;         // weight * reflected, from one direction
    float spread;            // width of the lobe, relative to a reflection's
    bool is_sampled;         // as in RoughReflection
    glm::vec3 surroundings;  // as in RoughReflection
  };
  // Holds the layers of one chunk of pixels, in the chunk's order.
  struct Chunk {
    std::vector<Place> places;
    std::vector<Layer> layers;
    std::vector<glm::vec4> reflected;  // radiance; w: 1 if a surface was hit, 0 for the environment
    std::vector<int32_t> ranks;        // index of the layer in its pixel, where the last one found is 0
    void add(uint32_t pixel, uint32_t texel, uint32_t surface_id, const SurfacePoint& point, glm::vec3 radiance,
             const RoughReflection& rough);
  };

  // Resets the filter for a frame.
  void begin(size_t chunks);
  Chunk& chunk(size_t index) { return chunks_[index]; }
  // Writes the filtered radiance of all collected layers.
  void apply(Executor& executor, LayerCache& cache);

 private:
  template <typename Value>
  struct alignas(64) Line {
    Value values[layers_at_once];
  };
  // Describes a tile of the picture, whose layers are contiguous.
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
  std::vector<Chunk*> filled_;  // chunks with layers; few under a deadline
  std::vector<Tile> tiles_;
  // Layers are ordered by tile, row, rank and column, so that neighbours in the picture are mostly neighbours here.
  LayerColumns columns_{};
  std::vector<Line<float>> floats_;
  std::vector<Line<int32_t>> integers_;
  std::vector<int32_t> first_;  // all entries are `none` between frames
  std::vector<const Layer*> layers_;
};

}  // namespace sideray::rt
