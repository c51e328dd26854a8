// Traces a snapshot: layer cache, ray-ordered composite, ray batches. Plain memory; no OpenGL. Embree stays in
// rt/embree/embree_scene.cpp. Pixels: row 0 is the bottom row. All results are the same bits for any thread count.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "model/snapshot.h"
#include "rt/poses/foliage.h"

namespace sideray::rt {

struct TracerConfig {
  uint32_t threads = 0;  // 0 = all
  std::string isa;       // "", "sse4.2", "avx2", "avx512"
};

// Depth and stencil as a buffer read back in its native format.
enum class DepthFormat { d16, d24s8, d32f, d32f_s8 };
struct DepthImage {
  const std::byte* texels = nullptr;
  size_t row_bytes = 0;
  DepthFormat format = DepthFormat::d32f_s8;
};

struct TraceView {
  glm::dmat4 clip_from_local, local_from_clip;
  bool reversed_depth = false, zero_to_one_depth = false;
};

class LayerHistory;
class MaskFilters;
class ShadingQueue;

using Deadline = std::chrono::steady_clock::time_point;  // max() = none

// What a frame is in its sequence, for temporal rates.
enum class SequenceStep {
  first,  // nothing before it counts
  next,   // it follows the last frame of its history
  again   // it is the last frame once more, or another sample position of it
};

// What is known of the share of the picture that a cached layer's light becomes.
enum class LayerWeights {
  unknown,   // at most 1
  covers,    // at most the surface's cover
  objects,   // its cover, attenuated by objects drawn later: FrameRequest::drawn
  fragments  // its cover, attenuated by every nearer fragment
};

struct FrameRequest {
  TraceView view;
  uint32_t width = 0, height = 0;
  DepthImage depth;
  sideray_mask_source mask = SIDERAY_MASK_COUNT;
  uint32_t stencil_bits = 0x3f;
  std::span<const uint8_t> mask_bytes;  // a pixel: TEXTURE, MEMORY
  uint32_t max_layers = 4;              // composite: 0 = unlimited
  bool all_translucent = false;
  bool shadows = true;
  uint32_t light_samples = 0;  // composite: above 0, surfaces are shaded as in the reference
  sideray_step step = SIDERAY_STEP_MULTIHIT;
  sideray_cache_rate cache_rate = SIDERAY_RATE_FULL;
  SequenceStep sequence = SequenceStep::first;  // cache, temporal rates
  LayerHistory* history = nullptr;              // of its sequence; none: every masked pixel is shaded
  uint32_t asked_bits = 0;       // cache: not 0 = a second wave, which adds the pixels whose stencil has one of these
  bool denoise = false;          // cache: filter what rough surfaces reflect
  float layer_threshold = 0.0f;  // by which a pixel may be off for rays that are spared
  LayerWeights weights = LayerWeights::unknown;  // cache
  std::span<const uint32_t> drawn;  // LayerWeights::objects: of each instance, its place, back to front; 0 = not drawn
  bool refraction = false;          // composite
  bool particles = false;           // composite
  uint32_t seed = 1;
  const std::atomic<bool>* cancelled = nullptr;  // polled between chunks
  Deadline deadline = Deadline::max();           // chunks that have not begun by then have no answer
  ShadingQueue* shading_queue = nullptr;         // SIDERAY_SHADE_IN_CALLS: to the host's thread; none: shaded at once
};

// N layers a pixel, layer-major: texel (x, y) of layer k is at (k * height + y) * width + x. Kept from frame to frame
// by its owner: tiles traced last frame and not in this one are cleared to "no answer" and reported as dirty too.
struct LayerCache {
  static constexpr uint32_t tile_size = 32;
  uint32_t width = 0, height = 0, layers = 0;
  std::vector<uint16_t> radiance;  // four halfs a texel; alpha 1
  std::vector<float> distance;     // along the view ray; 0 = empty
  std::vector<uint32_t> surface_id;
  std::vector<uint8_t> traced_tiles;  // row-major, 1 = holds answers
  std::vector<uint8_t> dirty_tiles;   // 1 = changed by the last trace: upload these
};

// Every surface of the layers' set along the ray of every masked pixel, however many a cache would hold: those of texel
// i are surfaces[first[i]] to surfaces[first[i + 1] - 1], nearest first; x = bits of the float distance, y = surface
// id.
struct LayerTruth {
  uint32_t width = 0, height = 0;
  std::vector<uint32_t> first;
  std::vector<glm::uvec2> surfaces;
};

struct CompositeImage {
  uint32_t width = 0, height = 0;
  std::vector<uint16_t> radiance, transmittance;   // four halfs a texel; transmittance 1 where nothing was met
  std::vector<uint8_t> traced_tiles, dirty_tiles;  // as in LayerCache
  std::vector<glm::vec3> half_difference;          // of radiance, as in ReferenceImage; empty without light_samples
};

// Everything by rays, exact and unlimited: docs/adr/0006-reference.md.
struct ReferenceRequest {
  std::vector<TraceView> views;  // one a sample position
  uint32_t width = 0, height = 0;
  uint32_t light_samples = 64;
  bool shadows = true;
  bool refraction = false;
  bool reflections = false;  // of opaque surfaces: else they reflect the environment alone
  bool surfaces = false;     // keep what the first position sees
  uint32_t seed = 1;
  const std::atomic<bool>* cancelled = nullptr;  // polled between chunks
};

struct ReferenceSurface {
  glm::vec3 position;  // infinite where nothing is
  glm::vec3 normal;    // shading normal
  glm::vec3 albedo;
  float metallic, roughness;
  glm::uvec2 ids;  // surface id, primitive + 1
};

struct ReferenceImage {
  uint32_t width = 0, height = 0;
  std::vector<glm::vec4> color;            // mean over the positions; A = 1 - product of transmittances
  std::vector<glm::vec3> half_difference;  // color +- this: the halves of the light samples; 0 where there was one
  std::vector<ReferenceSurface> surfaces;  // opaque ones of the first position
};

// Where the ray of a pixel meets the first opaque surface that the rasterizer draws there.
struct OpaquePoint {
  double distance;   // along the ray; infinite = nothing
  glm::vec3 normal;  // geometric, unit
};

// Masks of opaque pixels: which share of each light's surface, or of the sky, they see.
struct MaskRequest {
  TraceView view;
  uint32_t width = 0, height = 0;
  DepthImage depth;
  float subpixel = 0x1p-9f;  // of a pixel, that the rasterizer moves a vertex by at most
  uint32_t lights = 0;       // bit i = light i
  uint32_t ao_rays = 0;      // a pixel; 0 = no such mask
  float ao_distance = INFINITY;
  sideray_inexact inexact = SIDERAY_EXACT;
  float inexact_bias = 0.5f;
  uint32_t inexact_bits = 0;                // of the stencil
  std::span<const glm::vec4> rest_offsets;  // a pixel: sideray_frame_inputs::rest_texture; or empty
  std::span<const OpaquePoint> points;      // a pixel: instead of the depth's, where both are one surface; or empty
  bool hit_distances = false;               // OcclusionMasks::hit_distance is wanted
  MaskFilters* filters = nullptr;           // of the sequence; none: masks stay as they were traced
  bool filters_later = false;               // they only learn of the frame; the masks are filtered elsewhere
  SequenceStep sequence = SequenceStep::first;
  std::span<const glm::vec2> motion;  // a pixel: sideray_frame_inputs::motion_texture; or empty
  uint32_t seed = 1;
  const std::atomic<bool>* cancelled = nullptr;  // polled between tiles
  Deadline deadline = Deadline::max();           // tiles that have not begun by then are lit
};

// Layer-major, as in LayerCache. 255 = lit, open; also where nothing was drawn.
struct OcclusionMasks {
  uint32_t width = 0, height = 0, layers = 0;
  std::vector<uint8_t> lit;
  // Along the shadow ray, from its origin, +inf = none: of occluded pixels in tiles of 16 pixels that are neither lit
  // nor dark, neighbours included. Empty unless asked for.
  std::vector<float> hit_distance;
  std::vector<uint8_t> open;  // ambient; empty unless asked for
  // The same of the pixels that filters read, and along the first of their ambient rays. Empty without filters.
  std::vector<float> filter_distance, open_distance;
};

// What glossy opaque surfaces mirror.
struct ReflectionRequest {
  TraceView view;
  uint32_t width = 0, height = 0;
  DepthImage depth;
  float subpixel = 0x1p-9f;              // as in MaskRequest
  std::span<const glm::vec4> normals;    // a pixel: shading normal, perceptual roughness; 0 where there is no surface
  std::span<const OpaquePoint> points;   // as in MaskRequest
  float max_roughness = 0.0f;            // rougher pixels are not traced
  bool shadows = true, denoise = false;  // denoise: filter what rough surfaces mirror
  uint32_t seed = 1;
  const std::atomic<bool>* cancelled = nullptr;  // polled between tiles
  Deadline deadline = Deadline::max();           // tiles that have not begun by then are not traced
  ShadingQueue* shading_queue = nullptr;         // as in FrameRequest
};

struct ReflectionImage {
  uint32_t width = 0, height = 0;
  std::vector<uint16_t> radiance;  // four halfs a texel; alpha: its share beside the prefiltered environment's
};

struct TraceCounters {
  uint64_t rays_primary = 0, rays_reflection = 0, rays_shadow = 0, rays_ao = 0;
  uint64_t pixels_total = 0, pixels_masked = 0;
  uint64_t layers_requested = 0, layers_found = 0, layers_shaded = 0, traversals_wasted = 0;
  uint64_t rays_spared = 0, layers_skipped = 0;  // as in sideray_frame_stats, like the next
  uint64_t points_shaded = 0, points_not_finite = 0;
  uint64_t pixels_late = 0;        // masked ones that the deadline left without an answer
  uint64_t dropped_particles = 0;  // composite: sprites in view that rays do not meet
  double trace_ms = 0, denoise_ms = 0, shadow_ms = 0, ao_ms = 0;
  void operator+=(const TraceCounters& other);
};

// Opaque surface seen through each pixel centre, by rays: for checks against the rasterizer.
struct PrimaryImage {
  std::vector<float> distance;    // +inf = nothing
  std::vector<glm::vec3> normal;  // shading normal
  std::vector<glm::uvec2> ids;    // surface id, primitive + 1
};

class Tracer {
 public:
  explicit Tracer(const TracerConfig& config);
  ~Tracer();
  Tracer(const Tracer&) = delete;
  Tracer& operator=(const Tracer&) = delete;

