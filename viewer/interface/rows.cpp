#include "viewer/interface/rows.h"

namespace sideray::viewer {
namespace {

constexpr float control_width = 160, help_width = 360, gap = 8;

}  // namespace

void begin_row(const char* name, ImVec4 color) {
  ImGui::BeginGroup();
  ImGui::AlignTextToFramePadding();
  ImGui::TextColored(color, "%s", name);
  ImGui::SameLine(name_width);
  ImGui::SetNextItemWidth(control_width);
}

bool end_row() {
  ImGui::EndGroup();
  return ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled);
}

void end_row(const char* help) {
  ImGui::EndGroup();
  explain(help);
}

void explain(const char* help) {
  if (ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled)) show_beside_panel([&] { ImGui::TextUnformatted(help); });
}

// The help covers the picture rather than other rows; where the picture is too narrow, it is at the mouse.
void show_beside_panel(const std::function<void()>& content) {
  const float right = ImGui::GetWindowPos().x - gap;
  const bool is_low = ImGui::GetItemRectMin().y > 0.5f * ImGui::GetIO().DisplaySize.y;
  const float y = is_low ? ImGui::GetItemRectMax().y : ImGui::GetItemRectMin().y;
  if (right > help_width + 2 * gap) ImGui::SetNextWindowPos({right, y}, ImGuiCond_Always, {1, is_low ? 1.0f : 0.0f});
  ImGui::BeginTooltip();
  ImGui::PushTextWrapPos(help_width);
  content();
  ImGui::PopTextWrapPos();
  ImGui::EndTooltip();
}

bool is_open(const char* title, ImGuiTreeNodeFlags flags) {
  return ImGui::TreeNodeEx(title, ImGuiTreeNodeFlags_NoTreePushOnOpen | ImGuiTreeNodeFlags_Framed | flags);
}

}  // namespace sideray::viewer
