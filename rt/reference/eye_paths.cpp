#include "rt/reference/eye_paths.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "rt/base/largest.h"
#include "rt/base/sampling.h"

namespace sideray::rt {
namespace {

// The most surfaces that a primary ray hits: some rays never leave a solid.
constexpr uint32_t most_events = 256;
// Rays end below this transmittance.
constexpr float least_transmittance = 1e-6f;
// Each surface's importance is at least this share of the average, because its reflection may be much brighter than
// what is behind.
constexpr float least_importance = 0.1f;

enum Purpose : uint32_t { for_stops = 0x5709u };

}  // namespace

void EyePaths::trace(std::span<const EyeRay> rays, const EyeSettings& settings, PathTracer& tracer,
                     std::vector<SeenByEye>& seen) {
  seen.assign(rays.size(), {});
  seen_ = &seen;
  tracer_ = &tracer;
  sums_.assign(3 * rays.size(), {});
  find_stops(rays, settings);
  share_out(rays, settings);
  for (const Stop& s : stops_)
    if (!s.passes)
      tracer.add_exact_lights({&s.way, &s.event.point, nullptr, 3 * s.ray + 2, 0, 0, 0, s.weight}, sums_);
  tracer.trace(starts_, sums_);
  for (size_t i = 0; i < rays.size(); ++i) {
    const PathSum* sum = &sums_[3 * i];
    const PathSum* halves[] = {sum, settings.samples == 1 ? sum : sum + 1};
    for (size_t half = 0; half < 2; ++half) seen[i].radiance[half] = sum[2].radiance + halves[half]->radiance;
    seen[i].sky = sum[2].sky + 0.5f * (halves[0]->sky + halves[1]->sky);
  }
}

// Follows the rays to their first random continuation.
void EyePaths::find_stops(std::span<const EyeRay> rays, const EyeSettings& settings) {
  stops_.clear();
  next_views_.clear();
  for (uint32_t i = 0; i < rays.size(); ++i) {
    next_views_.push_back({LightWay(rays[i].ray, rays[i].cone, settings.media), i, glm::vec3(1.0f)});
    LightWay& way = next_views_.back().way;
    way.from_eye = true;
    way.end_at(rays[i].opaque);
  }
  LightWays& ways = tracer_->ways();
  while (!next_views_.empty()) {
    std::swap(views_, next_views_);
    next_views_.clear();
    group_.clear();
    for (View& view : views_) group_.push_back(&view.way);
    ways.find_opaque(group_);
    ways.find_translucent(group_);
    for (View& view : views_)
      if (go_on(view, settings)) next_views_.push_back(view);
  }
}

// Follows a ray through the surfaces found so far. Returns false if it ends there.
bool EyePaths::go_on(View& view, const EyeSettings& settings) {
  WayEvent event;
  while (tracer_->ways().next(view.way, event)) {
    if (!meet(view, event)) return false;
    if (event.passage != Passage::straight) return true;
  }
  if (!view.way.ahead.complete()) return true;
  end(view, settings);
  return false;
}

// Returns false if the ray ends.
bool EyePaths::meet(View& view, WayEvent& event) {
  const LightWays& ways = tracer_->ways();
  uint32_t& met = (*seen_)[view.ray].surfaces;
  view.through *= event.arriving;
  if (++met > most_events) return false;
  if (event.passage == Passage::mirrored) {
    if (is_scattered(event.point)) {
      stops_.push_back({view.way, event, true, view.ray, view.through, largest(view.through)});
      return false;
    }
    ways.redirect(view.way, event, event.direction);
    return true;
  }
  const shading::SrBlend& blend = event.point.blended;
  reflect(view, event, blend.cover);
  view.through *= blend.through;
  if (largest(view.through) < least_transmittance) return false;
  if (event.passage == Passage::straight) {
    view.way.media = event.behind;
  } else if (event.passage == Passage::refracted && !event.crossing.disperses) {
    ways.redirect(view.way, event, event.direction);
  } else {
    stops_.push_back({view.way, event, true, view.ray, view.through, largest(view.through)});
    return false;
  }
  return true;
}

void EyePaths::end(View& view, const EyeSettings& settings) {
  const LightWays& ways = tracer_->ways();
  SeenByEye& seen = (*seen_)[view.ray];
  const bool is_sky = view.way.opaque.instance == no_instance;
  view.through *= ways.arriving(view.way, is_sky ? farthest : static_cast<float>(view.way.opaque.distance));
  if (!view.way.bent && (is_sky || settings.is_end_given)) {
    seen.transmittance = view.through;
  } else if (is_sky) {
    sums_[3 * view.ray + 2].sky += view.through;
    sums_[3 * view.ray + 2].radiance += view.through * tracer_->sky(view.way.ray.direction);
  } else {
    WayEvent event;
    event.point = ways.end_point(view.way);
    reflect(view, event, 1.0f);
  }
}

// Adds the surface's emission, and makes it a start of paths if it reflects.
void EyePaths::reflect(const View& view, const WayEvent& event, float cover) {
  const SurfacePoint& point = event.point;
  const glm::vec3 weight = view.through * cover;
  sums_[3 * view.ray + 2].radiance += weight * shading::sr_emitted(point.surface);
  const LobeSampler lobes(point);
  if (lobes.reflects() && largest(weight) > 0.0f)
    stops_.push_back({view.way, event, false, view.ray, weight, largest(weight) * lobes.albedo()});
}

// Distributes paths in proportion to importance, at evenly spaced positions in the cumulative sum.
void EyePaths::share_out(std::span<const EyeRay> rays, const EyeSettings& settings) {
  starts_.clear();
  order_.resize(stops_.size());
  std::iota(order_.begin(), order_.end(), 0u);
  std::stable_sort(order_.begin(), order_.end(), [&](uint32_t a, uint32_t b) { return stops_[a].ray < stops_[b].ray; });
  for (size_t begin = 0, end; begin < order_.size(); begin = end) {
    const uint32_t ray = stops_[order_[begin]].ray;
    float sum = 0.0f;
    for (end = begin; end < order_.size() && stops_[order_[end]].ray == ray; ++end) sum += stops_[order_[end]].importance;
    const float least = least_importance * sum / static_cast<float>(end - begin);
    sum = 0.0f;
    for (size_t k = begin; k < end; ++k) sum += std::max(stops_[order_[k]].importance, least);
    for (uint32_t half = 0; half < 2; ++half) {
      const uint32_t samples = samples_of_half(settings.samples, half), key = random_key({rays[ray].key, half});
      if (samples == 0) continue;
      const float offset = PointSet(random_key({key, for_stops}))[settings.position].x;
      float place = -offset;
      uint32_t given = 0;
      for (size_t k = begin; k < end; ++k) {
        const Stop& s = stops_[order_[k]];
        const float expected = std::max(s.importance, least) / sum * static_cast<float>(samples);
        place += expected;
        const auto upto = k + 1 == end ? samples : static_cast<uint32_t>(std::clamp(std::ceil(place), 0.0f, static_cast<float>(samples)));
        if (upto <= given) continue;
        starts_.push_back({&s.way, &s.event.point, s.passes ? &s.event : nullptr, 3 * ray + half, key,
                           settings.position * samples + given, upto - given, s.weight / expected});
        given = upto;
      }
    }
  }
}

}  // namespace sideray::rt
