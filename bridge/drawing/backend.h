// A backend draws the frames of pictures, and keeps what passes from one frame to the next. There are two: OpenGL with
// the service's rays beside it (bridge/raster), and rays alone (bridge/rays). One thread at a time.
#pragma once

#include <sideray/renderer.h>

#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <span>
#include <vector>

#include "bridge/base/handles.h"
#include "bridge/drawing/frame_counters.h"
#include "bridge/plan/frame_plan.h"
#include "gl/context/context.h"
#include "gl/passes/pass_inputs.h"
#include "model/snapshot.h"
#include "rt/cache/layer_cache.h"
#include "rt/composite/composite_image.h"
#include "rt/drawing/opaque_pixels.h"
#include "rt/masks/mask_request.h"

namespace sideray::bridge {

class FrameTimer;
struct PictureJob;

// A camera position within the pixel.
struct FramePosition {
  gl::RasterView view;
  uint32_t seed;
  uint32_t number = 0;  // Sequence::position()
};

// Says whether fragments are only drawn, or also counted and, where options say so, checked: an extra pass.
enum class Fragments { drawn, counted };

// Names the kinds of answers that rays give a pixel.
enum class AnswerOf { lights, sky, reflections, layers };

class Backend {
 public:
  virtual ~Backend() = default;
  Backend(const Backend&) = delete;
  Backend& operator=(const Backend&) = delete;

  virtual const gl::DeviceInfo& device() const = 0;
  virtual Drawing drawing() const = 0;

  // Begin and end a call of the renderer; all others are called between. Throws Failure where nothing can be drawn.
  virtual void begin_call() = 0;
  virtual void end_call() = 0;
  // Throws Failure (GL_FAILED) where the driver reported an error since the call began.
  virtual void require_no_errors() = 0;

  // Draws another scene from now on, whose tracer and snapshots are set next. Reuses its uploads and history where they
  // are still kept.
  virtual void change_scene(const sideray_scene* scene) = 0;
  // Frees everything kept for a scene that is not the current one and will not be drawn again.
  virtual void forget_scene(const sideray_scene* scene) = 0;
  // Sets the tracer of the scene, which must outlive its use.
  virtual void set_tracer(sideray_tracer* tracer) = 0;
  virtual void set_scene(std::shared_ptr<const model::Snapshot> snapshot) = 0;
  // Do what gl::Rasterizer's functions of the same names do.
  virtual void set_culled(std::span<const uint8_t> culled) = 0;
  virtual void resize(uint32_t width, uint32_t height) = 0;
  virtual gl::RasterView make_view(const sideray_camera& camera, glm::vec2 jitter) const = 0;

  virtual FrameCounters draw(PictureJob& job, const FramePosition& position, FrameTimer& timer, Fragments fragments) = 0;
  // Returns when all drawing is complete.
  virtual void finish() = 0;
  virtual void forget_shadow_maps() = 0;

  // Returns whether it can draw only some tiles of a picture (Sequence::wanted()); then it has average().
  virtual bool draws_parts() const = 0;
  virtual void average(const gl::FrameBefore& before) = 0;
  // Manage the temporal average, as gl::Rasterizer's functions do.
  virtual void keep_average() = 0;
  virtual void forget_averages() = 0;
  virtual void replace_average(const std::vector<glm::vec4>& picture) = 0;

  // Read the last frame, bottom row first, as gl::Rasterizer's functions do.
  virtual std::vector<glm::vec4> read_color() = 0;
  virtual std::vector<float> read_depth() = 0;
  virtual std::vector<uint8_t> read_stencil() = 0;
  virtual rt::OpaqueMaterials read_gbuffer() = 0;
  // Returns only OpaqueMaterials::ids.
  virtual std::vector<glm::uvec2> read_ids() { return read_gbuffer().ids; }
  virtual std::vector<glm::vec2> read_motion() = 0;
  // Counts the translucent surfaces of each pixel, up to gl::mask_stencil_bits, whatever mask the frame itself used.
  virtual std::vector<uint8_t> count_translucent(const PictureJob& job) = 0;
  // Returns the frame's first FramePlan::layers_to_show() layers.
  virtual const rt::LayerCache& read_layers(const PictureJob& job) = 0;
  // Return results of the frame's jobs; read_shadows: the first `bytes` of the masks, as they light the picture.
  virtual std::vector<uint8_t> read_shadows(size_t bytes) = 0;
  virtual const rt::OcclusionMasks& masks() const = 0;
  virtual const rt::CompositeImage& composite() const = 0;
  // Returns the answers of one kind, as MaskJob::answers() does.
  virtual std::vector<uint8_t> answers(AnswerOf of) const = 0;

 protected:
  Backend() = default;
};

}  // namespace sideray::bridge
