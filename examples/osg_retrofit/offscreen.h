// Holds a headless OpenGL context of the engine, in the compatibility profile, with a pbuffer of colour, 24 bits of
// depth and 8 of stencil. It is current on the thread that made it until it is destroyed.
#pragma once

#include <string>

class Offscreen {
 public:
  // `platform`: "surfaceless" (Mesa), "device" (the first EGL device that works: NVIDIA without X), or "auto": both in
  // that order. Throws std::runtime_error.
  Offscreen(const std::string& platform, int width, int height, bool debug);
  ~Offscreen();
  Offscreen(const Offscreen&) = delete;
  Offscreen& operator=(const Offscreen&) = delete;

 private:
  void* display_ = nullptr;
  void* surface_ = nullptr;
  void* context_ = nullptr;
};
