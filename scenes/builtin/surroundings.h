// What lights a scene from everywhere, by the names of --env. Any thread.
#pragma once

#include <sideray/sideray.hpp>
#include <string>

namespace sideray::scenes {

struct Surroundings {
  std::string name = "sky";           // "sky", "none" or a lat-long picture, .exr or .hdr
  float scale = 1, rotation_deg = 0;  // as sideray_scene_set_environment() has them
};

// Throws Error, which names the file, where a picture is none of surroundings.
void check_surroundings(const Surroundings& surroundings);
// Lets them light the scene, from its next commit on. Throws the same.
void set_surroundings(Scene& scene, const Surroundings& surroundings);

}  // namespace sideray::scenes
