// Traces a frame's translucent surfaces and composites them along straight or refracted rays. It reuses its memory
// every frame. One call at a time.
#pragma once

#include <vector>

#include "rt/base/counters.h"
#include "rt/composite/composite_image.h"
#include "rt/composite/composite_sink.h"
#include "rt/composite/filtered_sink.h"
#include "rt/layers/frame_chunks.h"
#include "rt/layers/layer_tracer.h"
#include "rt/layers/sprite_lights.h"
#include "rt/refraction/refracting_sink.h"
#include "rt/refraction/refraction_tracer.h"
#include "rt/scene/traced_scene.h"
#include "rt/shading/frame_shaders.h"

namespace sideray::rt {

class CompositeTracing {
 public:
  explicit CompositeTracing(uint32_t threads) : sprites_(threads), shaders_(threads), workers_(threads) {}
  // Traces `request` into `image`. `exact`: shaders that make two estimates, for a request with light samples;
  // otherwise null. Throws Failure.
  Counters trace(const LayerRequest& request, TracedScene& scene, ShaderSource* exact, CompositeImage& image);

 private:
  struct Worker {
    LayerTracer layers;
    std::vector<CompositeSink::Pixel> pixels;
    RefractionTracer refraction;
    std::vector<RefractedPixel> refracted_pixels;
    std::vector<FilteredSink::Pixel> filtered_pixels;
    RefractingScratch refracting;
    Counters counters;
  };
  ShaderSource& begin_shaders(const LayerRequest& request, TracedScene& scene);
  FrameChunks::Trace along_straight_rays(const FrameContext& context, ShaderSource& shaders, CompositeImage& image);
  FrameChunks::Trace along_refracted_rays(const RefractionContext& context, ShaderSource& shaders,
                                          CompositeImage& image);

  // Makes straight rays end at surfaces that bend light, and resolves the light there. `bent`: null if nothing bends
  // light.
  FrameChunks::Trace to_resolved_surfaces(const FrameContext& straight, const RefractionContext* bent,
                                          ShaderSource& shaders, CompositeImage& image);

  FrameChunks chunks_;
  FilteredSurfaces filtered_;
  SpriteLights sprites_;
  FrameShaders shaders_;
  KeptRefractionScene refraction_;
  std::vector<Worker> workers_;
};

}  // namespace sideray::rt
