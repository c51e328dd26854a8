#include "rt/irradiance/irradiance_history.h"

#include <algorithm>

#include "rt/base/pixels.h"
#include "rt/scene/scene_difference.h"

namespace sideray::rt {
namespace {

constexpr float most_samples_moving = 8.0f;  // what something that moves threw light on has to follow
constexpr float same_facing = 0.9f;  // cosine

}  // namespace

void IrradianceHistory::begin(const IrradianceRequest& r, TracedScene& scene) {
  std::shared_ptr<const model::Snapshot> committed = scene.committed();
  again_ = r.sequence == SequenceStep::again && width_ == r.width && height_ == r.height && number_ > 0;
  if (again_) {
    settled_ = settled_ && FrameCamera(r.view, r.width, r.height).sees_as(trail_.camera());
    return;
  }
  follows_ = known_ && r.sequence != SequenceStep::first && r.width == width_ && r.height == height_ &&
             r.shadows == shadows_ && differ_in_places_only(*committed_, *committed);
  counted_ = committed_ == committed ? static_cast<float>(most_samples) : most_samples_moving;
  known_ = false;
  const glm::dvec3 origin = scene.shading().snapshot->origin;
  moved_ = glm::vec3(origin_ - origin);
  origin_ = origin;
  std::swap(before_, after_);
  number_ = follows_ ? number_ + 1 : 1;
  if (!follows_) turns_.assign(size_t{tile_count(r.width)} * tile_count(r.height), 0);
  trail_.begin(r.view, r.depth, {r.width, r.height}, origin, follows_, scene.executor());
  const bool stands_still = follows_ && trail_.same_view() && posed_ == scene.shading().snapshot;
  const bool was_whole = std::ranges::all_of(turns_, [&](uint32_t turn) { return turn + 1 == number_; });
  if (!stands_still) stood_still_ = 0;
  else if (was_whole && stood_still_ < most_samples) ++stood_still_;
  settled_ = stood_still_ == most_samples && r.position_frames == 0;
  posed_ = scene.shading().snapshot;
  width_ = r.width, height_ = r.height, shadows_ = r.shadows;
  committed_ = std::move(committed);
}

void IrradianceHistory::look_back(size_t tile, const std::vector<glm::u16vec2>& pixels, const CellWalls& walls,
                                  const Intersector& intersector, Scratch& scratch, IrradianceCells& cells) const {
  constexpr uint32_t across = frame_tile_size / cell_side;
  const uint32_t columns = tile_count(width_);
  const uint32_t x0 = static_cast<uint32_t>(tile % columns) * across, y0 = static_cast<uint32_t>(tile / columns) * across;
  scratch.rays.clear(), scratch.cells.clear();
  for (uint32_t y = y0; y < std::min(y0 + across, cells.rows); ++y)
    for (uint32_t x = x0; x < std::min(x0 + across, cells.columns); ++x) {
      const size_t cell = size_t{y} * cells.columns + x;
      const CellPlace& place = cells.places[cell];
      cells.lights[cell] = {};
      if (!follows_ || !(place.width > 0.0f)) continue;
      PixelTrail::Row from;
      trail_.look_back(pixels[cell].x, pixels[cell].y, 1, from);
      if (from[0] == PixelTrail::nowhere) continue;
      const size_t then = size_t{from[0] / width_ / cell_side} * cells.columns + from[0] % width_ / cell_side;
      CellPlace was = before_.places[then];
      was.position += moved_;
      // The pixel of the cell that was traced may show another surface than the one found.
      if (glm::dot(was.normal, place.normal) < same_facing || !(plane_share(was, place.position) > 0.0f)) continue;
      cells.lights[cell] = before_.lights[then];
      cells.lights[cell].samples = std::min(cells.lights[cell].samples, counted_);
      const glm::vec3 apart = was.position - place.position;
      if (!walls.is_near(then, glm::dot(apart, apart))) continue;
      scratch.rays.push_back(ray_between(was, place));
      scratch.cells.push_back(static_cast<uint32_t>(cell));
    }
  if (scratch.rays.empty()) return;
  scratch.occluded.resize(scratch.rays.size());
  intersector.occluded(scratch.rays, false, scratch.occluded.data(), OpaqueSet::visible_in_reflection);
  for (size_t i = 0; i < scratch.cells.size(); ++i)
    if (scratch.occluded[i]) cells.lights[scratch.cells[i]] = {};
}

void IrradianceHistory::keep() {
  std::ranges::fill(turns_, number_);
  if (again_) return;
  std::swap(before_, after_);
  known_ = true;
}

void IrradianceHistory::end(IrradianceCells& cells) {
  if (again_) return;
  std::swap(after_, cells);
  known_ = true;
}

}  // namespace sideray::rt
