// Filters a frame's masks on the device, where rt/masks/mask_filters.h does not on the CPU. One object a sequence. GL
// thread.
#pragma once

#include <cstdint>
#include <map>
#include <memory>

#include "bridge/jobs/masks/mask_textures.h"
#include "bridge/transport/texture_upload.h"
#include "gl/context/functions.h"
#include "gl/passes/shadow_filter_pass.h"
#include "gl/resources/objects.h"
#include "rt/masks/kept_masks.h"
#include "rt/masks/mask_filters.h"
#include "rt/masks/mask_request.h"

namespace sideray::bridge {

class MaskDenoiser {
 public:
  struct Input {
    const rt::MaskFilters& filters;  // that know the frame
    const rt::OcclusionMasks& masks;
    const rt::KeptMasks& kept;  // which of them stay as they were filtered
    const model::Snapshot& snapshot;
    uint32_t lights;  // sideray_mask_inputs::shadow_lights
    bool combined_lights;
    bool unhidden;    // rt::MaskRequest::unhidden
    bool random;      // rt::is_random()
    uint32_t motion;  // 2D texture; 0 = the view's motion alone
    rt::SequenceStep sequence;
  };
  // Filters what `textures` holds, uploaded from the masks, but for those that are kept. Needs guards over draws,
  // framebuffers, the pixel transfer state and texture units 0 to 7; the units' textures, program and vertex array are
  // left changed. Returns the bytes moved. Throws Failure (OUT_OF_MEMORY, UNSUPPORTED, GL_FAILED).
  uint64_t denoise(const gl::Functions& gl, const Input& input, const MaskTextures& textures, const UploadWay& way);
  // Makes what the next call needs, so that it cannot fail. Needs guards over framebuffers, the pixel transfer state,
  // the program and the active unit's textures. Throws as that does. No other OpenGL error may be pending.
  void prepare(const gl::Functions& gl, const Input& input);
  void abandon();

 private:
  struct Filter {
    std::unique_ptr<gl::ShadowFilterPass> pass;
    shading::SfLight light{};  // of the last frame
    uint64_t last_frame = 0;   // as rt::FilterFrames::follows() keeps it
  };

  void allocate(const gl::Functions& gl, uint32_t width, uint32_t height);
  gl::ShadowFilterPass& pass_of(const gl::Functions& gl, uint32_t light);
  uint64_t upload_frame(const gl::Functions& gl, const Input& input, const UploadWay& way);
  uint64_t filter_one(const gl::Functions& gl, const Input& input, Filter& filter, const shading::SfLight& light,
                      const uint8_t* mask, const float* hit_distance, const UploadWay& way);
  void copy(const gl::Functions& gl, uint32_t from, uint32_t target, uint32_t to, uint32_t layer);
  static void keep(const Input& input, Filter& filter);

  std::map<uint32_t, Filter> filters_;  // by the light's index; the sky's behind all
  gl::Texture visibility_, hit_distance_, depth_, motion_;
  gl::Framebuffer from_, to_;
  TextureUpload upload_;
  uint32_t width_ = 0, height_ = 0, result_ = 0;
};

}  // namespace sideray::bridge
