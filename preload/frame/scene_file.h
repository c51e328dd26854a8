// The scene of a frame as a .glb file: --capture.
#pragma once

#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "preload/capture/draw_state.h"
#include "preload/capture/geometry.h"
#include "preload/capture/textures.h"

namespace sideray::run {

// Writes draws as nodes in eye space. Reflecting surfaces are blended; light maps are left out.
class SceneFile {
 public:
  SceneFile();
  void add(const Geometry& geometry, const DrawState& state, const Texture& texture, bool reflects);
  void set_camera(const Matrix& projection);
  // Returns false if the file cannot be written.
  bool write(const std::string& path);

 private:
  int append(const void* data, size_t size);
  int accessor(int view, int type, size_t count, const char* shape);
  int attribute(const Geometry& geometry, int components, const float* (*of)(const Vertex&));
  int material(const DrawState& state, const Texture& texture, bool reflects);
  int texture(const Texture& texture);

  nlohmann::ordered_json root_;
  std::string bytes_;
  std::map<uint64_t, int> textures_;
};

}  // namespace sideray::run
