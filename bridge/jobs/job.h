// A job makes one kind of output of a view's frames: it says what is read back, traces, filters and uploads. The
// service moves all jobs alike. Each object keeps one view's images, textures and history from frame to frame; trace()
// runs on the worker thread, everything else on the GL thread. While trace() runs, only check(), texture_reads() and
// the outputs are asked for.
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

// A frame as its jobs see it on either thread.
struct JobFrame {
  const FrameInputs& inputs;
  sideray_ticket ticket;
  const model::Snapshot& snapshot;  // the scene as it was when the frame was submitted
  rt::SequenceStep sequence;        // of this job's history
  bool multisampled;                // the target that depth was read from
};

// A texture of the host that is read back for a job, the rectangle of the frame's source.
struct TextureRead {
  const char* name = "";  // the input's, for errors
  uint32_t texture = 0;   // 0 = nothing is read
  ReadTexel texel = rgba_floats;
};
inline constexpr size_t most_textures_read = 2;
using TextureReads = std::array<TextureRead, most_textures_read>;

// The input of a trace; it is valid while trace() runs.
struct TraceInput {
  rt::Tracer& tracer;  // holds the frame's snapshot
  rt::DepthImage depth;
  std::span<const uint8_t> mask_bytes;                            // a pixel: SIDERAY_MASK_TEXTURE, _MEMORY
  std::array<std::span<const std::byte>, most_textures_read> textures;  // as texture_reads() says
  std::array<bool, most_textures_read> are_halfs{};  // whether the texels were read as halfs
  float subpixel;                                                 // by how much of a pixel vertices move, at most
  const std::atomic<bool>& cancelled;
  rt::WorkTime work;                // that rays have
  rt::ViewFrame frame;              // for what reprojects
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

  // Throws Failure (INVALID_ARGUMENT, UNSUPPORTED) that names the input of this job and what it may be.
  virtual void check(const gl::Functions& gl, const FrameInputs& inputs, const model::Snapshot& snapshot) const = 0;
  virtual bool reads_stencil(const FrameInputs& inputs) const = 0;
  virtual TextureReads texture_reads(const FrameInputs&) const { return {}; }
  // The share that the job may take of the time that is left under a deadline when tracing begins.
  virtual double share_of_time(const FrameInputs&) const { return 1.0; }

  // Fills the job's image.
  virtual rt::Counters trace(const JobFrame& frame, const TraceInput& input) = 0;

  // Makes everything that the next upload needs, so that the upload cannot fail. Leaves the outputs unchanged. Needs
  // unit 0 active, and guards over its textures and pixel transfer. Throws Failure.
  virtual void prepare(const gl::Functions& gl, const JobFrame& frame) = 0;
  // Moves the image's texels and returns their bytes. Needs guards over pixel transfer and unit 0's textures.
  virtual uint64_t upload(const gl::Functions& gl, const JobFrame& frame, const UploadWay& way) = 0;
  // Makes the outputs those of this frame.
  virtual void publish(const JobFrame& frame) = 0;
  virtual uint64_t texture_bytes() const = 0;

  // Called if the image that was traced last is not going to be uploaded.
  virtual void give_up() {}
  // Drops all OpenGL objects without calling OpenGL; there are no outputs any longer.
  virtual void abandon() = 0;
};

// Returns where a frame stands in its jobs' histories.
rt::SequenceStep sequence_step(const FrameInputs& inputs);

// Says until when a job's rays may begin under a deadline. `start`: when the frame was submitted.
rt::WorkTime time_of(const Job& job, const FrameInputs& inputs, rt::Deadline start);

}  // namespace sideray::bridge
