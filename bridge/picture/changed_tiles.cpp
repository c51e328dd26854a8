#include "bridge/picture/changed_tiles.h"

#include <algorithm>
#include <cmath>

#include "gl/scene/shadow_plan.h"
#include "rt/base/pixels.h"
#include "rt/reach/wanted_tiles.h"

namespace sideray::bridge {
namespace {

using Tiles = std::vector<uint8_t>;

// The most tiles between a pixel and what its filters read: for masks two, through other pixels; for layers one.
constexpr uint32_t masks_read = 2, layers_read = 1, bounces_read = 2;
constexpr double edge = 2.0;  // margin in pixels, for positions within the pixel and for rounding

// Sets the tiles where a box may be visible.
void add_box(const ChangedView& v, const model::Bounds& box, Tiles& tiles) {
  if (box.empty()) return;
  const double size = rt::frame_tile_size;
  glm::dvec2 low(INFINITY), high(-INFINITY);
  int behind = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec4 p = v.view.clip_from_local *
                         glm::dvec4((corner & 1) ? box.maximum.x : box.minimum.x, (corner & 2) ? box.maximum.y : box.minimum.y,
                                    (corner & 4) ? box.maximum.z : box.minimum.z, 1.0);
    if (!(p.w > 0.0)) {
      ++behind;
      continue;
    }
    const glm::dvec2 pixel = (glm::dvec2(p) / p.w * 0.5 + 0.5) * glm::dvec2(v.width, v.height);
    low = glm::min(low, pixel);
    high = glm::max(high, pixel);
  }
  if (behind == 8) return;
  if (behind > 0) low = glm::dvec2(0.0), high = glm::dvec2(v.width, v.height);
  const uint32_t columns = rt::tile_count(v.width), rows = rt::tile_count(v.height);
  const auto tile = [&](double pixel) { return static_cast<int64_t>(std::floor(std::clamp(pixel, -1e9, 1e9) / size)); };
  const int64_t x1 = std::min<int64_t>(tile(high.x + edge), columns - 1), y1 = std::min<int64_t>(tile(high.y + edge), rows - 1);
  for (int64_t y = std::max<int64_t>(tile(low.y - edge), 0); y <= y1; ++y)
    for (int64_t x = std::max<int64_t>(tile(low.x - edge), 0); x <= x1; ++x) tiles[static_cast<size_t>(y * columns + x)] = 1;
}

void add_sprites(const ChangedView& v, const model::Snapshot& snapshot, size_t system, Tiles& tiles) {
  if (system >= snapshot.particles.size()) return;
  for (const model::Sprite& sprite : snapshot.particles[system].sprites) add_box(v, rt::bounds_of(sprite), tiles);
}

// Sets the tiles that show a translucent surface. The rasterizer shades it where rays found no answer; its shadow maps
// change with every caster, and its refraction shows other pixels. Its pixels are also donors.
void add_translucent(const ChangedView& v, const model::Snapshot& snapshot, Tiles& tiles) {
  for (const model::Instance& instance : snapshot.instances)
    if (snapshot.materials[instance.material].translucent) add_box(v, instance.bounds, tiles);
}

// Returns whether a box may cast a shadow of a light on something in another box.
bool may_shadow(const model::Light& light, const model::Bounds& from, const model::Bounds& on, float margin) {
  // Shrinks the receiving box to its centre and enlarges the other by the same amount.
  const glm::vec3 half = 0.5f * (on.maximum - on.minimum) + margin, start = on.center();
  const bool is_far = light.type == SIDERAY_LIGHT_DIRECTIONAL;
  const glm::vec3 way = is_far ? -light.direction : light.position - start;
  float enters = 0.0f, leaves = is_far ? INFINITY : 1.0f;
  for (int i = 0; i < 3; ++i) {
    const float a = from.minimum[i] - half[i] - start[i], b = from.maximum[i] + half[i] - start[i];
    if (way[i] == 0.0f) {
      if (a > 0.0f || b < 0.0f) return false;
      continue;
    }
    enters = std::max(enters, std::min(a / way[i], b / way[i]));
    leaves = std::min(leaves, std::max(a / way[i], b / way[i]));
  }
  return enters <= leaves;
}

bool same_maps(const model::Snapshot& a, const model::Snapshot& b) {
  const gl::ShadowPlan x = gl::plan_shadow_maps(a.lights, gl::shadow_casters(a), {});
  const gl::ShadowPlan y = gl::plan_shadow_maps(b.lights, gl::shadow_casters(b), {});
  for (size_t i = 0; i < a.lights.size(); ++i)
    if (a.lights[i] == b.lights[i] && x.lights[i].clip_from_local != y.lights[i].clip_from_local) return false;
  return true;
}

// Sets the tiles of sprites on which a box casts a shadow, by shadow maps.
void add_shadowed_sprites(const ChangedView& v, const model::Bounds& caster, bool all, Tiles& tiles) {
  constexpr float share = 0.01f;  // for the size of a shadow map's texels, which grows with the scene
  for (const model::Snapshot* snapshot : {&v.before, &v.now})
    for (size_t system = 0; system < snapshot->particles.size(); ++system) {
      model::Bounds box;
      for (const model::Sprite& sprite : snapshot->particles[system].sprites) {
        box.add(rt::bounds_of(sprite).minimum);
        box.add(rt::bounds_of(sprite).maximum);
      }
      if (box.empty()) continue;
      const float margin = share * snapshot->bounds.radius();
      const bool falls = std::ranges::any_of(snapshot->lights, [&](const model::Light& light) {
        return may_shadow(light, caster, box, margin);
      });
      if (all || falls) add_sprites(v, *snapshot, system, tiles);
    }
}

bool overlap(const model::Bounds& a, const model::Bounds& b) {
  return glm::all(glm::lessThanEqual(a.minimum, b.maximum)) && glm::all(glm::lessThanEqual(b.minimum, a.maximum));
}

// Sets the tiles of sprites that reach into a box.
void add_lit_sprites(const ChangedView& v, const model::Bounds& lit, Tiles& tiles) {
  for (const model::Snapshot* snapshot : {&v.before, &v.now})
    for (const model::ParticleSystem& system : snapshot->particles)
      for (const model::Sprite& sprite : system.sprites)
        if (const model::Bounds box = rt::bounds_of(sprite); overlap(box, lit)) add_box(v, box, tiles);
}

void join(const Tiles& from, Tiles& to) {
  std::transform(from.begin(), from.end(), to.begin(), to.begin(), [](uint8_t a, uint8_t b) -> uint8_t { return a | b; });
}

}  // namespace

