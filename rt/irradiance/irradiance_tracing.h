// Traces the light that other surfaces reflect onto a frame's opaque pixels: one path from one pixel of each cell of
// 2x2, accumulated over frames and filtered. It reuses its memory every frame. One call at a time. Row 0 of pixels is
// the bottom row.
#pragma once

#include <vector>

#include "rt/base/counters.h"
#include "rt/base/trace_end.h"
#include "rt/base/view_rays.h"
#include "rt/irradiance/irradiance_cells.h"
#include "rt/irradiance/irradiance_filter.h"
#include "rt/irradiance/irradiance_request.h"
#include "rt/scene/traced_scene.h"

namespace sideray::rt {

class IrradianceTracing {
 public:
  explicit IrradianceTracing(uint32_t threads);
  ~IrradianceTracing();
  // Traces `request` into `image`. Throws Failure.
  Counters trace(const IrradianceRequest& request, TracedScene& scene, IrradianceImage& image);

 private:
  struct Worker;  // scratch memory of one thread
  struct Frame;
  void find_places(const Frame& frame, Worker& worker, uint32_t tile);
  void prepare(const Frame& frame, Worker& worker, uint32_t tile);
  void meet_places(const Frame& frame, Worker& worker);
  void guess_places(const Frame& frame, Worker& worker, uint32_t tile);
  void see_sky(const Frame& frame, Worker& worker);
  static void see_through_veils(const Frame& frame, Worker& worker);
  TraceEnd trace_tile(const Frame& frame, Worker& worker, uint32_t tile);
  static Counters keep(IrradianceHistory& history, const IrradianceRequest& request);
  static void count_left(const Frame& frame, Worker& worker, uint32_t tile);
  Counters trace_frame(const IrradianceRequest& request, TracedScene& scene, IrradianceHistory* history,
                       const std::vector<uint8_t>& traced, IrradianceImage& image);
  void trace_all(const Frame& frame, const std::vector<uint8_t>& traced, Executor& executor);
  TileRows trace_rows(const Frame& frame, Executor& executor, IrradianceImage& image);
  TileRows trace_position(const Frame& frame, Executor& executor);

  std::vector<Worker> workers_;
  std::vector<glm::u16vec2> pixels_;  // by cell: the traced pixel
  // For a frame without history:
  IrradianceCells cells_;
  CellWalls walls_;
  std::vector<float> depths_;
  IrradianceFilter filter_;
};

}  // namespace sideray::rt
