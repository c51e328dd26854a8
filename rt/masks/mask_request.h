// A request for the masks of a frame's opaque pixels: what a host asked for (sideray_mask_inputs, whose comments say what each
// value means), and beside it the frame's images, clock and history. And the masks. Plain memory; pixels: row 0 is the bottom
// row.
#pragma once

#include <algorithm>
#include <sideray/sideray.h>

#include <atomic>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "rt/base/deadline.h"
#include "rt/base/executor.h"
#include "rt/base/opaque_point.h"
#include "rt/base/sequence.h"
#include "rt/base/view.h"
#include "rt/history/pixel_trail.h"

namespace sideray::rt {

class KeptMasks;
class MaskFilters;
class OlderMasks;
struct TintTile;
struct WantedTiles;

// Where a deadline skipped tiles: which of the filters' tiles are traced in this frame. The masks of the others are of
// earlier frames, and filtered already.
struct TracedTiles {
  std::span<const uint8_t> of_lights, of_sky;  // row by row
  bool are_most;                               // they are half of the tiles or more
  bool none() const {
    const auto is_not = [](uint8_t tile) { return tile == 0; };
    return !are_most && std::ranges::all_of(of_lights, is_not) && std::ranges::all_of(of_sky, is_not);
  }
};

// What sideray_mask_inputs_init() fills in.
sideray_mask_inputs default_mask_inputs();

// Masks of opaque pixels: which share of each light's surface, or of the sky, they see.
struct MaskRequest : sideray_mask_inputs {
  // The texture of rest poses is read already: `rest_offsets`.
  explicit MaskRequest(const sideray_mask_inputs& inputs = default_mask_inputs()) : sideray_mask_inputs(inputs) {
    rest_texture = 0;
  }

  TraceView view;
  uint32_t width = 0, height = 0;
  DepthImage depth;
  float subpixel = 0x1p-9f;      // of a pixel, that the rasterizer moves a vertex by at most
  std::span<const glm::vec4> rest_offsets;  // a pixel: sideray_mask_inputs::rest_texture; or empty
  std::span<const OpaquePoint> points;      // a pixel: instead of the depth's, where both are one surface; or empty
  bool hit_distances = false;               // OcclusionMasks::hit_distance is wanted
  MaskFilters* filters = nullptr;           // of the sequence; none: masks stay as they were traced
  SequenceStep sequence = SequenceStep::first;
  KeptMasks* kept = nullptr;          // of the sequence, which has one set of masks; none: every mask is traced
  // Frames over which this position of a still view has been traced, this one included. Masks are filtered in the last
  // of them, as one frame without history. 0 = the frame is shown as it is.
  uint32_t position_frames = 0;
  bool redraw_keeps = false;          // a redrawn frame also reuses what it traced when it was drawn first
  std::span<const float> view_depths = {};  // those of fill_depths(), if they are computed already; or empty
  const TracedTiles* traced = nullptr;      // null: all of the picture
  std::span<const glm::vec2> motion;  // a pixel: sideray_frame_source::motion_texture; or empty
  uint32_t seed = 1;
  const std::atomic<bool>* cancelled = nullptr;  // polled between tiles
  WorkTime work;                                 // of lights and of the sky: tiles that it does not let begin are given up
  ViewFrame frame{};            // of `older`
  OlderMasks* older = nullptr;  // of the sequence: tiles without a turn show their history; null: they are lit
  const WantedTiles* wanted = nullptr;  // null: all tiles are; otherwise neither `kept` nor `older` reuses anything
};

// Returns whether hosts ask for the same masks.
bool ask_alike(const sideray_mask_inputs& a, const sideray_mask_inputs& b);

// Returns whether tiles without a turn show their history.
inline bool has_older(const MaskRequest& request) {
  return request.older && is_bounded(request.work);
}

// Layers of a mask of lights: indices of the lights, lowest first.
std::vector<uint32_t> lights_of(uint32_t mask);

// How many masks of lights a request asks for: one a bit, lowest first, then the combined one.
uint32_t light_masks_of(uint32_t lights, bool combined);
uint32_t light_masks_of(const MaskRequest& request);
// The same with the layer of the unhidden sky, which is the last.
uint32_t mask_layers_of(const MaskRequest& request);

// Layer-major, as in LayerCache. 255 = lit, open; also where nothing was drawn.
struct OcclusionMasks {
  static constexpr uint32_t filter_tile = 16;  // pixels along each side of the tiles that filters work on
  enum Seen : uint8_t { seen_dark = 1, seen_lit = 2 };