std::vector<uint8_t> tiles_that_see(std::span<const rt::Mover> movers, const ChangedView& v) {
  using Kind = rt::Mover::Kind;
  const uint32_t columns = rt::tile_count(v.width);
  const Tiles none(size_t{columns} * rt::tile_count(v.height), 0);
  Tiles over = none, shown = none, by_masks = none, by_layers = none;
  const bool lights_change = std::ranges::any_of(movers, [](const rt::Mover& m) { return m.kind != Kind::sprites; });
  if (lights_change && !v.reach) return Tiles(none.size(), tile_changed);
  const bool maps_change = lights_change && !same_maps(v.before, v.now);
  const auto add_meeting = [&](bool (rt::TileReach::*meets)(size_t, const model::Bounds&) const, const rt::Mover& mover,
                               Tiles& tiles) {
    for (size_t tile = 0; v.reach && tile < none.size(); ++tile) tiles[tile] |= (v.reach->*meets)(tile, mover.bounds);
  };
  for (const rt::Mover& mover : movers) {
    if (mover.kind == Kind::sprites) {
      // Sprites cast no shadows, and straight rays do not hit them.
      for (const model::Snapshot* snapshot : {&v.before, &v.now}) add_sprites(v, *snapshot, mover.index, over);
      add_meeting(&rt::TileReach::meets_sprites, mover, by_layers);
    } else if (mover.kind == Kind::light) {
      // A light does not change masks beyond its range.
      add_box(v, mover.bounds, shown);
      add_lit_sprites(v, mover.bounds, shown);
      add_meeting(&rt::TileReach::meets_mirrored, mover, by_layers);
    } else {
      add_box(v, mover.bounds, by_masks);
      add_meeting(&rt::TileReach::meets_occluders, mover, by_masks);
      add_meeting(&rt::TileReach::meets_mirrored, mover, by_layers);
      add_shadowed_sprites(v, mover.bounds, maps_change, shown);
    }
  }
  if (lights_change) add_translucent(v, v.before, shown), add_translucent(v, v.now, shown);
  join(rt::grown(by_masks, columns, masks_read), shown);
  join(rt::grown(by_layers, columns, v.bounces ? bounces_read : layers_read), shown);
  for (size_t tile = 0; tile < none.size(); ++tile)
    shown[tile] = shown[tile] ? tile_changed : over[tile] ? tile_drawn_over : tile_unchanged;
  return shown;
}

}  // namespace sideray::bridge
