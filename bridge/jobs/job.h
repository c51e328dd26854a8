// A job makes one kind of output of a view's frames: it says what to read back, traces, filters and uploads. The
// service treats all jobs alike. Each object keeps one view's images, textures and history from frame to frame; trace()
// runs on the worker thread, everything else on the GL thread. While trace() runs, only check(), texture_reads() and
// the outputs may be used.
#pragma once

#include <sideray/sideray.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <span>

#include "bridge/base/frame_inputs.h"
#include "bridge/transport/texture_readback.h"
#include "bridge/transport/texture_upload.h"
#include "gl/context/functions.h"
#include "model/snapshot.h"
#include "rt/tracer.h"

namespace sideray::bridge {

// Holds a frame for its jobs, on either thread.
struct JobFrame {
  const FrameInputs& inputs;
  sideray_ticket ticket;
  const model::Snapshot& snapshot;  // the scene as it was when the frame was submitted
  rt::SequenceStep sequence;        // of this job's history
  bool multisampled;                // the target that depth was read from
};

// Describes a texture of the host that is read back for a job, within the rectangle of the frame's source.
struct TextureRead {
  const char* name = "";  // the input's name, for errors
  uint32_t texture = 0;   // 0 = nothing is read
  ReadTexel texel = rgba_floats;
};
inline constexpr size_t most_textures_read = 2;
using TextureReads = std::array<TextureRead, most_textures_read>;

// Holds the inputs of trace(), valid while it runs.
struct TraceInput {
  rt::Tracer& tracer;  // holds the frame's snapshot
  rt::DepthImage depth;
  std::span<const uint8_t> mask_bytes;                            // a byte per pixel: SIDERAY_MASK_TEXTURE, _MEMORY
  std::array<std::span<const std::byte>, most_textures_read> textures;  // in the order of texture_reads()
  std::array<bool, most_textures_read> are_halfs{};  // whether the texels were read as halfs
  float subpixel;                                                 // the most that vertices snap, in pixels
  const std::atomic<bool>& cancelled;
  rt::WorkTime work;                // the time and pieces that rays have
  rt::ViewFrame frame;              // the view's place in its history, for reprojection
  rt::ShadingQueue* shading_queue;  // SIDERAY_SHADE_IN_CALLS; otherwise null

  template <typename Texel>
  std::span<const Texel> texels(size_t texture) const {
    return {reinterpret_cast<const Texel*>(textures[texture].data()), textures[texture].size() / sizeof(Texel)};
  }
};

class Job {
 public:
  virtual ~Job() = default;

  virtual uint32_t bit() const = 0;  // SIDERAY_JOB_*

  // Throws Failure (INVALID_ARGUMENT, UNSUPPORTED) that names the input of this job and the values it may have.
  virtual void check(const gl::Functions& gl, const FrameInputs& inputs, const model::Snapshot& snapshot) const = 0;
  virtual bool reads_stencil(const FrameInputs& inputs) const = 0;
  virtual TextureReads texture_reads(const FrameInputs&) const { return {}; }
  // Returns the share of the time left under a deadline that the job may take when its tracing begins.
  virtual double share_of_time(const FrameInputs&) const { return 1.0; }

  // Fills the job's image.
  virtual rt::Counters trace(const JobFrame& frame, const TraceInput& input) = 0;

  // Allocates everything that the next upload needs, so that the upload cannot fail. Leaves the outputs unchanged.
  // Needs unit 0 active, and guards over its textures and pixel transfer. Throws Failure.
  virtual void prepare(const gl::Functions& gl, const JobFrame& frame) = 0;
  // Uploads the image's texels and returns their bytes. Needs guards over pixel transfer and unit 0's textures.
  virtual uint64_t upload(const gl::Functions& gl, const JobFrame& frame, const UploadWay& way) = 0;
  // Sets the outputs to those of this frame.
  virtual void publish(const JobFrame& frame) = 0;
  virtual uint64_t texture_bytes() const = 0;

  // Is called where the image that was traced last will not be uploaded.
  virtual void give_up() {}
  // Drops all OpenGL objects without calling OpenGL, and the outputs with them.
  virtual void abandon() = 0;
};

// Returns whether a frame is first, continues or repeats in its jobs' histories.
rt::SequenceStep sequence_step(const FrameInputs& inputs);

// Returns the limit of a job's rays under a deadline. `start`: when the frame was submitted.
rt::WorkTime time_of(const Job& job, const FrameInputs& inputs, rt::Deadline start);

}  // namespace sideray::bridge
