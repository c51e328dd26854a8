// Records where the rays of a picture's tiles go: which cells of space any ray of a tile passes. What moves in other
// cells changes nothing that these rays find (docs/adr/0046-still-views.md). While Following is alive, the intersector
// reports all rays of its thread to it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "model/snapshot.h"
#include "rt/base/ray.h"
#include "rt/base/view.h"

namespace sideray::rt {

// A cube that holds most of what a view shows.
struct ReachCube {
  glm::vec3 middle{0.0f};
  float half = 1.0f;  // of a side
};

// Cells that rays pass: fine ones in the cube, coarse ones around it, and all that is farther away as one.
class RayCells {
 public:
  // Adds the ray's part from `from` to `to`, which may be infinite, in lengths of its direction.
  void add(const ReachCube& cube, const Ray& ray, float from, float to);
  void add(const RayCells& other);
  // Returns whether a ray may have passed the box; false is certain.
  bool meets(const ReachCube& cube, const model::Bounds& box) const;

 private:
  static constexpr int inner_side = 32, outer_side = 16;  // cells along each side of a cube
  static constexpr float outer_half = 8.0f;               // of a side, in those of the inner cube

  std::array<uint32_t, inner_side * inner_side> inner_{};
  std::array<uint16_t, outer_side * outer_side> outer_{};
  bool beyond_ = false;
};

class TileReach {
 public:
  explicit TileReach(size_t tiles) : masks_(tiles), mirrored_(tiles), sprites_(tiles) {}

  // Chooses the extent of the cells from a depth buffer, unless it is chosen already. Not while rays are followed.
  void fit(const TraceView& view, uint32_t width, uint32_t height, const DepthImage& depth);
  // Each returns false if it is certain that no ray of the tile has hit what is in a box: an occluder of lights or sky,
  // something that an opaque surface mirrors, or a sprite. Not while rays are followed.
  bool meets_occluders(size_t tile, const model::Bounds& box) const;
  bool meets_mirrored(size_t tile, const model::Bounds& box) const;
  bool meets_sprites(size_t tile, const model::Bounds& box) const;

 private:
  friend class Following;
  using Cells = std::vector<std::unique_ptr<RayCells>>;  // of a tile, null: no ray

  bool meets(const Cells& cells, size_t tile, const model::Bounds& box) const;

  bool is_fit_ = false;
  ReachCube cube_;
  Cells masks_, mirrored_, sprites_;
  std::mutex mutex_;
};

// Follows the rays that this thread traces while the object is alive.
class Following {
 public:
  // Of layers' rays only those that hit sprites are followed.
  enum class Rays { of_masks, of_reflections, of_layers };

  // null: follows nothing.
  Following(TileReach* reach, Rays rays);
  ~Following();
  Following(const Following&) = delete;
  Following& operator=(const Following&) = delete;

  // Adds all rays recorded since to a tile; several tiles may get the same rays.
  void add_to(size_t tile);

  // The object that is alive on this thread, or null.
  static Following* now() { return now_; }
  // Record rays from start to end; with `hits`, only as far as they hit something.
  void follow(std::span<const Ray> rays, bool meet_sprites);
  void follow(const RayColumns& rays);
  void follow(std::span<const Ray> rays, const Hit* hits);

 private:
  // constinit: without it every use goes through a function that could initialise it, whose answer UBSan takes for null.
  static constinit thread_local Following* now_;

  TileReach* reach_;
  const Rays rays_;
  bool any_ = false, any_sprites_ = false;
  RayCells cells_, sprites_;
};

}  // namespace sideray::rt
