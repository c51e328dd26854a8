#include "model/particles.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "model/failure.h"

namespace sideray::model {
namespace {

constexpr size_t most_sprites = size_t{1} << 20;
constexpr uint32_t most_cells_a_side = 256;

bool in_range(float value, float low, float high) {
  return value >= low && value <= high;
}

void check_sprite(const sideray_sprite& s, size_t index) {
  for (const double p : s.position)
    if (!(std::abs(p) <= 1e15))
      fail(SIDERAY_INVALID_ARGUMENT, "sprite {}: position holds {}; give finite numbers up to 1e15", index, p);
  if (!(s.width > 0.0f && s.width <= 1e9f) || !(s.height > 0.0f && s.height <= 1e9f))
    fail(SIDERAY_INVALID_ARGUMENT, "sprite {}: is {} by {}; give sides above 0 and at most 1e9", index, s.width,
         s.height);
  if (!std::isfinite(s.rotation) || !in_range(s.cell, 0.0f, 1e9f))
    fail(SIDERAY_INVALID_ARGUMENT, "sprite {}: rotation {} and cell {}: give finite numbers, the cell 0 to 1e9", index,
         s.rotation, s.cell);
  for (int c = 0; c < 4; ++c)
    if (!in_range(s.color[c], 0.0f, c == 3 ? 1.0f : 1e6f))
      fail(SIDERAY_INVALID_ARGUMENT, "sprite {}: color[{}] is {}; give 0 to {}", index, c, s.color[c],
           c == 3 ? 1.0 : 1e6);
}

}  // namespace

void check_particles(const sideray_particles_desc& d) {
  if (d.columns < 1 || d.rows < 1 || d.columns > most_cells_a_side || d.rows > most_cells_a_side)
    fail(SIDERAY_INVALID_ARGUMENT, "particles: a flip-book of {} by {} cells; give 1 to {} each way", d.columns, d.rows,
         most_cells_a_side);
  if (d.blend_mode < SIDERAY_BLEND_ALPHA || d.blend_mode > SIDERAY_BLEND_ADDITIVE)
    fail(SIDERAY_INVALID_ARGUMENT, "particles blend_mode {}: give ALPHA, PREMULTIPLIED or ADDITIVE",
         static_cast<int>(d.blend_mode));
  if (!in_range(d.soft_distance, 0.0f, 1e9f))
    fail(SIDERAY_INVALID_ARGUMENT, "particles soft_distance {}: give 0 to 1e9", d.soft_distance);
}

void check_sprites(const sideray_sprite* sprites, size_t count) {
  if (count && !sprites) fail(SIDERAY_INVALID_ARGUMENT, "sprites: NULL, although count is {}", count);
  if (count > most_sprites)
    fail(SIDERAY_INVALID_ARGUMENT, "{} sprites: at most {} in a system; use several", count, most_sprites);
  for (size_t i = 0; i < count; ++i) check_sprite(sprites[i], i);
}

FlipBook flip_book(const sideray_particles_desc& d, const Texture* texture) {
  if (!texture) return {glm::vec2(1.0f), 0.0f};
  const uint32_t width = texture->levels[0].width, height = texture->levels[0].height;
  const glm::vec2 cell(static_cast<float>(width) / static_cast<float>(d.columns),
                       static_cast<float>(height) / static_cast<float>(d.rows));
  const auto levels = static_cast<int>(texture->levels.size());
  if (d.columns * d.rows == 1) return {cell, static_cast<float>(levels - 1)};
  if (width % d.columns != 0 || height % d.rows != 0) return {cell, 0.0f};
  const int halvings = std::countr_zero((width / d.columns) | (height / d.rows));
  return {cell, static_cast<float>(std::min(halvings, levels - 1))};
}

sideray_texture_slot flip_book_slot() {
  sideray_texture_slot slot{};
  slot.wrap_u = slot.wrap_v = SIDERAY_CLAMP;
  slot.filter = SIDERAY_TRILINEAR;
  slot.texture_from_uv[0] = slot.texture_from_uv[3] = 1.0f;
  return slot;
}

Sprite local_sprite(const sideray_sprite& s, const sideray_particles_desc& desc, glm::dvec3 origin) {
  const auto cells = static_cast<double>(desc.columns * desc.rows);
  return {.position = glm::vec3(glm::dvec3(s.position[0], s.position[1], s.position[2]) - origin),
          .half_size = {0.5f * s.width, 0.5f * s.height},
          .rotation = s.rotation,
          .color = {s.color[0], s.color[1], s.color[2], s.color[3]},
          .cell = static_cast<uint32_t>(std::fmod(std::floor(static_cast<double>(s.cell)), cells))};
}

}  // namespace sideray::model
