// Parses lists of configurations from JSON (sweep files and jobs files), and lists default ones. Plain memory; any
// thread.
#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace sideray::lab {

using Configuration = std::map<std::string, std::string>;  // option without dashes -> its text; flags are "true" or
                                                           // "false"

// Parses an array of {option: value}; values are strings, numbers or booleans. Throws an Error that begins with the
// file or with "FILE ENTRY_NAME INDEX", where indices start at 0.
std::vector<Configuration> parse_configurations(const nlohmann::json& list, const std::string& file,
                                                const std::string& entry_name);

// Returns a readable text: "layers 4, mask count".
std::string describe(const Configuration& configuration);

// Holds the facts about scene and machine that decide which points of a default list can differ.
struct SweepScene {
  size_t translucent_objects = 0;
  size_t traceable_objects = 0;  // objects with layers under `--ray-traced all`
  size_t layered_objects = 0;    // objects with layers under `--ray-traced auto`
  size_t most_layers = 8;        // most of these on one ray; 8: eight or more
  size_t most_events = 8;        // most translucent surfaces on one ray; 8: eight or more
  bool has_particles = false;
  size_t lights = 0;           // lights that emit
  size_t swaying_objects = 0;  // moved by wind
  size_t swaying_copies = 0;   // the most of them that share one mesh
  bool has_cut_outs = false;   // opaque surfaces that `--diagnose inexact-target=model` selects
  bool has_gloss = false;      // opaque surfaces that `--reflections on` traces
  bool has_environment = false;
  bool auto_ao = false, auto_bounce = false, auto_reflections = false;  // `auto` traces these; points that do not name
                                                                        // the option use it
  double smallest_angle_deg = 180;  // smallest angle that an object subtends, as --cull-angle measures it in this view
  bool by_rays = false;             // without a rasterizer
  bool has_fragment_lists = false;  // `--oit abuffer` is supported
  bool is_sequence = false;
};

enum class Sweep { translucency, shadows, all };

struct DefaultSweep {
  std::vector<Configuration> configurations;  // no two draw the same picture
  // Those that a bound chooses from. Others have different light, do not suit a single picture, are as slow as they are
  // exact, or only compare the defaults of masks, steps and matches.
  std::vector<Configuration> choices;
  std::vector<std::string> left_out;  // why points are missing, one reason each
};

// Lists the points to compare in such a scene, from the cheapest rasterizer to everything by rays: at most 60. Throws
// Error if the library refuses one.
DefaultSweep default_sweep(Sweep sweep, const SweepScene& scene);

// An option with values to try, the usual one first.
struct Axis {
  std::string option;
  std::vector<std::string> values;
};
// A way to draw or to shadow. Its first axis, which has one value or stands alone, names the way.
using Way = std::vector<Axis>;

// Return the ways from which a bound chooses in such a scene, the usual one first; none if there is no choice.
std::vector<Way> ways_to_draw(const SweepScene& scene);
std::vector<Way> ways_to_shadow(const SweepScene& scene);

}  // namespace sideray::lab
