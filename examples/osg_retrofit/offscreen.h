// A headless OpenGL context, compatibility profile, that belongs to the engine: a pbuffer with colour, 24 bits of depth
// and 8 of stencil. It is current on the thread that created it until it is destroyed.
#pragma once

#include <string>

class Offscreen {
 public:
  // `platform`: "surfaceless" (Mesa), "device" (the first EGL device that works: NVIDIA without X), or "auto", which
  // tries both in that order. Throws std::runtime_error.
  Offscreen(const std::string& platform, int width, int height, bool debug);
  ~Offscreen();
  Offscreen(const Offscreen&) = delete;
  Offscreen& operator=(const Offscreen&) = delete;

 private:
  void* display_ = nullptr;
  void* surface_ = nullptr;
  void* context_ = nullptr;
};
