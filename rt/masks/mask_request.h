// Requests the masks of a frame's opaque pixels: the host's sideray_mask_inputs, whose comments explain each value,
// with the frame's images, clock and history. Also declares the masks themselves. Plain memory; row 0 of pixels is the
// bottom row.
#pragma once

#include <algorithm>
#include <sideray/sideray.h>

#include <atomic>
#include <cmath>
#include <cstdint>
#include <functional>
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

// Says which of the filters' tiles are traced in this frame, if a deadline skipped some. The masks of the others are
// from earlier frames and filtered already.
struct TracedTiles {
  std::span<const uint8_t> of_lights, of_sky;  // row by row
  bool are_most;                               // they are half of the tiles or more
  bool none() const {
    const auto is_not = [](uint8_t tile) { return tile == 0; };
    return !are_most && std::ranges::all_of(of_lights, is_not) && std::ranges::all_of(of_sky, is_not);
  }
};

// Returns what sideray_mask_inputs_init() fills in.
sideray_mask_inputs default_mask_inputs();

// Requests masks of opaque pixels: the visible share of each light's surface, or of the sky.
struct MaskRequest : sideray_mask_inputs {
  // The texture of rest poses is not needed: `rest_offsets` holds its texels.
  explicit MaskRequest(const sideray_mask_inputs& inputs = default_mask_inputs()) : sideray_mask_inputs(inputs) {
    rest_texture = 0;
  }

  TraceView view;
  uint32_t width = 0, height = 0;
  DepthImage depth;
  float subpixel = 0x1p-9f;      // the most, in pixels, by which the rasterizer moves a vertex
  std::span<const glm::vec4> rest_offsets;  // one a pixel, from sideray_mask_inputs::rest_texture; or empty
  std::span<const OpaquePoint> points;      // one a pixel: replaces the depth's point if both are on one surface; or
                                            // empty
  bool hit_distances = false;               // OcclusionMasks::hit_distance must be filled
  MaskFilters* filters = nullptr;           // of the sequence; null: masks are not filtered
  SequenceStep sequence = SequenceStep::first;
  KeptMasks* kept = nullptr;          // of the sequence, whose masks stay in one OcclusionMasks; null: every mask is
                                      // traced
  // Number of frames, this one included, that have traced this position of a view at rest. Its masks are filtered in
  // the last of them, as one frame without history. 0 = every frame is shown.
  uint32_t position_frames = 0;
  bool redraw_keeps = false;          // a redrawn frame also reuses what it traced when it was first drawn
  std::span<const float> view_depths = {};  // from fill_depths(), if already computed; or empty
  const TracedTiles* traced = nullptr;      // null: the whole picture
  std::span<const glm::vec2> motion;  // one a pixel, from sideray_frame_source::motion_texture; or empty
  uint32_t seed = 1;
  const std::atomic<bool>* cancelled = nullptr;  // polled between tiles
  WorkTime work;                                 // of lights and of the sky: tiles that it does not let begin are given up
  ViewFrame frame{};            // of `older`
  OlderMasks* older = nullptr;  // of the sequence: tiles without a turn show their history; null: they are lit
  const WantedTiles* wanted = nullptr;  // null: all tiles are; otherwise neither `kept` nor `older` reuses anything
};

// Returns whether two hosts' inputs produce the same masks.
bool ask_alike(const sideray_mask_inputs& a, const sideray_mask_inputs& b);

// Returns whether skipped tiles show their history.
inline bool has_older(const MaskRequest& request) {
  return request.older && is_bounded(request.work);
}

// Returns the layers of a set of lights: the indices of its bits, lowest first.
std::vector<uint32_t> lights_of(uint32_t mask);

// Returns the number of light masks that a request has: one a bit, lowest first, then the combined one.
uint32_t light_masks_of(uint32_t lights, bool combined);
uint32_t light_masks_of(const MaskRequest& request);
// Returns the same plus the layer of the unhidden sky, which is the last.
uint32_t mask_layers_of(const MaskRequest& request);

// Holds masks, layer-major as in LayerCache. 255 = lit or open, also where there is no surface.
struct OcclusionMasks {
  static constexpr uint32_t filter_tile = 16;  // side in pixels of the filters' tiles
  enum Seen : uint8_t { seen_dark = 1, seen_lit = 2 };

  uint32_t width = 0, height = 0, layers = 0;
  bool whole = true;  // no tile was skipped
  std::vector<uint8_t> lit;
  // Along the shadow ray from its origin, +inf = none, for occluded pixels. Measured in tiles of 16 pixels that, with
  // their neighbours, are neither all lit nor all dark. Empty unless requested.
  std::vector<float> hit_distance;
  std::vector<uint8_t> open;  // ambient; empty unless requested
  // Filters read these, and without filters they are empty. filter_distance: as hit_distance, where masks of lights are
  // filtered; open_distance: along the first ambient ray of each pixel.
  std::vector<float> filter_distance, open_distance;
  // Depth along the camera's axis, from fill_depths() (rt/history/frame_camera.h), and the error of the depth buffer in
  // its range 0..1. Empty unless requested (`moving`).
  std::vector<float> depth;
  float depth_step = 0;
  // Bits of Answer: which masks of each pixel are traced or reprojected from an earlier frame. The others are lit and
  // open. Empty: all have an answer.
  enum Answer : uint8_t { answer_of_lights = 1, answer_of_sky = 2 };
  std::vector<uint8_t> answers;
  // For the filters' tiles, layer-major, row by row: the bits of Seen in the tile, and whether any filter_distance in
  // it is finite.
  std::vector<uint8_t> seen, measured;

  // Transmittance of translucent surfaces between light and pixel, 255 = 1. A light's mask gets a place as soon as
  // something tints it, and keeps it until the masks change size; a place has a plane for each of red, green and blue.
  // The arriving light is the mask times these.
  static constexpr uint32_t tint_tile = 32;  // side of a tile in pixels
  uint32_t tints = 0;                // places
  std::vector<uint32_t> tint_places;  // for each layer of `lit` the place + 1; 0: it has none
  std::vector<uint8_t> tint;          // place by place, channel by channel
  std::vector<float> tint_distance;   // as filter_distance, by place
  std::vector<uint8_t> tint_tiles;    // by place, row by row: 1 = some pixel is not 255
  // For each place: whether the last frame had tints in it; whether red, green and blue differ in this one.
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
  // Returns whether a place has any tint.
  bool is_tinted(uint32_t place) const;
  // Gives a layer a place without tints.
  void add_tint(uint32_t layer, bool filtered);
  // Writes a tile of a place; null: without tints. Different tiles may be written at the same time.
  void store_tint(uint32_t place, size_t tile, const TintTile* found);
  // Finds the tiles with tints, after filtering and reprojection have spread them.
  // `is_white`: a layer's tile is known to have none.
  void find_tinted(Executor& executor, const std::function<bool(uint32_t layer, size_t tile)>& is_white);
  bool is_tile_tinted(uint32_t place, size_t tile);
  void forget_tints();

  uint32_t filter_columns() const { return (width + filter_tile - 1) / filter_tile; }
  uint32_t filter_rows() const { return (height + filter_tile - 1) / filter_tile; }
  size_t filter_index(uint32_t layer, uint32_t column, uint32_t row) const {
    return (size_t{layer} * filter_rows() + row) * filter_columns() + column;
  }
  // Returns whether a tile and its neighbours contain both lit and dark pixels of a light.
  bool in_penumbra(uint32_t layer, uint32_t column, uint32_t row) const;
};

}  // namespace sideray::rt
