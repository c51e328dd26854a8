// Numbers primitives for the order of fragments in lists and peeling: shaders/translucent/raster_order_key.glsl.
#include <algorithm>

#include "gl/passes/raster_state.h"

namespace sideray::gl {

// Orders primitives as rays do where depths are equal: the smaller surface id is in front.
std::vector<RasterState::TranslucentItem> RasterState::numbered(std::vector<TranslucentItem> items) const {
  const auto sprites_begin =
      std::stable_partition(items.begin(), items.end(), [](const TranslucentItem& i) { return i.draw != nullptr; });
  std::sort(items.begin(), sprites_begin, [](const TranslucentItem& a, const TranslucentItem& b) {
    return std::make_pair(a.draw->surface_id, a.draw) < std::make_pair(b.draw->surface_id, b.draw);
  });
  uint32_t number = 1;
  for (TranslucentItem& item : items) {
    item.first_number = number;
    number += item.draw ? static_cast<uint32_t>(scene->snapshot().meshes[item.draw->mesh]->triangles.size())
                        : item.sprites.count;
  }
  return items;
}

void RasterState::set_order_uniforms(const Program& program) const {
  program.set("depth_flip", view.reversed_depth ? ~0u : 0u);
  program.set("list_row", static_cast<int>(targets.width()));
  if (lists) program.set("node_capacity", lists->capacity());
}

}  // namespace sideray::gl
