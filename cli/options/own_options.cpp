#include "cli/options/own_options.h"

#include <algorithm>

#include "cli/options/comparison.h"

namespace sideray::cli {
namespace {

constexpr const char* gl_paths[] = {"auto", "egl", "osmesa"};
constexpr const char* tonemaps[] = {"none", "reinhard", "aces", "aces-filmic", "pbr-neutral"};
constexpr const char* switches[] = {"on", "off"};

template <size_t count>
sideray_option choice(const char* name, const char* const (&choices)[count], const char* default_value,
                      const char* help) {
  sideray_option row = text_row(name, "", default_value, help);
  row.type = SIDERAY_OPTION_CHOICE;
  row.choices = choices;
  row.choice_count = count;
  return row;
}

// Rows that say what is drawn and where from.
OwnOption of_view(const char* after, sideray_option row) {
  return {row, after, true, true, true};
}

// Rows that say what becomes of one picture.
OwnOption of_picture(const char* after, sideray_option row) {
  return {row, after, true, false, true};
}

// Files, and ways of running.
OwnOption of_run(const char* after, sideray_option row) {
  return {row, after, false, false, false};
}

void add_views(std::vector<OwnOption>& list) {
  list.push_back(of_view(
      "size", text_row("camera", "NAME-OR-INDEX", "",
                       "a camera of the file; without it the first one, and where there is none the scene is framed")));
  list.push_back(of_view("size", text_row("eye", "X,Y,Z", "", "where a camera of your own stands, with --target")));
  list.push_back(of_view("size", text_row("target", "X,Y,Z", "", "the point that it looks at")));
  list.push_back(of_view(
      "size", number_row(text_row("fov", "DEG", "", "its vertical angle of view in degrees [45]"), 0.01, 179.0)));
  list.push_back(of_view("size", choice("gl", gl_paths, "auto", "how OpenGL is reached")));
  list.push_back(of_view("size", text_row("device", "ID", "", "an id that sideray devices lists")));
}

void add_moments(std::vector<OwnOption>& list) {
  constexpr const char* after = "light-samples";
  list.push_back({text_row("frames", "A-B", "", "a sequence of frames, with name.####.exr as -o"), after, false, true, true});
  list.push_back(of_view(after, number_row(text_row("fps", "F", "30", "frames per second of a sequence"), 1e-3, 1e6)));
  list.push_back(of_view(
      after, number_row(text_row("time", "T", "0", "the moment of a single frame in seconds; animations loop"), 0, 1e9)));
  list.push_back(of_view(after, text_row("animation", "NAME|all", "", "which animation plays [the first]")));
  list.push_back(
      of_view(after, number_row(text_row("threads", "N", "", "how many threads trace rays [all]"), 1, 1024)));
}

void add_bounds(std::vector<OwnOption>& list) {
  constexpr const char* after = "deadline";
  list.push_back(of_picture(
      after, number_row(text_row("max-ms", "X", "",
                                 "chooses the most accurate configuration whose frame takes at most so long"),
                        1e-3, 1e9)));
  list.push_back(of_picture(
      after, number_row(text_row("max-error", "E", "",
                                 "chooses the cheapest configuration with this mean FLIP, on a reduced frame"),
                        0, 1)));
}

void add_surroundings(std::vector<OwnOption>& list) {
  constexpr const char* after = "deadline";
  list.push_back(of_view(
      after, text_row("env", "sky|none|FILE", "sky", "what surrounds the scene; a file is a lat-long .exr or .hdr")));
  list.push_back(
      of_view(after, number_row(text_row("env-scale", "S", "1", "a factor on the radiance of the surroundings"), 0, 1e6)));
  list.push_back(of_view(
      after, number_row(text_row("env-rotate", "DEG", "0",
                                 "turns the surroundings about +Y, counter-clockwise as seen from above"),
                        -36000, 36000)));
  list.push_back(of_view(after, choice("default-light", switches, "on", "a sun for files that have no light of their own")));
  list.push_back(of_view(after, number_row(text_row("exposure", "EV", "0", "stops of exposure; PNG only"), -64, 64)));
  list.push_back(
      of_view(after, choice("tonemap", tonemaps, "pbr-neutral", "how radiance becomes colours; PNG only")));
}

void add_outputs(std::vector<OwnOption>& list) {
  constexpr const char* after = "reference";
  list.push_back(of_picture(after, text_row("aov", "LIST", "", "additional channels, or all; .exr only")));
  list.push_back(of_run(
      after, text_row("truth", "FILE.json", "", "writes box, masks and coverage of every object, in COCO's layout")));
  list.push_back(of_run(after, text_row("stats", "FILE", "", "writes times and counters as JSON")));
}

void add_runs(std::vector<OwnOption>& list) {
  constexpr const char* after = "check";
  constexpr double most_frames = 1000000;
  list.push_back({number_row(text_row("repeat", "N", "1", "how often a frame is timed, after one untimed; with --stats"),
                             1, 10000),
                  after, true, false, false});
  list.push_back(of_run(after, flag_row("raw-frame", "gives times in raw frames too; with --stats")));
  list.push_back(of_run(after, text_row("jobs", "FILE.json", "", "draws many pictures in one process")));
  list.push_back(of_run(
      after, text_row("shard", "I/N|auto[/N]", "", "draws the I-th of N blocks of the frames, from 0; auto: as the scheduler says")));
  list.push_back(of_run(after, flag_row("resume", "skips what exists")));
  list.push_back(of_run(
      after, number_row(text_row("warm-up", "F", "16",
                                 "temporal methods: how many frames before a block are drawn and not written"),
                        0, most_frames)));
  list.push_back(of_run(after, text_row("compare", "REF", "", "prints metrics of the picture against this one")));
  for (const sideray_option* option : comparison_table()) list.push_back(of_run(after, *option));
}

std::vector<OwnOption> made_list() {
  std::vector<OwnOption> list{of_run("", text_row("o", "IMAGE", "", "the picture to write, .exr or .png"))};
  for (auto* add : {add_views, add_moments, add_bounds, add_surroundings, add_outputs, add_runs}) add(list);
  return list;
}

}  // namespace

const std::vector<OwnOption>& own_options() {
  static const std::vector<OwnOption> list = made_list();
  return list;
}

const OwnOption* find_own(const std::string& name) {
  const std::vector<OwnOption>& list = own_options();
  const auto at = std::find_if(list.begin(), list.end(), [&](const OwnOption& o) { return o.row.name == name; });
  return at == list.end() ? nullptr : &*at;
}

bool is_in_config(const std::string& name) {
  const OwnOption* own = find_own(name);
  return own ? own->in_config : sideray_option_find(name.c_str()) != nullptr;
}

}  // namespace sideray::cli
