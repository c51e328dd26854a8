// Holds particle systems of nodes (extras.sideray.particles; docs/gltf.md lists the keys): checked descriptions, and
// their sprites at a time. Any thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <sideray/sideray.hpp>
#include <string>
#include <vector>

#include "scenes/base/budget.h"

namespace sideray::scenes {

struct Content;

struct Range {
  double low = 0, high = 0;
};

// Lengths are in metres of the node's space, times in seconds, angles in degrees. Values over life are evenly spaced
// keys.
struct Particles {
  uint32_t count = 1;  // births in the longest lifetime
  Range lifetime{1, 1};
  enum class Start { point, box, sphere, cone } start = Start::point;
  glm::dvec3 box{0};                // side lengths
  double radius = 0, cone_deg = 0;  // cone: births on a disc about +Y, tilted outward by this angle at its rim
  glm::dvec3 velocity{0};
  double spread = 0;           // m/s, in every direction
  glm::dvec3 acceleration{0};  // world axes
  double drag = 0;             // share of the velocity lost per second
  double turbulence = 0, turbulence_hz = 1;
  std::vector<double> size{0.1}, alpha{1};
  std::vector<glm::dvec3> color{glm::dvec3(1)};
  double size_variation = 0, aspect = 1;  // height : width
  Range rotation_deg, spin_deg;
  double frames_per_second = 0;  // 0: the flip-book plays once in a life
  bool random_frame = false;
  uint32_t seed = 1;
  bool loop = true, prewarm = true;
  int texture = -1;               // in the file; -1 = none
  sideray_particles_desc desc{};  // without its texture
};

// Describes a node with a particle system.
struct Emitter {
  std::string node;
  double world_from_node[12] = {};
  std::string json;  // particles {...}, as read
  Particles particles;
  uint32_t texture = 0;                 // index + 1 into Content::textures; 0 = none
  std::vector<sideray_sprite> sprites;  // from the last simulate()
};

// Throws Error, which names file, node and key, if a value is wrong; unknown keys become warnings.
Particles parse_particles(const std::string& file, const std::string& node, const std::string& json,
                          Warnings& warnings);

// Returns the system's sprites at a time. A particle's state is a function of (seed, its number, the time), so times
// may come in any order.
std::vector<sideray_sprite> sprites_at(const Particles& particles, const double world_from_node[12], double time_s);

// Sets the sprites of all emitters.
void simulate(Content& content, double time_s);

// Replaces the sprites of system i + 1, which fill() adds for content.emitters[i], by the emitter's.
void set_sprites(Scene& scene, const Content& content);

}  // namespace sideray::scenes
