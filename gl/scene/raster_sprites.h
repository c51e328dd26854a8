// Puts the sprites that a view shows into one buffer, in drawing order. The context must be current.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "gl/context/functions.h"
#include "gl/resources/objects.h"
#include "gl/resources/program.h"
#include "gl/resources/raster_textures.h"
#include "gl/scene/raster_view.h"

namespace sideray::gl {

// Describes a sprite in drawing order.
struct PlacedSprite {
  float depth;  // along the view axis
  uint32_t system, sprite;
};

// Holds consecutive sprites of one system, in drawing order.
struct SpriteRun {
  uint32_t system = 0, first = 0, count = 0;
};

// Return whether a system's sprites, or any of a snapshot's, fade in front of opaque surfaces.
bool is_soft(const model::ParticleSystem& system);
bool has_soft_sprites(const model::Snapshot& snapshot);

class RasterSprites {
 public:
  explicit RasterSprites(const Functions& gl) : gl_(gl), buffer_(gl), vertex_array_(gl) {}

  // Sorts the sprites that the view shows, the farthest plane first, and fills the buffer. Of equally far sprites the
  // one that comes first in the snapshot is in front. The span is valid until the next call.
  std::span<const PlacedSprite> place(const model::Snapshot& snapshot, const RasterView& view);

  // Set uniforms of a sprite program in use: those of the view, and those of a system with its texture.
  static void set_view(const Program& program, const RasterView& view, uint32_t picture_height);
  static void set_system(const Program& program, const model::Snapshot& snapshot, uint32_t system,
                         RasterTextures& textures);
  void draw(const SpriteRun& run);

 private:
  void point_at(uint32_t first);

  const Functions& gl_;
  Buffer buffer_;
  VertexArray vertex_array_;
  std::vector<uint64_t> keys_;
  std::vector<PlacedSprite> placed_;
};

}  // namespace sideray::gl
