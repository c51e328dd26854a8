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
  if (!frame || sides_[side].texture.is_empty()) {
    draw_label({left + margin, margin}, state.view.scene ? "drawing ..." : state.is_error ? "no scene" : "loading ...", white, 0);
    return;
  }
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

void PictureArea::control(State& state, const Drawer::Shown& shown, ImVec2 size, float pixels_per_unit) {
  const ImGuiIO& io = ImGui::GetIO();
  if (drag_slider(state, size) || io.WantCaptureMouse || !state.view.scene || size.x < 1 || size.y < 1) return;
  const double x = static_cast<double>(io.MousePos.x / size.x), y = static_cast<double>(io.MousePos.y / size.y);
  if (x < 0 || x >= 1 || y < 0 || y >= 1) return;
  if (state.inspects)
    state.view.inspected = Pixel{std::min(static_cast<uint32_t>(io.MousePos.x * pixels_per_unit), state.view.width - 1),
                                 std::min(static_cast<uint32_t>(io.MousePos.y * pixels_per_unit), state.view.height - 1)};
  Navigation& navigation = state.navigation;
  const double distance = glm::length(navigation.target() - navigation.eye());
  const double aspect = static_cast<double>(size.x / size.y);
  const double depth = depth_at(shown.frames[0].get(), x, y, distance);
  const glm::dvec3 under = eye_of(state.view.camera) + direction_through(state.view.camera, x, y, aspect) * depth;
  for (int button = 0; button < 3; ++button)
    if (ImGui::IsMouseClicked(button)) pivot_ = under;
  const double right = static_cast<double>(io.MouseDelta.x), down = static_cast<double>(io.MouseDelta.y);
  const bool is_dragged = right != 0 || down != 0;
  const bool pans = ImGui::IsMouseDown(2) || (ImGui::IsMouseDown(0) && io.KeyShift);
  const double per_unit = 2.0 * std::tan(0.5 * glm::radians(navigation.fov_deg())) / static_cast<double>(size.y);
  constexpr double radians_per_unit = 0.006;
  bool moves = true;
  if (io.MouseWheel != 0.0f)
    navigation.approach(under, std::pow(0.85, static_cast<double>(io.MouseWheel)));
  else if (is_dragged && pans)
    navigation.move(glm::dvec3(-right, down, 0) * per_unit * glm::length(pivot_ - navigation.eye()));
  else if (is_dragged && ImGui::IsMouseDown(0))
    navigation.orbit(pivot_, right * radians_per_unit, down * radians_per_unit);
  else if (is_dragged && ImGui::IsMouseDown(1))
    navigation.turn(right * 0.5 * radians_per_unit, down * 0.5 * radians_per_unit);
  else
    moves = false;
  if (moves) state.moved_at = ImGui::GetTime();
}

void PictureArea::draw(State& state, const Drawer::Shown& shown, ImVec2 size, float pixels_per_unit) {
  upload(shown);
  const bool is_b = state.comparison == Comparison::only_b || (state.blinks && state.shows_b);
  if (state.comparison == Comparison::slider && !state.blinks) {
    draw_side(state, shown, 0, 0, state.slider, size);
    draw_side(state, shown, 1, state.slider, 1, size);
    const float x = state.slider * size.x;
    ImGui::GetBackgroundDrawList()->AddLine({x, 0}, {x, size.y}, white, 1.5f);
    ImGui::GetBackgroundDrawList()->AddCircleFilled({x, 0.5f * size.y}, 7, white);
  } else if (state.comparison == Comparison::map && !state.blinks) {
    if (shown.map && !map_.texture.is_empty()) ImGui::GetBackgroundDrawList()->AddImage(map_.texture.id(), {0, 0}, size);
    const bool is_new = shown.map && shown.map->number == state.view.number;
    draw_label({margin, margin},
               is_new ? fmt::format("FLIP of {} and {}: {:.4f}   ({} and {} positions)", name_of(state.view.ways[0]),
                                    name_of(state.view.ways[1]), shown.map->mean, shown.map->positions[0], shown.map->positions[1])
               : state.view.mode == 0 ? "FLIP: waits for a whole picture of A and of B" : "FLIP is of colours; choose what is shown",
               white, 0);
    for (size_t i = 0; i < sides; ++i)
      if (!shown.errors[i].empty()) draw_label({margin, 40 + 40 * static_cast<float>(i)}, shown.errors[i], red, size.x - 2 * margin);
  } else {
    draw_side(state, shown, is_b ? 1 : 0, 0, 1, size);
  }
  if (!state.is_panel_seen && !state.message.empty() && size.y > 60)
    draw_label({margin, 30}, state.message, state.is_error ? red : white, std::max(size.x - 2 * margin, 60.0f));
  draw_inspection(state, shown, size);
  control(state, shown, size, pixels_per_unit);
}

}  // namespace sideray::viewer
