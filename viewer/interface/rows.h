// Draws the rows of the panel, each with a name, a control and its help. Main thread.
#pragma once

#include <functional>
#include <imgui.h>

namespace sideray::viewer {

constexpr float name_width = 124;  // of a row; controls begin there
inline const ImVec4 pale{0.65f, 0.68f, 0.72f, 1}, warm{1.0f, 0.75f, 0.4f, 1}, blue{0.55f, 0.8f, 1.0f, 1};

// Begins a row: writes its name and leaves the cursor at its control, which has the width of the panel's controls.
void begin_row(const char* name, ImVec4 color = ImGui::GetStyleColorVec4(ImGuiCol_Text));
// Ends a row. Returns whether the mouse is on its name or its control.
bool end_row();
// Ends a row, and explains it while the mouse is on it.
void end_row(const char* help);

// Explains the last item while the mouse is on it.
void explain(const char* help);
// Shows what `content` draws beside the panel, at the height of the last item.
void show_beside_panel(const std::function<void()>& content);

// Draws the title of a group of rows. Returns whether the group is open.
bool is_open(const char* title, ImGuiTreeNodeFlags flags = 0);

}  // namespace sideray::viewer
