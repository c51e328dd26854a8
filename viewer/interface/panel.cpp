#include "viewer/interface/panel.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "viewer/drawing/modes.h"
#include "viewer/interface/rows.h"

namespace sideray::viewer {
namespace {

const ImVec4 done_color{0.6f, 0.9f, 0.65f, 1}, error_color{1.0f, 0.66f, 0.5f, 1};
constexpr const char* hint = "Hover over a name for its help. Drop .glb, .gltf, .hdr or .exr files here.";
constexpr const char* keys =
    "left drag: around   right drag: look   middle drag: shift\n"
    "wheel: nearer   W A S D Q E: fly   F: all   Space: play\n"
    "C: compare   B: blink   M: map   I: inspect   Tab: panel\n"
    "Ctrl+S: save   Ctrl+C: copy   Ctrl+R: reload   Ctrl+Q: quit";

struct Choice {
  Comparison comparison;
  const char *name, *help;
};
constexpr Choice choices[] = {
    {Comparison::only_a, "A", "Shows A alone."},
    {Comparison::slider, "A | B", "Shows A on the left of a line and B on its right; drag the line."},
    {Comparison::only_b, "B", "Shows B alone."},
    {Comparison::map, "FLIP", "Shows how visible the differences of A and B are: dark where they look alike, bright where they differ."}};

constexpr const char* help_of_way =
    "as set: with the options of this panel\n"
    "raster: shadow maps, no rays\n"
    "hybrid: glass by rays where a rasterizer fails\n"
    "ray traced: all glass by rays\n"
    "reference: all by rays, more exact the longer the view stands still";

bool choose_way(const char* side, Way& way) {
  const Way before = way;
  begin_row(side);
  if (ImGui::BeginCombo("##way", name_of(way))) {
    for (size_t i = 0; i < way_count; ++i)
      if (ImGui::Selectable(way_names[i], way == static_cast<Way>(i))) way = static_cast<Way>(i);
    ImGui::EndCombo();
  }
  end_row(help_of_way);
  return way != before;
}

bool choose_mode(size_t& mode) {
  const size_t before = mode;
  begin_row("shows");
  ImGui::SetNextItemWidth(-FLT_MIN);
  if (ImGui::BeginCombo("##mode", modes()[mode].name, ImGuiComboFlags_HeightLarge)) {
    const char* group = "";
    for (size_t i = 0; i < modes().size(); ++i) {
      if (std::string(group) != modes()[i].group) ImGui::TextDisabled("%s", group = modes()[i].group);
      if (ImGui::Selectable(modes()[i].name, i == mode)) mode = i;
    }
    ImGui::EndCombo();
  }
  end_row("The colours of the picture, or another of its channels in false colours.");
  return mode != before;
}

double share(uint64_t part, uint64_t whole) {
  return whole == 0 ? 0.0 : 100.0 * static_cast<double>(part) / static_cast<double>(whole);
}

void draw_budget(const View& view, float default_ms) {
  std::string budget = view.options["budget"];
  if (budget.empty() && default_ms > 0) budget = fmt::format("{:.0f}", default_ms);
  ImGui::TextColored(pale, "while moving: %s", budget.empty() ? "smaller pictures" : (budget + " ms of rays a picture").c_str());
}

// Says what a budget leaves of a picture.
void draw_answers(const sideray_render_stats& s) {
  if (s.pixels_late + s.mask_pixels_late + s.pixels_older + s.mask_pixels_older == 0) return;
  ImGui::Text("pixels with no answer: %.1f %% glass, %.1f %% light", share(s.pixels_late, s.pixels_masked),
              share(s.mask_pixels_late, s.pixels_total));
  ImGui::Text("older answers: %.1f %% glass, %.1f %% light", share(s.pixels_older, s.pixels_masked),
              share(s.mask_pixels_older, s.pixels_total));
}

}  // namespace

void Panel::draw_head(const State& state, const Drawer::Shown& shown, bool is_loading) {
  if (state.view.scene) ImGui::TextUnformatted(state.view.scene->source().scene.c_str());
  ImGui::TextColored(pale, "%s   %ux%u%s", shown.device.c_str(), state.view.width, state.view.height,
                     is_loading ? "   loading ..." : "");
  explain("What draws, and the size of the picture. Rays alone: OpenGL is software, or off by --gl none.");
  // The height is fixed, so that controls do not move under the mouse; more lines scroll.
  ImGui::BeginChild("message", {0, 2 * ImGui::GetTextLineHeight()});
  ImGui::PushTextWrapPos(0);
  if (state.message.empty())
    ImGui::TextColored(pale, "%s", hint);
  else
    ImGui::TextColored(state.is_error ? error_color : done_color, "%s", state.message.c_str());
  ImGui::PopTextWrapPos();
  ImGui::EndChild();
}

void Panel::draw_comparison(State& state) {
  constexpr const char* names[sides] = {"A", "B"};
  for (size_t i = 0; i < sides; ++i) {
    ImGui::PushID(names[i]);
    if (choose_way(names[i], state.view.ways[i])) state.touch();
    ImGui::PopID();
  }
  for (const Choice& choice : choices) {
    if (ImGui::RadioButton(choice.name, state.comparison == choice.comparison)) state.comparison = choice.comparison;
    explain(choice.help);
    ImGui::SameLine();
  }
  ImGui::Checkbox("blink", &state.blinks);
  explain("Shows A and B in turn.");
  ImGui::SameLine();
  ImGui::Checkbox("inspect", &state.inspects);
  explain("Says of the pixel under the mouse what it shows, which surfaces lie behind it, and how old its answers are.");
  if (choose_mode(state.view.mode)) state.touch();
}

void Panel::draw_camera(State& state) {
  const SceneFile& scene = *state.view.scene;
  const auto& cameras = scene.content().cameras;
  const auto now = state.navigation.file_camera();
  const auto name_of_camera = [&](size_t i) { return cameras[i].name.empty() ? fmt::format("{}", i) : cameras[i].name; };
  const std::string shown = now && *now < cameras.size() ? name_of_camera(*now) : state.navigation.is_free() ? "moved" : "framed";
  begin_row("camera");
  if (ImGui::BeginCombo("##camera", shown.c_str())) {
    for (size_t i = 0; i < cameras.size(); ++i)
      if (ImGui::Selectable(name_of_camera(i).c_str(), now == i)) state.navigation.follow(i), state.touch();
    if (ImGui::Selectable("all of the scene")) state.navigation.follow(std::nullopt), state.touch();
    ImGui::EndCombo();
  }
  end_row("A camera of the file, or one that shows all of the scene; the mouse moves on from there.");
}

// Draws the choice of material variants (KHR_materials_variants).
void Panel::draw_variants(State& state) {
  const std::vector<std::string>& variants = state.view.scene->content().variants;
  if (variants.empty()) return;
  const std::string& now = state.view.scene->source().variant;
  begin_row("variant");
  if (ImGui::BeginCombo("##variant", now.empty() ? "as in the file" : now.c_str())) {
    if (ImGui::Selectable("as in the file", now.empty())) state.wanted_variant = "";
    for (const std::string& variant : variants)
      if (ImGui::Selectable(variant.c_str(), variant == now)) state.wanted_variant = variant;
    ImGui::EndCombo();
  }
  end_row("The file's variants of its materials.");
}

void Panel::draw_time(State& state) {
  const SceneFile& scene = *state.view.scene;
  if (!scene.moves()) return;
  auto time = static_cast<float>(state.view.time_s);
  begin_row("time");
  if (ImGui::SliderFloat("##time", &time, 0, static_cast<float>(std::max(scene.length_s(), 10.0)), "%.2f s")) {
    state.view.time_s = static_cast<double>(time);
    state.plays = false;
    state.moved_at = ImGui::GetTime();
    state.touch();
  }
  end_row("The moment of the animation.");
  ImGui::SameLine();
  if (ImGui::Button(state.plays ? "pause" : "play")) state.plays = !state.plays;
}

void Panel::draw_display(State& state) {
  int tonemap = static_cast<int>(state.view.display.tonemap);
  begin_row("exposure");
  bool is_changed = ImGui::SliderFloat("##exposure", &state.view.display.exposure_ev, -8, 8, "%.1f EV");
  end_row("Stops of exposure; each doubles the brightness.");
  begin_row("tonemap");
  if (ImGui::Combo("##tonemap", &tonemap, scenes::tonemap_names, static_cast<int>(std::size(scenes::tonemap_names)))) {
    state.view.display.tonemap = static_cast<scenes::Tonemap>(tonemap);
    is_changed = true;
  }
  end_row("How radiance becomes colours of the screen.");
  if (is_changed) state.touch();
}

void Panel::draw_options(State& state) {
  std::string message = state.is_error ? state.message : "";
  const std::string before = message;
  if (options_.draw(state.view.options, state.facts, message)) state.touch();
  if (message != before) state.complain(message);
}

void Panel::draw_times(const State& state, const Drawer::Shown& shown) {
  if (const auto& frame = shown.frames[0]) {
    draw_budget(state.view, shown.budget_ms);
    draw_answers(frame->stats);
  }
  graph_.draw(state.view.shown_sides);
}

Wish Panel::draw_buttons(bool is_charting) {
  Wish wish = Wish::nothing;
  const auto button = [&](const char* name, const char* help, Wish granted) {
    if (ImGui::Button(name)) wish = granted;
    explain(help);
  };
  button("copy as command line", "Copies the sideray render that draws the same picture.", Wish::copy_command);
  ImGui::SameLine();
  button("save picture", "Saves what is shown as a PNG in the working folder.", Wish::save_picture);
  ImGui::BeginDisabled(is_charting);
  button(is_charting ? "charting ..." : "chart this view",
         "Times other options on this view and measures their error, in minutes, in the working folder; then opens the page.",
         Wish::chart);
  ImGui::EndDisabled();
  ImGui::SameLine();
  button("reload", "Reads the file again.", Wish::reload);
  return wish;
}

Wish Panel::draw_scene(State& state, const Drawer::Shown& shown, bool is_charting) {
  ImGui::Separator();
  draw_comparison(state);
  draw_camera(state);
  draw_variants(state);
  draw_time(state);
  ImGui::Separator();
  draw_options(state);
  if (is_open("Display")) draw_display(state);
  if (is_open("Times", ImGuiTreeNodeFlags_DefaultOpen)) draw_times(state, shown);
  ImGui::Separator();
  const Wish wish = draw_buttons(is_charting);
  ImGui::TextColored(pale, "%s", keys);
  return wish;
}

Wish Panel::draw(State& state, const Drawer::Shown& shown, Place place, Busy busy) {
  Wish wish = Wish::nothing;
  for (size_t i = 0; i < sides; ++i) graph_.add(i, shown.frames[i]);
  ImGui::SetNextWindowPos({place.left, 0});
  ImGui::SetNextWindowSize({panel_width, place.height});
  ImGui::Begin("panel", nullptr, ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_AlwaysVerticalScrollbar);
  draw_head(state, shown, busy.loads);
  if (state.view.scene) wish = draw_scene(state, shown, busy.charts);
  ImGui::End();
  return wish;
}

}  // namespace sideray::viewer
