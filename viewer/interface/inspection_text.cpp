#include "viewer/interface/inspection_text.h"

#include <fmt/format.h>

#include "viewer/drawing/inspect.h"
#include "viewer/drawing/modes.h"

namespace sideray::viewer {
namespace {

// Returns the radiance of a pixel in a complete picture of this view; "" where there is none.
std::string radiance_at(const Frame& frame, const View& view, Pixel pixel) {
  if (frame.is_preview || frame.number != view.number || view.mode != 0 || !frame.picture) return "";
  if (pixel.x >= frame.width || pixel.y >= frame.height) return "";
  const size_t texel = size_t{pixel.y} * frame.width + pixel.x;
  const float* planes[3] = {floats_of(*frame.picture, "R"), floats_of(*frame.picture, "G"), floats_of(*frame.picture, "B")};
  if (!planes[0] || !planes[1] || !planes[2]) return "";
  return fmt::format("\n    radiance {:.3f} {:.3f} {:.3f}", planes[0][texel], planes[1][texel], planes[2][texel]);
}

std::string line_of(const Surface& surface, size_t index) {
  const std::string material = surface.material.empty() ? "material without a name" : surface.material;
  return fmt::format("\n{}  {}: {}, {}\n    at {:.4g}, id {}, triangle {}", index, surface.object, material, surface.kind,
                     surface.distance, surface.surface_id, surface.primitive);
}

}  // namespace

std::string inspection_text(const State& state, const Drawer::Shown& shown) {
  const View& view = state.view;
  if (!view.inspected) return "move the mouse over the picture";
  const Pixel pixel = *view.inspected;
  std::string text = fmt::format("pixel {}, {}", pixel.x, pixel.y);
  for (size_t i = 0; i < view.shown_sides; ++i)
    if (const Frame* frame = shown.frames[i].get())
      text += fmt::format("\n{}: {}{}", i == 0 ? "A" : "B", answers_at(*frame, view, pixel), radiance_at(*frame, view, pixel));
  const Inspection* found = shown.inspection.get();
  if (!found || found->number != view.number || found->pixel != pixel) return text;
  if (found->surfaces.empty()) text += "\nno surface: the surroundings";
  for (size_t i = 0; i < found->surfaces.size(); ++i) text += line_of(found->surfaces[i], i);
  return text;
}

}  // namespace sideray::viewer
