// The views that the window asks for, and the pictures that it gets. Plain memory.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lab/metrics/metrics.h"
#include "viewer/drawing/ways.h"
#include "viewer/scene/scene_file.h"

namespace sideray::viewer {

constexpr size_t sides = 2;  // A and B

struct Pixel {
  uint32_t x, y;
  bool operator==(const Pixel&) const = default;
};

struct View {
  // Changes whenever one of the fields up to the line changes.
  uint64_t number = 0;
  std::shared_ptr<SceneFile> scene;
  sideray_camera camera = sideray_camera_defaults();
  uint32_t width = 0, height = 0;
  Options options = Options::create().value();
  std::array<Way, sides> ways{Way::chosen, Way::reference};
  size_t mode = 0;  // of modes()
  lab::Display display;
  double time_s = 0;
  // ---
  size_t shown_sides = 1;  // 1: A alone
  bool is_moving = false;  // another view is about to follow
  bool wants_map = false;  // a map of the differences of A and B
  bool inspects = false;   // pictures with a budget need the channels of answers, too
  std::optional<Pixel> inspected;
};

// One picture of a side.
struct Frame {
  uint64_t number = 0;  // of the view that it shows
  Way way = Way::chosen;
  uint32_t width = 0, height = 0;
  bool is_preview = false;  // drawn smaller than the view, to be ready in time
  std::vector<uint8_t> rgb;
  std::vector<float> display;  // of colours: rgb before quantization
  std::shared_ptr<const Picture> picture;
  sideray_render_stats stats{};
  std::vector<sideray_stage_time> stages;
  uint64_t positions = 1;
  bool is_done = false;  // no picture of this view will be better
  double ms = 0;         // time that drawing took
};

struct DifferenceMap {
  uint64_t number = 0;
  std::array<uint64_t, sides> positions{};
  uint32_t width = 0, height = 0;
  std::vector<uint8_t> rgb;
  double mean = 0;
};

// A surface along the ray through a pixel.
struct Surface {
  double distance = 0;
  uint32_t surface_id = 0, primitive = 0;
  std::string object, material, kind;
};

struct Inspection {
  uint64_t number = 0;
  Pixel pixel{};
  std::vector<Surface> surfaces;  // the nearest first, the last one is opaque
};

}  // namespace sideray::viewer
