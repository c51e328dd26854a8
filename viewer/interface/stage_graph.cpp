#include "viewer/interface/stage_graph.h"

#include <imgui.h>

#include <algorithm>

namespace sideray::viewer {
namespace {

constexpr size_t most_bars = 96;
constexpr std::array<const char*, 5> names{"layers and reflections", "light", "sky", "filters", "the rest"};
constexpr std::array<ImU32, 5> colors{IM_COL32(92, 156, 240, 255), IM_COL32(240, 196, 92, 255), IM_COL32(120, 200, 140, 255),
                                      IM_COL32(200, 120, 200, 255), IM_COL32(110, 115, 125, 255)};

double ms_of(const Frame& frame, sideray_stage stage) {
  for (const sideray_stage_time& time : frame.stages)
    if (time.stage == stage) return time.median;
  return 0;
}

}  // namespace

void StageGraph::add(size_t side, const std::shared_ptr<const Frame>& frame) {
  if (!frame || frame == last_[side]) return;
  last_[side] = frame;
  Bar bar;
  bar.total = std::max(frame->ms, ms_of(*frame, SIDERAY_STAGE_TOTAL_FRAME));
  const double trace = ms_of(*frame, SIDERAY_STAGE_TRACE), light = ms_of(*frame, SIDERAY_STAGE_TRACE_SHADOW);
  const double sky = ms_of(*frame, SIDERAY_STAGE_TRACE_AO), filters = ms_of(*frame, SIDERAY_STAGE_DENOISE);
  bar.ms = {trace, light, sky, filters, std::max(bar.total - trace - light - sky - filters, 0.0)};
  bars_.push_back(bar);
  if (bars_.size() > most_bars) bars_.pop_front();
}

void StageGraph::draw() const {
  const ImVec2 corner = ImGui::GetCursorScreenPos(), size{ImGui::GetContentRegionAvail().x, 84};
  ImDrawList& list = *ImGui::GetWindowDrawList();
  list.AddRectFilled(corner, {corner.x + size.x, corner.y + size.y}, IM_COL32(20, 22, 25, 255), 3);
  // The newest bar takes at least half the graph's height: final pictures may take a hundred times as long as moving
  // ones.
  double longest = 1;
  for (const Bar& bar : bars_) longest = std::max(longest, bar.total);
  const double most = bars_.empty() ? longest : std::min(longest, 2.0 * bars_.back().total);
  const float width = size.x / static_cast<float>(most_bars);
  for (size_t i = 0; i < bars_.size(); ++i) {
    const float x = corner.x + size.x - width * static_cast<float>(bars_.size() - i);
    float y = corner.y + size.y;
    for (size_t k = 0; k < colors.size(); ++k) {
      const float height = static_cast<float>(bars_[i].ms[k] / most) * (size.y - 16);
      if (y - height < corner.y + 14) {
        list.AddRectFilled({x, corner.y + 14}, {x + std::max(width - 1, 1.0f), y}, colors[k]);
        break;
      }
      list.AddRectFilled({x, y - height}, {x + std::max(width - 1, 1.0f), y}, colors[k]);
      y -= height;
    }
  }
  char scale[32];
  std::snprintf(scale, sizeof(scale), "%.0f ms", most);
  list.AddText({corner.x + 4, corner.y + 1}, IM_COL32(170, 170, 170, 255), scale);
  ImGui::Dummy(size);
  for (size_t k = 0; k < names.size(); ++k) {
    ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(colors[k]), "%s", names[k]);
    if (!bars_.empty()) {
      ImGui::SameLine(190);
      ImGui::Text("%.1f ms", bars_.back().ms[k]);
    }
  }
}

}  // namespace sideray::viewer