  uint32_t width = 0, height = 0, layers = 0;
  bool whole = true;  // no tile was skipped
  std::vector<uint8_t> lit;
  // Along the shadow ray, from its origin, +inf = none: of occluded pixels in tiles of 16 pixels that are neither lit
  // nor dark, neighbours included. Empty unless asked for.
  std::vector<float> hit_distance;
  std::vector<uint8_t> open;  // ambient; empty unless asked for
  // The same of the pixels that filters read, and along the first of their ambient rays. Empty without filters.
  std::vector<float> filter_distance, open_distance;
  // Each pixel's depth along the camera's axis, as fill_depths() computes it (rt/history/frame_camera.h), and the error
  // of the depth buffer in its range 0..1. Empty unless requested (`moving`).
  std::vector<float> depth;
  float depth_step = 0;
  // Which masks of each pixel are traced, or reprojected from an earlier frame (Answer); the others are lit and open.
  // Empty: all are.
  enum Answer : uint8_t { answer_of_lights = 1, answer_of_sky = 2 };
  std::vector<uint8_t> answers;
  // Of the filters' tiles, layer-major, row by row: which of Seen their pixels are, and whether any has a finite
  // filter_distance.
  std::vector<uint8_t> seen, measured;

  // What translucent surfaces leave of the lights' colours on the way to a pixel, 255 = all: of the masks of lights through
  // which something was ever tinted since the masks have this size. Such a mask has a place, and there a plane for each of
  // red, green and blue. The light that arrives is that of the mask times these.
  static constexpr uint32_t tint_tile = 32;  // pixels along each side of the tiles
  uint32_t tints = 0;                // places
  std::vector<uint32_t> tint_places;  // of each layer of `lit`, counted from 1; 0: it has none
  std::vector<uint8_t> tint;          // place by place, channel by channel
  std::vector<float> tint_distance;   // as filter_distance, place by place
  std::vector<uint8_t> tint_tiles;    // place by place, row by row: 1 = some pixel there is not 255
  // Of each place: the last frame has something in it; red, green and blue differ somewhere in this one.
  std::vector<uint8_t> tint_lasts, tint_coloured;

  uint32_t tint_columns() const { return (width + tint_tile - 1) / tint_tile; }
  uint32_t tint_rows() const { return (height + tint_tile - 1) / tint_tile; }
  size_t tint_tile_index(uint32_t place, size_t tile) const {
    return (size_t{place} - 1) * tint_columns() * tint_rows() + tile;
  }
  std::span<uint8_t> tint_plane(uint32_t place, uint32_t channel) {
    const size_t pixels = size_t{width} * height;
    return std::span(tint).subspan(((size_t{place} - 1) * 3 + channel) * pixels, pixels);
  }
  std::span<const uint8_t> tint_plane(uint32_t place, uint32_t channel) const {
    const size_t pixels = size_t{width} * height;
    return std::span(tint).subspan(((size_t{place} - 1) * 3 + channel) * pixels, pixels);
  }
  // Returns whether anything is tinted at a place.
  bool is_tinted(uint32_t place) const;
  // Gives a layer a place; nothing is tinted there yet.
  void add_tint(uint32_t layer, bool filtered);
  // Writes a tile of a place; null: nothing is tinted there. Different tiles may be written at the same time.
  void store_tint(uint32_t place, size_t tile, const TintTile* found);
  // Finds the tiles that hold a tint, after filtering and reprojection have spread it.
  void find_tinted(Executor& executor);
  void forget_tints();

  uint32_t filter_columns() const { return (width + filter_tile - 1) / filter_tile; }
  uint32_t filter_rows() const { return (height + filter_tile - 1) / filter_tile; }
  size_t filter_index(uint32_t layer, uint32_t column, uint32_t row) const {
    return (size_t{layer} * filter_rows() + row) * filter_columns() + column;
  }
  // Returns whether, in a tile and its neighbours, some of a light's rays arrive and some do not.
  bool in_penumbra(uint32_t layer, uint32_t column, uint32_t row) const;
};

}  // namespace sideray::rt
