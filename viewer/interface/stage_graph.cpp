#include "viewer/interface/stage_graph.h"

#include <fmt/format.h>

#include <algorithm>

#include "viewer/interface/rows.h"

namespace sideray::viewer {
namespace {

constexpr size_t most_bars = 96;
constexpr float graph_height = 84, line_height = 15, column_width = 100;
constexpr ImU32 backdrop = IM_COL32(20, 22, 25, 255), grey = IM_COL32(170, 170, 170, 255), bright = IM_COL32(255, 255, 255, 255);
constexpr std::array<const char*, 5> names{"light", "sky", "other rays", "filters", "the rest"};
constexpr std::array<ImU32, 5> colors{IM_COL32(240, 196, 92, 255), IM_COL32(120, 200, 140, 255), IM_COL32(92, 156, 240, 255),
                                      IM_COL32(200, 120, 200, 255), IM_COL32(150, 156, 168, 255)};
constexpr const char* help =
    "Milliseconds of the last pictures, the newest on the right.\n"
    "other rays: glass and reflections, and all rays of a reference\n"
    "the rest: rasterizer, image on the screen, waiting";

double ms_of(const Frame& frame, sideray_stage stage) {
  for (const sideray_stage_time& time : frame.stages)
    if (time.stage == stage) return time.median;
  return 0;
}

}  // namespace

void StageGraph::add(size_t side, const std::shared_ptr<const Frame>& frame) {
  if (!frame || frame == last_[side]) return;
  last_[side] = frame;
  Bar& bar = newest_[side];
  bar.total = std::max(frame->ms, ms_of(*frame, SIDERAY_STAGE_TOTAL_FRAME));
  const double light = ms_of(*frame, SIDERAY_STAGE_TRACE_SHADOW), sky = ms_of(*frame, SIDERAY_STAGE_TRACE_AO);
  const double others = ms_of(*frame, SIDERAY_STAGE_TRACE), filters = ms_of(*frame, SIDERAY_STAGE_DENOISE);
  bar.ms = {light, sky, others, filters, std::max(bar.total - light - sky - others - filters, 0.0)};
  bars_.push_back(bar);
  if (bars_.size() > most_bars) bars_.pop_front();
}

// Draws the stages on each other from the foot, as far as they fit into the height.
void StageGraph::draw_bar(const Bar& bar, double most_ms, ImVec2 foot, float width, float height) const {
  float y = foot.y;
  for (size_t k = 0; k < colors.size(); ++k) {
    const float top = std::max(y - static_cast<float>(bar.ms[k] / most_ms) * height, foot.y - height);
    ImGui::GetWindowDrawList()->AddRectFilled({foot.x, top}, {foot.x + std::max(width - 1, 1.0f), y}, colors[k]);
    y = top;
  }
}

// The newest bar takes at least half the graph's height: final pictures may take a hundred times as long as moving ones.
void StageGraph::draw_bars() const {
  const ImVec2 corner = ImGui::GetCursorScreenPos(), size{ImGui::GetContentRegionAvail().x, graph_height};
  ImDrawList& list = *ImGui::GetWindowDrawList();
  list.AddRectFilled(corner, {corner.x + size.x, corner.y + size.y}, backdrop, 3);
  double longest = 1;
  for (const Bar& bar : bars_) longest = std::max(longest, bar.total);
  const double most = bars_.empty() ? longest : std::min(longest, 2.0 * bars_.back().total);
  const float width = size.x / static_cast<float>(most_bars);
  float x = corner.x + size.x - width * static_cast<float>(bars_.size());
  for (const Bar& bar : bars_) {
    draw_bar(bar, most, {x, corner.y + size.y}, width, size.y - line_height);
    x += width;
  }
  list.AddText({corner.x + 4, corner.y + 1}, grey, fmt::format("{:.0f} ms", most).c_str());
  ImGui::Dummy(size);
  explain(help);
}

void StageGraph::draw_row(const char* name, ImU32 color, const std::array<double, sides>& ms, size_t shown_sides) const {
  ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(color), "%s", name);
  for (size_t i = 0; i < shown_sides; ++i) {
    ImGui::SameLine(name_width + column_width * static_cast<float>(i));
    ImGui::Text("%s%.1f ms", shown_sides == 1 ? "" : i == 0 ? "A " : "B ", ms[i]);
  }
}

void StageGraph::draw(size_t shown_sides) const {
  draw_bars();
  draw_row("all", bright, {newest_[0].total, newest_[1].total}, shown_sides);
  for (size_t k = 0; k < names.size(); ++k) draw_row(names[k], colors[k], {newest_[0].ms[k], newest_[1].ms[k]}, shown_sides);
}

}  // namespace sideray::viewer
