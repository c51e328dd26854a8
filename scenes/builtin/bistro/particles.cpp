#include <fmt/format.h>

#include "scenes/builtin/bistro/bistro.h"
#include "scenes/builtin/smoke.h"

namespace sideray::scenes::bistro {
namespace {

using glm::vec3;

Shape ashtray() {
  return Shape().lathe({},
                       {{0, 0},
                        {0.042f, 0},
                        {0.048f, 0.006f},
                        {0.050f, 0.022f},
                        {0.047f, 0.024f},
                        {0.043f, 0.012f},
                        {0.034f, 0.007f},
                        {0, 0.006f}},
                       18);
}

struct Books {
  uint32_t smoke, flame;
};

// Adds a thread of smoke that widens and frays, lit by the lamps.
void add_smoke(Kit& kit, const std::string& name, vec3 at, int count, const Books& books) {
  kit.b.particles("smoke " + name, glm::dvec3(at),
                  fmt::format(R"({{"count": {}, "lifetime": [4.5, 6], "start": "sphere", "radius": 0.004,
    "velocity": [0, 0.14, 0], "spread": 0.012, "acceleration": [0.004, 0.006, 0.002], "drag": 0.25,
    "turbulence": 0.05, "turbulence_hz": 0.35, "size": [0.014, 0.05, 0.11, 0.17], "size_variation": 0.4,
    "color": [[0.75, 0.78, 0.85], [0.7, 0.7, 0.72]], "alpha": [0, 0.11, 0.07, 0.035, 0], "rotation_deg": [0, 360],
    "spin_deg": [-25, 25], "columns": 4, "rows": 4, "soft_distance": 0.05, "lit": true, "seed": {}}})",
                              count, kit.seed + 11),
                  books.smoke);
}

// Adds a flame of a few overlapping sprites, and the glow around it.
void add_flame(Kit& kit, const std::string& name, vec3 at, const Books& books) {
  const uint32_t seed = kit.seed * 131u + static_cast<uint32_t>(1e3f * (at.x + 5.0f)) * 7u;
  kit.b.particles("flame " + name, glm::dvec3(at + vec3(0, 0.064f, 0)),
                  fmt::format(R"({{"count": 6, "lifetime": 0.8, "start": "sphere", "radius": 0.001,
    "velocity": [0, 0.004, 0], "size": [0.018, 0.022, 0.018], "aspect": 2.4, "size_variation": 0.25,
    "color": [2.6, 2.2, 1.8], "alpha": [0, 0.5, 0], "rotation_deg": [-4, 4], "columns": 4, "rows": 4,
    "frames_per_second": 15, "random_frame": true, "blend": "additive", "seed": {}}})",
                              seed),
                  books.flame);
  kit.b.particles("sparks " + name, glm::dvec3(at + vec3(0, 0.070f, 0)),
                  fmt::format(R"({{"count": 24, "lifetime": [0.6, 1.2], "start": "sphere", "radius": 0.004,
    "velocity": [0, 0.06, 0], "spread": 0.02, "acceleration": [0, 0.05, 0], "turbulence": 0.01,
    "size": [0.0030, 0.0015], "color": [[1.8, 1.0, 0.35], [1.2, 0.35, 0.08]], "alpha": [0.3, 0.7, 0],
    "rotation_deg": [0, 360], "columns": 4, "rows": 4, "blend": "additive", "seed": {}}})",
                              seed + 1),
                  books.smoke);
}

}  // namespace

void add_particles(Kit& kit) {
  const Books books{paint_smoke(kit.b), paint_flame(kit.b)};
  for (size_t i = 0; i < kit.candles.size(); ++i) add_flame(kit, std::to_string(i), kit.candles[i], books);
  const uint32_t tray = kit.mesh("ashtray", ashtray);
  // On the table in front of the camera, among its glasses, and on the table next to the bar.
  const vec3 places[] = {{-1.235f, table_y, 1.545f}, {2.03f, table_y, -2.44f}};
  for (size_t i = 0; i < std::size(places); ++i) {
    kit.b.object(fmt::format("ashtray{}", i), tray, kit.m.china, glm::dvec3(places[i]));
    add_smoke(kit, std::to_string(i), places[i] + vec3(0, 0.012f, 0), 900, books);
  }
  // Steam rises from a grating in the street, behind the window panes.
  kit.b.particles("steam", {-0.6, -0.1, -8.2},
                  fmt::format(R"({{"count": 700, "lifetime": [4, 6], "start": "box", "box": [1.6, 0, 0.5],
    "velocity": [0.1, 0.55, 0], "spread": 0.12, "acceleration": [0.05, 0.02, 0], "drag": 0.3, "turbulence": 0.3,
    "turbulence_hz": 0.3, "size": [0.35, 0.9, 1.5], "size_variation": 0.4, "color": [0.8, 0.84, 0.9],
    "alpha": [0, 0.07, 0.04, 0], "rotation_deg": [0, 360], "spin_deg": [-15, 15], "columns": 4, "rows": 4,
    "soft_distance": 0.4, "lit": true, "seed": {}}})",
                              kit.seed + 21),
                  books.smoke);
  // Dust is lit by the lamps.
  kit.b.particles("dust", {0.3, 1.6, 0.2},
                  fmt::format(R"({{"count": 600, "lifetime": [6, 9], "start": "box", "box": [7, 2.4, 8],
    "spread": 0.03, "turbulence": 0.15, "turbulence_hz": 0.15, "size": [0.004], "size_variation": 0.6,
    "color": [0.9, 0.62, 0.35], "alpha": [0, 0.35, 0], "columns": 4, "rows": 4, "blend": "additive", "seed": {}}})",
                              kit.seed + 31),
                  books.smoke);
}

}  // namespace sideray::scenes::bistro