  // Builds or updates the acceleration structures. Throws Failure.
  void set_scene(std::shared_ptr<const model::Snapshot> snapshot);

  // Which poses of moving plants rays meet, and which instances look too small to be met: from the next set_scene,
  // trace or culled() on. Costs nothing where the options are those it has.
  void set_foliage(const FoliageOptions& options);
  // 1 = no ray meets the instance of the snapshot; empty = all are met. Holds until the next of the calls above.
  const std::vector<uint8_t>& culled();
  // What the last change of scene or foliage took: poses, refits, set-up and commits.
  double update_ms() const;

  TraceCounters trace_cache(const FrameRequest& request, LayerCache& cache);
  LayerTruth trace_truth(const FrameRequest& request);  // what a cache of this request is checked against
  TraceCounters trace_composite(const FrameRequest& request, CompositeImage& image);
  TraceCounters trace_masks(const MaskRequest& request, OcclusionMasks& masks);
  TraceCounters trace_reflections(const ReflectionRequest& request, ReflectionImage& image);
  TraceCounters trace_reference(const ReferenceRequest& request, ReferenceImage& image);
  PrimaryImage trace_primary(const TraceView& view, uint32_t width, uint32_t height);
  std::vector<OpaquePoint> trace_points(const TraceView& view, uint32_t width, uint32_t height);

  // Rays in local space; hits[i * layers + k]. Arguments are checked by the caller.
  void trace_rays(sideray_ray_set set, std::span<const sideray_ray> rays, uint32_t layers, sideray_hit* hits);

  uint32_t threads() const;
  std::string isa() const;     // what is used, e.g. "avx2"
  std::string embree() const;  // "3.13.5"

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace sideray::rt
