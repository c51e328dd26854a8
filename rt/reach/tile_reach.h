// Records which cells of space the rays of each tile pass. Motion in other cells does not change what these rays find
// (docs/adr/0046-still-views.md). While a Following is alive, the intersector reports all rays of its thread to it.
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

// A cube that contains most of a view's visible surfaces.
struct ReachCube {
  glm::vec3 middle{0.0f};
  float half = 1.0f;  // half the side
};

// Holds the cells that rays pass: fine ones in the cube, coarse ones around it, and a single one for everything farther
// away.
class RayCells {
 public:
  // Adds the part of a ray between `from` and `to`, in lengths of its direction; `to` may be infinite.
  void add(const ReachCube& cube, const Ray& ray, float from, float to);
  void add(const RayCells& other);
  // Returns whether a ray may have passed the box; false is certain.
  bool meets(const ReachCube& cube, const model::Bounds& box) const;

 private:
  static constexpr int inner_side = 32, outer_side = 16;  // cells along each side of a cube
  static constexpr float outer_half = 8.0f;               // half the side, in those of the inner cube

  std::array<uint32_t, inner_side * inner_side> inner_{};
  std::array<uint16_t, outer_side * outer_side> outer_{};
  bool beyond_ = false;
};

class TileReach {
 public:
  explicit TileReach(size_t tiles) : masks_(tiles), mirrored_(tiles), sprites_(tiles) {}

  // Chooses the extent of the cells from a depth buffer, once. Not to be called while rays are followed.
  void fit(const TraceView& view, uint32_t width, uint32_t height, const DepthImage& depth);
  // Return false if it is certain that no ray of the tile has hit the box's content: an occluder of lights or sky, a
  // surface that an opaque one reflects, or a sprite. Not to be called while rays are followed.
  bool meets_occluders(size_t tile, const model::Bounds& box) const;
  bool meets_mirrored(size_t tile, const model::Bounds& box) const;
  bool meets_sprites(size_t tile, const model::Bounds& box) const;

 private:
  friend class Following;
  using Cells = std::vector<std::unique_ptr<RayCells>>;  // by tile, null: no ray

  bool meets(const Cells& cells, size_t tile, const model::Bounds& box) const;

  bool is_fit_ = false;
  ReachCube cube_;
  Cells masks_, mirrored_, sprites_;
  std::mutex mutex_;
};

// Follows the rays that its thread traces while it is alive.
class Following {
 public:
  // of_layers follows only rays that may hit sprites.
  enum class Rays { of_masks, of_reflections, of_layers };

  // `reach` null: follows nothing.
  Following(TileReach* reach, Rays rays);
  ~Following();
  Following(const Following&) = delete;
  Following& operator=(const Following&) = delete;

  // Adds the rays recorded so far to a tile. They may be added to several tiles.
  void add_to(size_t tile);

  // Returns the object that is alive on this thread, or null.
  static Following* now() { return now_; }
  // Record rays between their ends; with `hits`, up to the hits.
  void follow(std::span<const Ray> rays, bool meet_sprites);
  void follow(const RayColumns& rays);
  void follow(std::span<const Ray> rays, const Hit* hits);

 private:
  // constinit avoids a wrapper function that checks for initialisation, whose result UBSan takes for null.
  static constinit thread_local Following* now_;

  TileReach* reach_;
  const Rays rays_;
  bool any_ = false, any_sprites_ = false;
  RayCells cells_, sprites_;
};

}  // namespace sideray::rt
