// Holds everything that users change in the window. Main thread.
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
  bool blinks = false, shows_b = false;  // shows_b: the side shown while it blinks
  bool has_panel = true, inspects = false, plays = false;
  bool is_panel_seen = true;
  double moved_at = -1;  // time of the camera's last motion
  std::optional<std::string> wanted_variant;  // differs from the shown one
  std::string message;   // about the last event
  bool is_error = false;

  // Requests another picture.
  void touch() { ++view.number; }
  void say(const std::string& text) { message = text, is_error = false; }
  void complain(const std::string& text) { message = text, is_error = true; }
};

}  // namespace sideray::viewer
