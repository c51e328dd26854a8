// Shows the options of a picture in Dear ImGui, from the library's table. Main thread.
#pragma once

#include <imgui.h>

#include <map>
#include <optional>
#include <string>

#include "viewer/drawing/view.h"

namespace sideray::viewer {

class OptionPanel {
 public:
  // Draws the options, and returns whether one has changed. An option that contradicts others keeps its value, and
  // `message` says why.
  bool draw(Options& options, const sideray_scene_facts& facts, std::string& message);

 private:
  void find_reasons(const Options& options, const sideray_scene_facts& facts);
  std::string choose(const sideray_option& row, const Options& options);
  std::string write(const sideray_option& row, const Options& options);
  std::optional<std::string> draw_row(const sideray_option& row, const Options& options);

  std::map<std::string, std::string> reasons_;  // option -> why it makes no difference; absent if it does
  std::optional<Options> known_;                // the options to which `reasons_` applies
  uint64_t known_triangles_ = 0;
  std::map<std::string, std::array<char, 64>> written_;
};

}  // namespace sideray::viewer
