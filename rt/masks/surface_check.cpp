#include "rt/masks/surface_check.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "rt/base/view_rays.h"

namespace sideray::rt {
namespace {

constexpr uint32_t step = 2;         // pixels, along rows and columns
constexpr double share_of_way = 0.01;  // tolerance around a drawn surface, as a share of its distance

// Is scratch memory of one thread, for a row.
struct Row {
  std::vector<Ray> rays;
  std::vector<Hit> hits;
  Counters counters;
};

class SurfaceCheck {
 public:
  SurfaceCheck(const MaskRequest& request, const Intersector& intersector)
      : request_(request), intersector_(intersector), view_(request.view, request.width, request.height) {}

  void check(uint32_t y, Row& row) const {
    row.rays.clear();
    for (uint32_t x = 0; x < request_.width; x += step) add_ray(x, y, row);
    row.hits.resize(row.rays.size());
    if (!row.rays.empty()) intersector_.nearest_opaque(row.rays, {.coherent = true}, row.hits.data());
    row.counters.mask_pixels_checked += row.rays.size();
    row.counters.mask_pixels_astray += static_cast<uint64_t>(
        std::ranges::count_if(row.hits, [](const Hit& hit) { return hit.instance == no_instance; }));
  }

 private:
  // Adds the ray of a pixel with a surface, over the range in which a traced one may lie.
  void add_ray(uint32_t x, uint32_t y, Row& row) const {
    const double depth = read_depth(request_.depth, x, y).depth;
    const bool cleared = request_.view.reversed_depth ? depth <= 0.0 : depth >= 1.0;
    if (cleared) return;
    const double distance = view_.distance(x, y, depth);
    if (!std::isfinite(distance)) return;
    const double by_depth = distance - double{view_.end_of_ray(x, y, depth, request_.depth.format)};
    const double off = share_of_way * distance + 4.0 * std::max(by_depth, 0.0);
    Ray ray = view_.ray(view_.pixel(x, y));
    ray.t_near = static_cast<float>(std::max(distance - off, 0.0));
    ray.t_far = static_cast<float>(distance + off);
    row.rays.push_back(ray);
  }

  const MaskRequest& request_;
  const Intersector& intersector_;
  const ViewRays view_;
};

}  // namespace

Counters check_surfaces(const MaskRequest& request, TracedScene& scene) {
  const SurfaceCheck check(request, scene.intersector());
  std::vector<Row> rows(scene.executor().threads());
  scene.executor().run((request.height + step - 1) / step,
                       [&](size_t y, uint32_t thread) { check.check(static_cast<uint32_t>(y) * step, rows[thread]); });
  Counters counters;
  for (const Row& row : rows) counters += row.counters;
  return counters;
}

}  // namespace sideray::rt
