// Handles environments by the names of --env. Any thread.
#pragma once

#include <sideray/sideray.hpp>
#include <string>

namespace sideray::scenes {

struct Surroundings {
  std::string name = "sky";           // "sky", "none" or a lat-long picture, .exr or .hdr
  float scale = 1, rotation_deg = 0;  // as sideray_scene_set_environment() has them
};

// Throws Error, which names the file, where a picture is not an environment.
void check_surroundings(const Surroundings& surroundings);
// Sets the environment of the scene from its next commit on. Throws the same Error.
void set_surroundings(Scene& scene, const Surroundings& surroundings);

}  // namespace sideray::scenes
