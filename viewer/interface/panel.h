// Draws the panel beside the pictures. Main thread.
#pragma once

#include "viewer/interface/option_panel.h"
#include "viewer/interface/stage_graph.h"
#include "viewer/interface/state.h"

namespace sideray::viewer {

// The command of a pressed button.
enum class Wish : uint8_t { nothing, copy_command, save_picture, chart, reload };

constexpr float panel_width = 380;

class Panel {
 public:
  Wish draw(State& state, const Drawer::Shown& shown, bool is_loading, bool is_charting, float left, float height);

 private:
  void draw_comparison(State& state);
  void draw_camera(State& state);
  void draw_variants(State& state);
  void draw_display(State& state);
  void draw_times(const State& state, const Drawer::Shown& shown);

  OptionPanel options_;
  StageGraph graph_;
};

}  // namespace sideray::viewer
