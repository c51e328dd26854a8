// The device that draws: the GPU, or rays alone if OpenGL is software on the CPU. Any thread.
#pragma once

#include <mutex>
#include <string>

#include "viewer/base/arguments.h"

namespace sideray::viewer {

class Machine {
 public:
  explicit Machine(const Arguments& arguments);

  // Makes a renderer for pictures that only the rasterizer can draw, or for any picture. Throws Error if none can.
  Renderer renderer(bool needs_rasterizer);
  Tracer tracer(const Scene& scene) const;
  // The first call looks for devices, which takes a moment.
  bool is_software();
  std::string description();

 private:
  void probe();
  Renderer open(const std::string& gl) const;

  std::string gl_, device_;
  uint32_t threads_ = 0;
  std::once_flag probed_;
  bool is_software_ = true;
  std::string description_;
};

}  // namespace sideray::viewer
