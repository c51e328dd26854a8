// Lists of configurations in JSON: sweep files and jobs files. Plain memory; any thread.
#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace sideray::lab {

using Configuration = std::map<std::string, std::string>;  // option without dashes -> its text; flags "true", "false"

// Parses an array of {option: value}, where values are strings, numbers or booleans. Throws Error whose text begins
// with the file, or with "FILE ENTRY_NAME INDEX", counted from 0.
std::vector<Configuration> parse_configurations(const nlohmann::json& list, const std::string& file,
                                                const std::string& entry_name);

// Returns text for people: "layers 4, mask count".
std::string describe(const Configuration& configuration);

// Holds the facts of a scene and of the machine that decide which points of a default list differ.
struct SweepScene {
  size_t translucent_objects = 0;
  size_t traceable_objects = 0;  // objects that `--ray-traced all` gives layers
  size_t layered_objects = 0;    // objects that `--ray-traced auto` gives layers
  size_t most_layers = 8;        // surfaces of these objects on one ray; 8: or more
  size_t most_events = 8;        // translucent surfaces on one ray; 8: or more
  bool has_particles = false;
  size_t lights = 0;           // that send light
  size_t swaying_objects = 0;  // moved by wind
  size_t swaying_copies = 0;   // of one mesh, at most
  bool has_cut_outs = false;   // opaque surfaces that `--diagnose inexact-target=model` selects
  bool has_gloss = false;      // opaque surfaces that `--reflections on` mirrors
  bool has_environment = false;
  bool auto_ao = false, auto_bounce = false, auto_reflections = false;  // `auto` traces them unless a point sets them
  double smallest_angle_deg = 180;  // of the smallest object in this view, as --cull-angle measures it
  bool by_rays = false;             // without OpenGL
  bool has_fragment_lists = false;  // what `--oit abuffer` needs
  bool is_sequence = false;
};

enum class Sweep { translucency, shadows, all };

struct DefaultSweep {
  std::vector<Configuration> configurations;  // no two that draw the same picture
  // Those of the configurations that a bound chooses from. Left out are those of another light, those for sequences
  // alone, exact but slow ones, and comparisons of the defaults of masks, steps and matches.
  std::vector<Configuration> choices;
  std::vector<std::string> left_out;  // reasons why points are missing
};

// Lists the configurations that differ in such a scene, from the cheapest rasterizer to everything by rays: at most 60
// points. Throws Error where the library refuses one.
DefaultSweep default_sweep(Sweep sweep, const SweepScene& scene);

// Holds an option and the values to try, the usual one first.
struct Axis {
  std::string option;
  std::vector<std::string> values;
};
// A way to draw or to shadow. Its first axis tells ways apart: it has one value, or is the only axis.
using Way = std::vector<Axis>;

// Both return the ways that a bound chooses from in such a scene, the usual one first; none where there is no choice.
std::vector<Way> ways_to_draw(const SweepScene& scene);
std::vector<Way> ways_to_shadow(const SweepScene& scene);

}  // namespace sideray::lab
