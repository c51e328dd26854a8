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
  struct Place {
    float left = 0, height = 0;
  };
  struct Busy {
    bool loads = false, charts = false;
  };
  Wish draw(State& state, const Drawer::Shown& shown, Place place, Busy busy);

 private:
  void draw_head(const State& state, const Drawer::Shown& shown, bool is_loading);
  Wish draw_scene(State& state, const Drawer::Shown& shown, bool is_charting);
  void draw_comparison(State& state);
  void draw_camera(State& state);
  void draw_variants(State& state);
  void draw_time(State& state);
  void draw_options(State& state);
  void draw_display(State& state);
  void draw_times(const State& state, const Drawer::Shown& shown);
  Wish draw_buttons(bool is_charting);

  OptionPanel options_;
  StageGraph graph_;
};

}  // namespace sideray::viewer
