#include "viewer/interface/panel.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "viewer/drawing/modes.h"

namespace sideray::viewer {
namespace {

const ImVec4 pale{0.65f, 0.68f, 0.72f, 1}, warm{1.0f, 0.66f, 0.5f, 1};

bool choose_way(const char* label, Way& way) {
  bool is_changed = false;
  if (!ImGui::BeginCombo(label, name_of(way))) return false;
  for (size_t i = 0; i < way_count; ++i)
    if (ImGui::Selectable(way_names[i], way == static_cast<Way>(i))) way = static_cast<Way>(i), is_changed = true;
  ImGui::EndCombo();
  return is_changed;
}

bool choose_mode(size_t& mode) {
  bool is_changed = false;
  if (!ImGui::BeginCombo("shows", modes()[mode].name, ImGuiComboFlags_HeightLarge)) return false;
  const char* group = "";
  for (size_t i = 0; i < modes().size(); ++i) {
    if (std::string(group) != modes()[i].group) ImGui::TextDisabled("%s", group = modes()[i].group);
    if (ImGui::Selectable(modes()[i].name, i == mode)) mode = i, is_changed = true;
  }
  ImGui::EndCombo();
  return is_changed;
}

double share(uint64_t part, uint64_t whole) {
  return whole == 0 ? 0.0 : 100.0 * static_cast<double>(part) / static_cast<double>(whole);
}

}  // namespace

void Panel::draw_comparison(State& state) {
  ImGui::SetNextItemWidth(210);
  if (choose_way("A", state.view.ways[0])) state.touch();
  ImGui::SetNextItemWidth(210);
  if (choose_way("B", state.view.ways[1])) state.touch();
  constexpr std::pair<Comparison, const char*> choices[] = {
      {Comparison::only_a, "A"}, {Comparison::slider, "A | B"}, {Comparison::only_b, "B"}, {Comparison::map, "FLIP map"}};
  for (const auto& [comparison, name] : choices) {
    if (ImGui::RadioButton(name, state.comparison == comparison)) state.comparison = comparison;
    ImGui::SameLine();
  }
  ImGui::Checkbox("blink", &state.blinks);
  ImGui::SetNextItemWidth(210);
  if (choose_mode(state.view.mode)) state.touch();
  ImGui::SameLine();
  ImGui::Checkbox("inspect", &state.inspects);
}

void Panel::draw_camera(State& state) {
  const SceneFile& scene = *state.view.scene;
  const auto& cameras = scene.content().cameras;
  const auto now = state.navigation.file_camera();
  const auto name_of_camera = [&](size_t i) { return cameras[i].name.empty() ? fmt::format("{}", i) : cameras[i].name; };
  const std::string shown = now && *now < cameras.size() ? name_of_camera(*now) : state.navigation.is_free() ? "moved" : "framed";
  ImGui::SetNextItemWidth(210);
  if (ImGui::BeginCombo("camera", shown.c_str())) {
    for (size_t i = 0; i < cameras.size(); ++i)
      if (ImGui::Selectable(name_of_camera(i).c_str(), now == i)) state.navigation.follow(i), state.touch();
    if (ImGui::Selectable("all of the scene")) state.navigation.follow(std::nullopt), state.touch();
    ImGui::EndCombo();
  }
  draw_variants(state);
  if (!scene.moves()) return;
  if (ImGui::Button(state.plays ? "pause" : "play")) state.plays = !state.plays;
  ImGui::SameLine();
  auto time = static_cast<float>(state.view.time_s);
  ImGui::SetNextItemWidth(150);
  if (ImGui::SliderFloat("time", &time, 0, static_cast<float>(std::max(scene.length_s(), 10.0)), "%.2f s")) {
    state.view.time_s = static_cast<double>(time);
    state.plays = false;
    state.moved_at = ImGui::GetTime();
    state.touch();
  }
}

// Draws the choice of material variants (KHR_materials_variants).
void Panel::draw_variants(State& state) {
  const std::vector<std::string>& variants = state.view.scene->content().variants;
  if (variants.empty()) return;
  const std::string& now = state.view.scene->source().variant;
  ImGui::SetNextItemWidth(210);
  if (!ImGui::BeginCombo("variant", now.empty() ? "as in the file" : now.c_str())) return;
  if (ImGui::Selectable("as in the file", now.empty())) state.wanted_variant = "";
  for (const std::string& variant : variants)
    if (ImGui::Selectable(variant.c_str(), variant == now)) state.wanted_variant = variant;
  ImGui::EndCombo();
}

void Panel::draw_display(State& state) {
  int tonemap = static_cast<int>(state.view.display.tonemap);
  ImGui::SetNextItemWidth(170);
  bool is_changed = ImGui::SliderFloat("exposure", &state.view.display.exposure_ev, -8, 8, "%.1f EV");
  ImGui::SetNextItemWidth(170);
  if (ImGui::Combo("tonemap", &tonemap, scenes::tonemap_names, static_cast<int>(std::size(scenes::tonemap_names)))) {
    state.view.display.tonemap = static_cast<scenes::Tonemap>(tonemap);
    is_changed = true;
  }
  if (is_changed) state.touch();
}

void Panel::draw_times(const State& state, const Drawer::Shown& shown) {
  if (const auto& frame = shown.frames[0]) {
    const sideray_render_stats& s = frame->stats;
    ImGui::Text("picture %llu: %ux%u, %.1f ms", static_cast<unsigned long long>(shown.pictures), frame->width, frame->height,
                frame->ms);
    std::string budget = state.view.options["budget"];
    if (budget.empty() && shown.budget_ms > 0) budget = fmt::format("{:.0f}", shown.budget_ms);
    ImGui::TextColored(pale, "budget while moving: %s", budget.empty() ? "smaller pictures" : (budget + " ms of rays").c_str());
    if (s.pixels_late + s.mask_pixels_late + s.pixels_older + s.mask_pixels_older > 0) {
      ImGui::Text("pixels with no answer: %.1f %% glass, %.1f %% light", share(s.pixels_late, s.pixels_masked),
                  share(s.mask_pixels_late, s.pixels_total));
      ImGui::Text("older answers: %.1f %% glass, %.1f %% light", share(s.pixels_older, s.pixels_masked),
                  share(s.mask_pixels_older, s.pixels_total));
    }
  }
  graph_.draw();
}

Wish Panel::draw(State& state, const Drawer::Shown& shown, bool is_loading, bool is_charting, float left, float height) {
  Wish wish = Wish::nothing;
  for (size_t i = 0; i < sides; ++i) graph_.add(i, shown.frames[i]);
  ImGui::SetNextWindowPos({left, 0});
  ImGui::SetNextWindowSize({panel_width, height});
  ImGui::Begin("panel", nullptr, ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_AlwaysVerticalScrollbar);
  if (state.view.scene) ImGui::TextUnformatted(state.view.scene->source().scene.c_str());
  ImGui::TextColored(pale, "%s   %ux%u%s", shown.device.c_str(), state.view.width, state.view.height, is_loading ? "   loading ..." : "");
  // The height is fixed, so that controls do not move under the mouse; more lines scroll.
  ImGui::BeginChild("message", {0, 2 * ImGui::GetTextLineHeight()});
  ImGui::PushTextWrapPos(0);
  ImGui::TextColored(state.is_error ? warm : ImVec4{0.6f, 0.9f, 0.65f, 1}, "%s", state.message.c_str());
  ImGui::PopTextWrapPos();
  ImGui::EndChild();
  if (state.view.scene) {
    ImGui::Separator();
    draw_comparison(state);
    draw_camera(state);
    ImGui::Separator();
    std::string message = state.is_error ? state.message : "";
    const std::string before = message;
    if (options_.draw(state.view.options, state.facts, message)) state.touch();
    if (message != before) state.complain(message);
    if (ImGui::TreeNodeEx("Display", ImGuiTreeNodeFlags_NoTreePushOnOpen | ImGuiTreeNodeFlags_Framed)) draw_display(state);
    if (ImGui::TreeNodeEx("Times", ImGuiTreeNodeFlags_NoTreePushOnOpen | ImGuiTreeNodeFlags_Framed | ImGuiTreeNodeFlags_DefaultOpen))
      draw_times(state, shown);
    ImGui::Separator();
    if (ImGui::Button("copy as command line")) wish = Wish::copy_command;
    ImGui::SameLine();
    if (ImGui::Button("save picture")) wish = Wish::save_picture;
    ImGui::BeginDisabled(is_charting);
    if (ImGui::Button(is_charting ? "charting ..." : "chart this view")) wish = Wish::chart;
    ImGui::EndDisabled();
    ImGui::SameLine();
    if (ImGui::Button("reload")) wish = Wish::reload;
    ImGui::TextColored(pale, "left drag: around   right drag: look   middle drag: shift\n"
                             "wheel: nearer   W A S D Q E: fly   F: all   Space: play\n"
                             "C: compare   B: blink   M: map   I: inspect   Tab: panel\n"
                             "Ctrl+S: save   Ctrl+C: copy   Ctrl+R: reload   Ctrl+Q: quit");
  }
  ImGui::End();
  return wish;
}

}  // namespace sideray::viewer
