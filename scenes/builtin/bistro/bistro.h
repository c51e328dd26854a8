// The parts of the built-in bistro, which bistro.cpp puts together. Metres; y up; the windows look along -z.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <string>
#include <vector>

#include "scenes/builtin/paint.h"
#include "scenes/content/shapes.h"

namespace sideray::scenes::bistro {

// The room. Beyond the windows lies the street.
constexpr float left_x = -4.0f, right_x = 4.7f, window_z = -4.0f, back_z = 5.0f, ceiling_y = 3.3f;
constexpr float table_y = 0.75f;
constexpr glm::vec3 warm(1.0f, 0.64f, 0.33f);  // of lamplight
// The environment is an open daylight sky, and nothing occludes diffuse surfaces from it. Their occlusion textures
// reduce it to dusk, inside and in the street.
constexpr float room_ambient = 0.22f, street_ambient = 0.6f;

struct Materials {
  // Opaque.
  uint32_t floor, plaster, ceiling, panel, walnut, table_top, bar_top, brass, steel, iron, china, velvet, leather, cane,
      linen, paper, leaf, stem, terracotta, soil, wax, cork, foil, chalkboard, gilt, frame, bread, lemon, petal;
  std::array<uint32_t, 4> labels;
  std::array<uint32_t, 3> paintings;
  // Light.
  uint32_t bulb, opal, flame;
  // Translucent: closed solids, then single panes.
  uint32_t clear, crystal, shade_glass;
  std::array<uint32_t, 4> bottle_glass;
  std::array<uint32_t, 4> drinks;
  uint32_t water, window, vitrine, mirror;
  std::array<uint32_t, 3> stained;
  // The street.
  uint32_t cobbles, pavement, sky, lit_window, dark_window, shopfront, street_globe, awning;
  std::array<uint32_t, 3> facades;
};

// Holds meshes by name, each made once and placed often.
class Kit {
 public:
  explicit Kit(uint32_t scene_seed) : seed(scene_seed) {}
  // Returns a random number that depends on its arguments and `seed`, not on the order of calls.
  float random(uint32_t what, uint32_t which = 0) const { return hash01(what, which, seed); }
  template <typename Make>
  uint32_t mesh(const std::string& name, const Make& make) {
    const auto [found, is_new] = meshes_.try_emplace(name, 0);
    if (is_new) found->second = b.mesh(make(), name);
    return found->second;
  }

  ContentBuilder b{"bistro"};
  Materials m{};
  uint32_t seed;
  std::vector<glm::vec3> candles;  // positions of those already placed
  uint32_t coarseness = 1;         // of the next glassware: 0 on the camera's table, 2 on the far shelves

 private:
  std::map<std::string, uint32_t> meshes_;
};

Materials make_materials(ContentBuilder& b);
void add_room(Kit& kit);
void add_windows(Kit& kit);
void add_street(Kit& kit);
void add_bar(Kit& kit);
// Adds the lamps of room and tables, and `small_bulbs` small ones under the ceiling.
void add_lamps(Kit& kit, uint32_t small_bulbs = 0);

struct TablePlace {
  glm::vec2 at;  // x, z
  float turn_deg;
  int chairs;
};
// Adds a table with `bottles` bottles on it.
void add_table(Kit& kit, int index, const TablePlace& place, int bottles);

// The functions for glassware add closed solids that stand on `at`, with names that end in `suffix`.
enum class Glass { red_wine, white_wine, flute, coupe, tumbler, tall, snifter, carafe, decanter };
enum class Bottle { bordeaux, burgundy, spirit, flask };
// `drink` is an index into Materials::drinks, or -1 for an empty glass; `fill` 1 is the usual height.
void add_glass(Kit& kit, Glass glass, const std::string& suffix, glm::vec3 at, int drink, float fill = 1.0f);
void add_bottle(Kit& kit, Bottle bottle, const std::string& suffix, glm::vec3 at, int tint, int label, float fill,
                float turn_deg);
// Adds a votive candle: a tumbler with wax and a flame in it.
void add_candle(Kit& kit, const std::string& suffix, glm::vec3 at);
// Adds flames on the candles placed so far, smoke and steam.
void add_particles(Kit& kit);
void add_plant(Kit& kit, const std::string& suffix, glm::vec3 at, float height, uint32_t leaves);

}  // namespace sideray::scenes::bistro
