// Blends by weighted order-independent transparency (McGuire and Bavoil 2013): a mean of what the fragments add,
// weighted by cover and depth, hides as much as all of them together. Transmittance is exact, per channel.
#include <algorithm>
#include <cmath>

#include "gl/passes/raster_state.h"

namespace sideray::gl {
namespace {

// The weight falls by this power of 2 over the depths at which the view has translucent surfaces, evenly in their
// logarithm: the best of 0, 2, 4 and 8 on `crossing` (docs/translucency-order.md).
constexpr float weight_range_stops = 4.0f;

}  // namespace

// Orders primitives as rays do where depths are equal: the smaller surface id in front.
std::vector<RasterState::TranslucentItem> RasterState::numbered(std::vector<TranslucentItem> items) const {
  const auto sprites_begin =
      std::stable_partition(items.begin(), items.end(), [](const TranslucentItem& i) { return i.draw != nullptr; });
  std::sort(items.begin(), sprites_begin, [](const TranslucentItem& a, const TranslucentItem& b) {
    return std::make_pair(a.draw->surface_id, a.draw) < std::make_pair(b.draw->surface_id, b.draw);
  });
  uint32_t number = 1;
  for (TranslucentItem& item : items) {
    item.first_number = number;
    number += item.draw ? static_cast<uint32_t>(scene.snapshot().meshes[item.draw->mesh]->triangles.size())
                        : item.sprites.count;
  }
  return items;
}

void RasterState::set_order_uniforms(const Program& program, Items items) const {
  program.set("depth_flip", view.reversed_depth ? ~0u : 0u);
  program.set("list_row", static_cast<int>(targets.width()));
  if (lists) program.set("node_capacity", lists->capacity());
  const glm::vec2 along = make_view_rays(view).along_from_depth;
  program.set("log_along_from_depth", glm::vec3(along, view.orthographic ? 1.0f : -1.0f));
  float nearest = INFINITY, farthest = 0;
  const auto include = [&](float depth) {
    depth = std::max(depth, view.z_near);
    nearest = std::min(nearest, depth), farthest = std::max(farthest, depth);
  };
  for (const TranslucentItem& item : items) {
    if (!item.draw) include(item.distance);
    for (int corner = 0; item.draw && corner < 8; ++corner) {
      const model::Bounds& b = item.draw->bounds;
      const glm::vec3 p((corner & 1 ? b.maximum : b.minimum).x, (corner & 2 ? b.maximum : b.minimum).y,
                        (corner & 4 ? b.maximum : b.minimum).z);
      include(glm::dot(p - view.eye, view.forward));
    }
  }
  const float stops_per_log = weight_range_stops / std::max(std::log2(farthest / nearest), 1e-3f);
  program.set("weight_stops", glm::vec2(stops_per_log * std::log2(nearest), stops_per_log));
}

void RasterState::draw_weighted(Items items, const Translucency& pass, FragmentOrder order) {
  if (!sums || !sums->fits()) sums = std::make_unique<WeightedSums>(gl, targets);
  begin_pass({.depth_test = true});
  sums->begin();
  sums->blend([&] { draw_translucent_items(items, pass, order); });

  begin_pass({.blend_dual_source = true});
  targets.bind_resolve();
  programs.resolve_weighted().use();
  for (uint32_t i = 0; i < WeightedSums::count; ++i)
    scene.textures().bind_plain(unit::material + i, GL_TEXTURE_2D, sums->texture(i));
  draw_screen();
}

}  // namespace sideray::gl
