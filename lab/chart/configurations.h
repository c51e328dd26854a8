// Lists of configurations in JSON: sweep files and jobs files. Plain memory; any thread.
#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace sideray::lab {

using Configuration = std::map<std::string, std::string>;  // option without dashes -> its text; flags "true", "false"

// An array of {option: value}, values strings, numbers or booleans. Throws Error that begins with the file or with
// "FILE ENTRY_NAME INDEX", counted from 0.
std::vector<Configuration> parse_configurations(const nlohmann::json& list, const std::string& file,
                                                const std::string& entry_name);

// "layers 4, mask count": for people.
std::string describe(const Configuration& configuration);

// Says what of a scene, and of the machine, decides which points of a default list can differ.
struct SweepScene {
  size_t translucent_objects = 0;
  size_t traceable_objects = 0;  // those that `--ray-traced all` gives layers
  size_t layered_objects = 0;    // those that `--ray-traced auto` does
  size_t most_layers = 8;        // of the latter on one ray; 8: as many or more
  size_t most_events = 8;        // of all translucent surfaces on one ray; 8: as many or more
  bool has_particles = false;
  size_t lights = 0;           // that send light
  size_t swaying_objects = 0;  // moved by wind
  size_t swaying_copies = 0;   // of one mesh, at most
  bool has_cut_outs = false;   // opaque surfaces that `--diagnose inexact-target=model` takes
  bool has_gloss = false;      // opaque surfaces that `--reflections on` mirrors
  bool has_environment = false;
  bool auto_ao = false, auto_bounce = false, auto_reflections = false;  // `auto` traces them, and points that say nothing leave it to it
  double smallest_angle_deg = 180;  // under which an object appears, as --cull-angle counts it in this view
  bool by_rays = false;             // nothing is rasterized
  bool has_fragment_lists = false;  // what `--oit abuffer` needs
  bool is_sequence = false;
};

enum class Sweep { translucency, shadows, all };

struct DefaultSweep {
  std::vector<Configuration> configurations;  // no two that draw the same picture
  // Those of them that a bound chooses from: others have another light or no use for a single picture, are as slow as
  // they are exact, or compare the defaults of masks, steps and matches.
  std::vector<Configuration> choices;
  std::vector<std::string> left_out;  // why it is shorter than it could be, a reason each
};

// Lists what there is to choose between in such a scene, from the cheapest rasterizer to everything by rays: at most 60
// points. Throws Error where the library refuses one.
DefaultSweep default_sweep(Sweep sweep, const SweepScene& scene);

// An option with the values to try of it, the usual one first.
struct Axis {
  std::string option;
  std::vector<std::string> values;
};
// A way to draw or to shadow: its first axis, which has one value or stands alone, says which way it is.
using Way = std::vector<Axis>;

// The ways between which a bound chooses in such a scene, the usual one first; none where there is nothing to choose.
std::vector<Way> ways_to_draw(const SweepScene& scene);
std::vector<Way> ways_to_shadow(const SweepScene& scene);

}  // namespace sideray::lab
