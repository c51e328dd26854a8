#include "viewer/interface/picture_area.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "viewer/drawing/modes.h"
#include "viewer/interface/inspection_text.h"

namespace sideray::viewer {
namespace {

constexpr ImU32 white = IM_COL32(255, 255, 255, 255), shade = IM_COL32(0, 0, 0, 170), red = IM_COL32(255, 150, 130, 255);
constexpr float margin = 8;

void draw_label(ImVec2 place, const std::string& text, ImU32 color, float width) {
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const ImVec2 size = ImGui::CalcTextSize(text.c_str(), nullptr, false, width);
  list.AddRectFilled({place.x - 5, place.y - 3}, {place.x + size.x + 5, place.y + size.y + 3}, shade, 3);
  list.AddText(ImGui::GetFont(), ImGui::GetFontSize(), place, color, text.c_str(), nullptr, width);
}

// Draws the inspection text at the bottom, on the side away from the mouse.
void draw_inspection(const State& state, const Drawer::Shown& shown, ImVec2 size) {
  if (!state.inspects || !state.view.scene) return;
  const std::string text = inspection_text(state, shown);
  const float most = std::max(0.6f * size.x, 200.0f);
  const ImVec2 extent = ImGui::CalcTextSize(text.c_str(), nullptr, false, most);
  const ImVec2 mouse = ImGui::GetIO().MousePos;
  const bool is_left = mouse.x > extent.x + 4 * margin || mouse.y < size.y - extent.y - 4 * margin;
  const float left = is_left ? margin : std::max(size.x - extent.x - margin, margin);
  draw_label({left, std::max(size.y - extent.y - margin, margin)}, text, white, most);
}

std::string label_of(const State& state, const Frame& frame, size_t side) {
  const std::string name = fmt::format("{}: {}", side == 0 ? "A" : "B", name_of(frame.way));
  if (modes()[state.view.mode].coloring == Coloring::age) return fmt::format("{}   {}", name, age_legend);
  if (state.view.mode != 0) return name;
  if (frame.is_preview || frame.number != state.view.number)
    return fmt::format("{}   {}x{}, {:.0f} ms", name, frame.width, frame.height, frame.ms);
  return fmt::format("{}   {} of {} positions", name, frame.positions, positions_of(frame.way));
}

std::string label_without_picture(const State& state) {
  if (state.view.scene) return "drawing ...";
  return state.is_error ? "no scene; drop a .glb or .gltf file here" : "loading ...";
}

std::string label_of_map(const View& view, const Drawer::Shown& shown) {
  if (view.mode != 0) return "FLIP compares colours: set \"shows\" to them";
  if (!shown.map || shown.map->number != view.number) return "FLIP: waits for a whole picture of A and of B";
  const auto [a, b] = shown.map->positions;
  return fmt::format("FLIP of A ({}, {} positions) and B ({}, {}): mean {:.4f}   black: alike, bright: different",
                     name_of(view.ways[0]), a, name_of(view.ways[1]), b, shown.map->mean);
}

}  // namespace

double depth_at(const Frame* frame, double x, double y, double otherwise) {
  const float* z = frame && frame->picture ? floats_of(*frame->picture, "Z") : nullptr;
  if (!z || x < 0 || y < 0 || x >= 1 || y >= 1) return otherwise;
  const auto column = static_cast<size_t>(x * frame->width), row = static_cast<size_t>(y * frame->height);
  const float depth = z[row * frame->width + column];
  return std::isfinite(depth) && depth > 0 ? static_cast<double>(depth) : otherwise;
}

void PictureArea::upload(const Drawer::Shown& shown) {
  for (size_t i = 0; i < sides; ++i) {
    const auto& frame = shown.frames[i];
    if (!frame || sides_[i].from == frame) continue;
    sides_[i].texture.upload(frame->width, frame->height, frame->rgb);
    sides_[i].from = frame;
  }
  if (!shown.map || map_.from == shown.map) return;
  map_.texture.upload(shown.map->width, shown.map->height, shown.map->rgb);
  map_.from = shown.map;
}

// Draws the part of a side's picture from `begin` to `end` of the width.
void PictureArea::draw_side(const State& state, const Drawer::Shown& shown, size_t side, float begin, float end,
                            ImVec2 size) const {
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const float left = begin * size.x, right = end * size.x;
  if (!shown.errors[side].empty())
    return draw_label({left + margin, margin}, shown.errors[side], red, std::max(right - left - 2 * margin, 60.0f));
  const Frame* frame = shown.frames[side].get();
  if (!frame || sides_[side].texture.is_empty())
    return draw_label({left + margin, margin}, label_without_picture(state), white, std::max(right - left - 2 * margin, 60.0f));
  list.AddImage(sides_[side].texture.id(), {left, 0}, {right, size.y}, {begin, 0}, {end, 1});
  list.PushClipRect({left, 0}, {right, size.y});
  const bool has_legend = modes()[state.view.mode].coloring == Coloring::age;
  const float width = has_legend ? std::max(right - left - 2 * margin, 60.0f) : 0;
  draw_label({left + margin, margin}, label_of(state, *frame, side), white, width);
  list.PopClipRect();
}

bool PictureArea::drag_slider(State& state, ImVec2 size) {
  if (state.comparison != Comparison::slider) return false;
  const ImGuiIO& io = ImGui::GetIO();
  const bool is_near = std::abs(io.MousePos.x - state.slider * size.x) < 8 && io.MousePos.x < size.x;
  if (!io.WantCaptureMouse && is_near && ImGui::IsMouseClicked(0)) drags_slider_ = true;
  if (!ImGui::IsMouseDown(0)) drags_slider_ = false;
  if (is_near || drags_slider_) ImGui::SetMouseCursor(ImGuiMouseCursor_ResizeEW);
  if (drags_slider_) state.slider = std::clamp(io.MousePos.x / std::max(size.x, 1.0f), 0.0f, 1.0f);
  return drags_slider_;
}

// Returns the point of a surface under the mouse; empty where the mouse is not on a picture.
std::optional<PictureArea::Under> PictureArea::under_mouse(const State& state, const Drawer::Shown& shown, ImVec2 size) const {
  const ImGuiIO& io = ImGui::GetIO();
  if (io.WantCaptureMouse || !state.view.scene || size.x < 1 || size.y < 1) return {};
  const double x = static_cast<double>(io.MousePos.x / size.x), y = static_cast<double>(io.MousePos.y / size.y);
  if (x < 0 || x >= 1 || y < 0 || y >= 1) return {};
  const double distance_of_target = glm::length(state.navigation.target() - state.navigation.eye());
  const double depth = depth_at(shown.frames[0].get(), x, y, distance_of_target);
  const glm::dvec3 direction = direction_through(state.view.camera, x, y, static_cast<double>(size.x / size.y));
  return Under{{static_cast<uint32_t>(x * state.view.width), static_cast<uint32_t>(y * state.view.height)},
               eye_of(state.view.camera) + direction * depth};
}

// Moves the camera as the mouse says. Returns whether it moves.
bool PictureArea::move_camera(Navigation& navigation, const glm::dvec3& under, float height) {
  const ImGuiIO& io = ImGui::GetIO();
  constexpr double radians_per_unit = 0.006;
  for (int button = 0; button < 3; ++button)
    if (ImGui::IsMouseClicked(button)) pivot_ = under;
  if (io.MouseWheel != 0.0f) {
    navigation.approach(under, std::pow(0.85, static_cast<double>(io.MouseWheel)));
    return true;
  }
  const double right = static_cast<double>(io.MouseDelta.x), down = static_cast<double>(io.MouseDelta.y);
  if (right == 0 && down == 0) return false;
  if (ImGui::IsMouseDown(2) || (ImGui::IsMouseDown(0) && io.KeyShift)) {
    const double at_unit_distance = 2.0 * std::tan(0.5 * glm::radians(navigation.fov_deg())) / static_cast<double>(height);
    navigation.move(glm::dvec3(-right, down, 0) * at_unit_distance * glm::length(pivot_ - navigation.eye()));
  } else if (ImGui::IsMouseDown(0)) {
    navigation.orbit(pivot_, right * radians_per_unit, down * radians_per_unit);
  } else if (ImGui::IsMouseDown(1)) {
    navigation.turn(right * 0.5 * radians_per_unit, down * 0.5 * radians_per_unit);
  } else {
    return false;
  }
  return true;
}

void PictureArea::control(State& state, const Drawer::Shown& shown, ImVec2 size) {
  if (drag_slider(state, size)) return;
  const std::optional<Under> under = under_mouse(state, shown, size);
  if (!under) return;
  if (state.inspects) state.view.inspected = under->pixel;
  if (move_camera(state.navigation, under->point, size.y)) state.moved_at = ImGui::GetTime();
}

void PictureArea::draw_both(const State& state, const Drawer::Shown& shown, ImVec2 size) const {
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  draw_side(state, shown, 0, 0, state.slider, size);
  draw_side(state, shown, 1, state.slider, 1, size);
  const float x = state.slider * size.x;
  list.AddLine({x, 0}, {x, size.y}, white, 1.5f);
  list.AddCircleFilled({x, 0.5f * size.y}, 7, white);
}

void PictureArea::draw_map(const State& state, const Drawer::Shown& shown, ImVec2 size) const {
  if (shown.map && !map_.texture.is_empty()) ImGui::GetBackgroundDrawList()->AddImage(map_.texture.id(), {0, 0}, size);
  draw_label({margin, margin}, label_of_map(state.view, shown), white, std::max(size.x - 2 * margin, 60.0f));
  for (size_t i = 0; i < sides; ++i)
    if (!shown.errors[i].empty()) draw_label({margin, 40 + 40 * static_cast<float>(i)}, shown.errors[i], red, size.x - 2 * margin);
}

void PictureArea::draw(State& state, const Drawer::Shown& shown, ImVec2 size) {
  upload(shown);
  if (state.blinks)
    draw_side(state, shown, state.shows_b ? 1 : 0, 0, 1, size);
  else if (state.comparison == Comparison::slider)
    draw_both(state, shown, size);
  else if (state.comparison == Comparison::map)
    draw_map(state, shown, size);
  else
    draw_side(state, shown, state.comparison == Comparison::only_b ? 1 : 0, 0, 1, size);
  if (!state.is_panel_seen && !state.message.empty() && size.y > 60)
    draw_label({margin, 30}, state.message, state.is_error ? red : white, std::max(size.x - 2 * margin, 60.0f));
  draw_inspection(state, shown, size);
  control(state, shown, size);
}

}  // namespace sideray::viewer
