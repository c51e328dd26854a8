// Describes what the rasterizer's passes draw. Plain values; any thread may use them.
#pragma once

#include <sideray/renderer.h>

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <memory>
#include <span>

#include "gl/scene/raster_view.h"
#include "model/snapshot.h"

namespace sideray::gl {

// Says which fragments count in the mask and take their shading from the layer cache. all_translucent includes multiply
// surfaces: rays hit them, each at its place in the order.
enum class TracedSet { none, visible_in_layers, all_translucent };

enum class MaskKind { stencil, count };  // stencil: 1 where anything is; count: number of layers, saturating

// The low stencil bits hold the mask; all bits set means "at least that many".
inline constexpr uint32_t mask_stencil_bits = 0x3f;
// Set where a fragment requests the second wave.
inline constexpr uint32_t asked_stencil_bit = 0x40;

// Until the composite begins, the same bit is set where a translucent surface is drawn that is not traced. Frames that
// use it have no second wave.
inline constexpr uint32_t others_stencil_bit = 0x40;
// While translucent surfaces are drawn, the same bit is set in whole pixels, where no fragment is drawn.
inline constexpr uint32_t whole_stencil_bit = 0x40;

// Set where the shadow rays of an opaque pixel take the inexact test: model::takes_inexact.
inline constexpr uint32_t inexact_stencil_bit = 0x80;

struct FragmentCounts {
  uint64_t matched = 0, missed = 0;  // fragments of traced objects that took / did not take a layer
  uint64_t misassigned = 0;          // fragments that took a layer of another surface
};

// Names the masks of opaque pixels, textures of the frame's size.
struct OcclusionTextures {
  // 2D array with a layer for each bit of shadow_lights, lowest first, then one for combined_lights; 1 = lit. 0: none.
  uint32_t shadow = 0;
  uint32_t shadow_lights = 0;    // bit i = light i
  bool combined_lights = false;  // lights from number 32 on share a mask; a light without a mask has a shadow map
  uint32_t tint = 0;           // 2D array, red, green, blue that translucent surfaces let pass, by light; 0: all
  int tint_layers[33] = {};    // of light i, [32] of the combined ones: the first of three layers, from 1; 0: none
  uint32_t answers = 0;        // 2D, 255 times: 1, the lights' masks are known, + 2, the sky's is; 0: all are known
  uint32_t open = 0;           // 2D, ambient occlusion as the visible share of the sky; 0: all of it is visible
  int unhidden_layer = -1;     // layer of `shadow`: the share that nothing opaque hides; -1: the same as `open`
  uint32_t bounced = 0;        // 2D, light of other surfaces over pi, A = 0: not known; or 0
  uint32_t mirrored = 0;       // 2D, radiance from the mirror direction, A its weight against the environment's; or 0
};

// Says what Rasterizer::mark_inexact marks.
struct InexactMarks {
  sideray_inexact_target target = SIDERAY_TARGET_STENCIL;
  bool rest = false;                    // also fill rest_texture()
  uint32_t poses = SIDERAY_POSES_REST;  // the poses that rays hit, as sideray_pose_options::poses
};

// Describes the previous frame, from which motion is measured.
struct FrameBefore {
  RasterView view;
  std::shared_ptr<const model::Snapshot> snapshot;  // null: none
};

// Lists all traced surfaces along each pixel's ray; surfaces[first[i]] to surfaces[first[i + 1] - 1] are on that of
// pixel i. x = bits of the float distance, y = surface id.
struct LayerTruth {
  std::span<const uint32_t> first;
  std::span<const glm::uvec2> surfaces;
};

// Names the textures of whole pixels: colour = radiance + colour * transmittance where the transmittance's alpha is 1.
// RGBA16F, of the frame's size; 0 = no pixel is whole.
struct WholeTextures {
  uint32_t radiance = 0, transmittance = 0;
};

// Describes a pass that draws translucent surfaces.
struct Translucency {
  bool shadows = true;
  TracedSet traced = TracedSet::none;
  sideray_oit oit = SIDERAY_OIT_SORTED;
  uint64_t most_list_bytes = uint64_t{256} << 20;  // the most memory for the fragments of SIDERAY_OIT_ABUFFER at a time
  std::function<void(uint32_t program, uint32_t first_unit)> bind_cache;
  bool refracted = false;  // cached surfaces may hide what is behind them: sideray_look_up()
  bool aside = false;      // surfaces that bend or blur light sample the opaque picture where the cache has no answer
  WholeTextures whole;  // only with SIDERAY_OIT_SORTED and _ABUFFER
  bool count_fragments = false;       // fill FragmentCounts (an extra pass); otherwise they are 0
  const LayerTruth* truth = nullptr;  // if set, counting also counts misassigned fragments
};

}  // namespace sideray::gl
