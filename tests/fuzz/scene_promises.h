// Checks promises that hold for any bytes given to the glTF loader. Test support; one thread.
#pragma once

#include <cmath>

#include "fuzz/fuzz.h"
#include "fuzz/memory_file.h"
#include "scenes/content/content.h"

namespace sideray::fuzz {

// Uses loaded content in every way; nothing of it may fail.
inline void use(const scenes::Content& content) {
  const sideray_camera camera =
      content.cameras.empty() ? scenes::framing_camera(content, 1.0f) : content.cameras[0].camera;
  for (const double m : camera.world_from_camera)
    if (!std::isfinite(m)) broken("cameras are finite", std::to_string(m));
  scenes::info_json(content);
  scenes::info_text(content);
  Scene scene = Scene::create().value();
  scenes::fill(scene, content, scenes::select_ray_traced(content, "auto", camera, 64, 64));
}

// A file is refused by one line, which is returned, or gives content that can be shown, and "".
inline std::string load_and_use(std::span<const uint8_t> bytes, const scenes::ReadLimits& limits = {}) {
  const bool binary = bytes.size() >= 4 && std::string(bytes.begin(), bytes.begin() + 4) == "glTF";
  static tests::MemoryFile glb(".glb"), gltf(".gltf");
  tests::MemoryFile& file = binary ? glb : gltf;
  file.put(bytes);
  scenes::LoadOptions options;
  options.limits = limits;
  scenes::Content content;
  try {
    content = scenes::load_file(file.path(), options);
  } catch (const Error& error) {
    check_message(error.what());
    return error.what();
  }
  try {
    use(content);
  } catch (const Error& error) {
    broken("what was loaded can be shown", error.what());
  }
  return "";
}

}  // namespace sideray::fuzz
