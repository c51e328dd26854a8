#include <algorithm>
#include <array>

#include "scenes/builtin/bistro/bistro.h"
#include "scenes/builtin/builtin_scenes.h"

namespace sideray::scenes {
namespace {

using bistro::TablePlace;

// The first stands before the camera.
constexpr std::array<TablePlace, 8> places = {{{{-1.25f, 1.60f}, 150.0f, 1},
                                               {{0.85f, -0.45f}, 20.0f, 3},
                                               {{2.0f, -2.45f}, 70.0f, 3},
                                               {{-1.0f, -2.35f}, 10.0f, 3},
                                               {{-2.9f, -0.6f}, 45.0f, 3},
                                               {{1.3f, 2.5f}, 100.0f, 3},
                                               {{-2.9f, 3.6f}, 0.0f, 2},
                                               {{-3.0f, -2.9f}, 30.0f, 2}}};

constexpr size_t own_lights = 8;  // street, pendants, bar, sconce and candle

void add_cameras(ContentBuilder& b) {
  struct View {
    const char* name;
    glm::dvec3 eye, target;
    float fov_deg;
  };
  static constexpr View views[] = {{"main", {-1.6, 1.02, 2.9}, {0.92, 1.16, -2.25}, 40.0f},
                                   {"table", {-0.72, 1.16, 2.20}, {-1.32, 0.84, 1.52}, 42.0f},
                                   {"window", {0.2, 1.35, -0.9}, {-0.9, 1.15, -4.0}, 55.0f},
                                   {"overview", {-3.6, 2.6, 4.6}, {1.6, 0.7, -1.6}, 62.0f}};
  for (const View& v : views) b.camera(v.name, look_at(&v.eye.x, &v.target.x, v.fov_deg));
  // Moves past the laid tables at walking speed, 1.5 cm a frame.
  const glm::dvec3 eye(-1.75, 1.12, 3.0), target(0.6, 1.0, -2.2);
  b.dolly("dolly", look_at(&eye.x, &target.x, 42.0f), {0.9, 0.06, -1.5}, 4.0);
}

}  // namespace

Content make_bistro(const Numbers& numbers) {
  const auto lamps = static_cast<size_t>(numbers.whole_in_range("lamps", 0, 1024));
  const int tables = numbers.whole_in_range("tables", 1, static_cast<int>(places.size()));
  const int bottles = numbers.whole_in_range("bottles", 0, 4);
  bistro::Kit kit(static_cast<uint32_t>(numbers.whole_in_range("seed", 0, 1000000)));
  kit.m = bistro::make_materials(kit.b);
  add_cameras(kit.b);
  bistro::add_room(kit);
  bistro::add_windows(kit);
  bistro::add_street(kit);
  bistro::add_bar(kit);
  bistro::add_lamps(kit, static_cast<uint32_t>(lamps - std::min(lamps, own_lights)));
  for (int i = 0; i < tables; ++i) bistro::add_table(kit, i, places[static_cast<size_t>(i)], bottles);
  bistro::add_plant(kit, "0", {4.35f, 0.0f, -3.55f}, 1.25f, 22);
  bistro::add_plant(kit, "1", {-3.55f, 0.0f, -3.5f}, 1.35f, 24);
  bistro::add_plant(kit, "2", {-3.5f, 0.0f, 1.0f}, 1.15f, 20);
  bistro::add_particles(kit);
  Content content = kit.b.take();
  while (content.lights.size() > lamps) content.lights.pop_back();  // the lamps' meshes stay, and glow
  return content;
}

}  // namespace sideray::scenes
