// All that people change in the window. Main thread.
#pragma once

#include <string>

#include "viewer/drawing/drawer.h"
#include "viewer/scene/navigation.h"

namespace sideray::viewer {

enum class Comparison : uint8_t { only_a, slider, only_b, map };

struct State {
  View view;
  Navigation navigation;
  sideray_scene_facts facts{};
  Comparison comparison = Comparison::only_a;
  float slider = 0.5f;
  bool blinks = false, shows_b = false;  // while it blinks: which side it is at
  bool has_panel = true, inspects = false, plays = false;
  bool is_panel_seen = true;
  double moved_at = -1;  // the time at which the camera was moved
  std::optional<std::string> wanted_variant;  // another one than is shown
  std::string message;   // what happened last
  bool is_error = false;

  // Another picture is to be drawn.
  void touch() { ++view.number; }
  void say(const std::string& text) { message = text, is_error = false; }
  void complain(const std::string& text) { message = text, is_error = true; }
};

}  // namespace sideray::viewer
