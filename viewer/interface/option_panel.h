// The options of a picture as Dear ImGui shows them, made from the library's table. Main thread.
#pragma once

#include <imgui.h>

#include <map>
#include <optional>
#include <string>

#include "viewer/drawing/view.h"

namespace sideray::viewer {

class OptionPanel {
 public:
  // Whether an option has changed; those that contradict others stay as they were, and `message` says why.
  bool draw(Options& options, const sideray_scene_facts& facts, std::string& message);

 private:
  void find_reasons(const Options& options, const sideray_scene_facts& facts);
  std::string choose(const sideray_option& row, const Options& options);
  std::string write(const sideray_option& row, const Options& options);
  std::optional<std::string> draw_row(const sideray_option& row, const Options& options);

  std::map<std::string, std::string> reasons_;  // why an option makes no difference; none: it does
  std::optional<Options> known_;                // the options that these are of
  uint64_t known_triangles_ = 0;
  std::map<std::string, std::array<char, 64>> written_;
};

}  // namespace sideray::viewer
