#include "cli/options/own_options.h"

#include <algorithm>

#include "scenes/images/images.h"

namespace sideray::cli {
namespace {

constexpr const char* gl_paths[] = {"auto", "egl", "osmesa", "none"};
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

// Makes rows that say what is drawn and from where.
OwnOption of_view(const char* after, sideray_option row) {
  return {row, after, true, true, true};
}

// Makes rows that say what happens to one picture.
OwnOption of_picture(const char* after, sideray_option row) {
  return {row, after, true, false, true};
}

// Makes rows for files and ways of running.
OwnOption of_run(const char* after, sideray_option row) {
  return {row, after, false, false, false};
}

// Returns the title of a row of the library's table.
const char* title_of(const char* name) {
  return sideray_option_find(name)->group;
}

const char* most_used() {
  return title_of("size");
}

sideray_option under(const char* group, sideray_option row) {
  row.group = group;
  return row;
}

sideray_option rare(sideray_option row) {
  row.advanced = 1;
  return row;
}

void add_views(std::vector<OwnOption>& list) {
  constexpr const char* title = "Camera and time";
  list.push_back(of_view("size", under(most_used(), text_row("camera", "NAME-OR-INDEX", "",
                                                           "a camera of the scene [the first, else all is framed]"))));
  list.push_back(of_view("size", under(title, text_row("eye", "X,Y,Z", "", "position of a camera of your own"))));
  list.push_back(of_view("size", under(title, text_row("target", "X,Y,Z", "", "the point that --eye looks at"))));
  list.push_back(of_view(
      "size",
      under(title, number_row(text_row("fov", "DEG", "", "vertical angle of view of --eye in degrees [45]"), 0.01, 179.0))));
  list.push_back(of_view("size", under(title, rare(text_row("intrinsics", "FX,FY,CX,CY", "",
                                                            "a calibrated camera's focal lengths and principal point")))));
}

void add_moments(std::vector<OwnOption>& list) {
  constexpr const char* after = "size";
  constexpr const char* title = "Camera and time";
  list.push_back({under(most_used(), text_row("frames", "A-B", "", "a sequence of frames, with name.####.exr as -o")),
                  after, false, true, true});
  list.push_back(of_view(
      after, under(title, number_row(text_row("fps", "F", "30", "frames per second of a sequence"), 1e-3, 1e6))));
  list.push_back(of_view(
      after, under(title, number_row(text_row("time", "T", "0", "moment of a single picture in seconds"), 0, 1e9))));
  list.push_back(
      of_view(after, under(title, text_row("animation", "NAME|all", "", "which animation plays [the first]"))));
  list.push_back(of_view(
      after, under(title, rare(text_row("variant", "NAME", "", "which variant of the materials is shown [none]")))));
}

void add_devices(std::vector<OwnOption>& list) {
  constexpr const char* after = "deadline";
  constexpr const char* title = "Machine";
  list.push_back(of_view(after, under(title, rare(choice("gl", gl_paths, "auto", "how OpenGL is reached")))));
  list.push_back(
      of_view(after, under(title, rare(text_row("device", "ID", "", "an id that sideray devices lists")))));
  list.push_back(of_view(
      after,
      under(title, rare(number_row(text_row("threads", "N", "", "threads that trace rays [all]"), 1, 1024)))));
}

void add_bounds(std::vector<OwnOption>& list) {
  constexpr const char* after = "seed";
  const char* const title = title_of(after);
  list.push_back(of_picture(
      after,
      under(title, number_row(text_row("max-ms", "X", "", "chooses the most accurate options within this time"), 1e-3,
                              1e9))));
  list.push_back(of_picture(
      after,
      under(title,
            number_row(text_row("max-error", "E", "", "chooses the fastest options within this mean FLIP"), 0, 1))));
}

void add_surroundings(std::vector<OwnOption>& list) {
  constexpr const char* after = "deadline";
  constexpr const char* title = "Surroundings";
  list.push_back(
      of_view(after, under(title, text_row("env", "sky|none|FILE", "sky", "surroundings; lat-long .exr or .hdr"))));
  list.push_back(of_view(
      after, under(title, rare(number_row(text_row("env-scale", "S", "1", "scales the radiance of the surroundings"), 0, 1e6)))));
  list.push_back(of_view(
      after, under(title, rare(number_row(text_row("env-rotate", "DEG", "0", "rotates the surroundings about +Y, counter-clockwise"),
                                          -36000, 36000)))));
  list.push_back(of_view(
      after,
      under(title, rare(choice("default-light", switches, "on", "a sun for files that have no light of their own")))));
}

void add_outputs(std::vector<OwnOption>& list) {
  constexpr const char* after = "reference";
  constexpr const char* title = "Output";
  list.push_back(of_run(after, under(most_used(), text_row("stats", "FILE", "", "writes counters and times as JSON"))));
  list.push_back(of_view(
      after, under(title, number_row(text_row("exposure", "EV", "0", "stops of exposure; PNG only"), -64, 64))));
  list.push_back(of_view(
      after, under(title, choice("tonemap", scenes::tonemap_names, "pbr-neutral", "how radiance becomes colours; PNG only"))));
  list.push_back(of_picture(after, under(title, text_row("aov", "LIST", "", "more channels, or all; .exr only"))));
  list.push_back(of_run(
      after, under(title, text_row("truth", "FILE.json", "", "writes box, masks and coverage of every object"))));
  list.push_back(
      of_run(after, under(title, text_row("compare", "REF", "", "prints metrics of the picture against this one"))));
}

void add_runs(std::vector<OwnOption>& list) {
  constexpr const char* after = "check";
  constexpr const char* title = "Many pictures";
  constexpr double most_frames = 1000000;
  list.push_back(of_run(after, under(title, text_row("jobs", "FILE.json", "", "draws many pictures in one process"))));
  list.push_back(of_run(after, under(title, flag_row("resume", "skips pictures that exist"))));
  list.push_back(of_run(
      after, under(title, rare(text_row("shard", "I/N|auto[/N]", "", "draws the I-th of N blocks of the frames")))));
  list.push_back(of_run(
      after, under(title, rare(number_row(text_row("warm-up", "F", "16", "frames drawn before a block, not written"), 0,
                                          most_frames)))));
}

std::vector<OwnOption> made_list() {
  std::vector<OwnOption> list{
      of_run("", under(most_used(), text_row("o", "IMAGE", "", "the picture to write, .exr or .png")))};
  for (auto* add : {add_views, add_moments, add_bounds, add_surroundings, add_devices, add_outputs, add_runs})
    add(list);
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
