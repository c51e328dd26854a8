#include "gl/scene/raster_sprites.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <functional>

#include "elementary/functions.h"
#include "gl/resources/raster_programs.h"
#include "gl/scene/raster_view.h"
#include "model/particles.h"

namespace sideray::gl {
namespace {

// Has the layout of an instance of raster_sprite.vert.glsl.
struct SpriteRecord {
  glm::vec3 position;
  glm::vec2 half_size, turn;
  glm::vec4 color;
  uint32_t cell;
};

SpriteRecord record_of(const model::Sprite& s) {
  return {s.position, s.half_size, {elementary::cos(s.rotation), elementary::sin(s.rotation)}, s.color, s.cell};
}

glm::vec4 depth_row(const RasterView& view) {
  const glm::dmat4& m = view.view_from_local;
  return -glm::vec4(m[0][2], m[1][2], m[2][2], m[3][2]);
}

// Tests whether a sphere of `radius` around a position at `depth` lies outside the picture.
class SideTest {
 public:
  explicit SideTest(const RasterView& view)
      : clip_(view.clip_from_local), near_(view.z_near), far_(view.z_far > 0.0f ? view.z_far : INFINITY) {
    const auto reach = [&](int row) { return glm::length(glm::vec3(clip_[0][row], clip_[1][row], clip_[2][row])); };
    reach_ = {reach(0), reach(1)};
  }
  bool outside(glm::vec3 position, float depth, float radius) const {
    // A sprite has one depth, as it is parallel to the picture.
    if (!(depth > near_) || depth > far_) return true;
    const glm::vec4 p = clip_ * glm::vec4(position, 1.0f);
    return std::abs(p.x) > p.w + radius * reach_.x || std::abs(p.y) > p.w + radius * reach_.y;
  }

 private:
  glm::mat4 clip_;
  float near_, far_;
  glm::vec2 reach_;
};

}  // namespace

bool is_soft(const model::ParticleSystem& system) {
  return system.desc.soft_distance > 0.0f && !system.sprites.empty();
}

bool has_soft_sprites(const model::Snapshot& snapshot) {
  return std::any_of(snapshot.particles.begin(), snapshot.particles.end(), is_soft);
}

std::span<const PlacedSprite> RasterSprites::place(const model::Snapshot& snapshot, const RasterView& view) {
  keys_.clear(), placed_.clear();
  const glm::vec4 depth_from_local = depth_row(view);
  const SideTest sides(view);
  std::vector<uint32_t> firsts;  // number of each system's first sprite, counted over all systems
  uint32_t first = 0;
  for (const model::ParticleSystem& system : snapshot.particles) {
    firsts.push_back(first);
    for (uint32_t i = 0; i < system.sprites.size(); ++i) {
      const model::Sprite& s = system.sprites[i];
      const float depth = glm::dot(depth_from_local, glm::vec4(s.position, 1.0f));
      if (sides.outside(s.position, depth, glm::length(s.half_size))) continue;
      // Positive floats sort like their bits.
      keys_.push_back(uint64_t{std::bit_cast<uint32_t>(depth)} << 32 | (first + i));
    }
    first += static_cast<uint32_t>(system.sprites.size());
  }
  std::sort(keys_.begin(), keys_.end(), std::greater<>());
  std::vector<SpriteRecord> records;
  records.reserve(keys_.size());
  for (const uint64_t key : keys_) {
    const auto rank = static_cast<uint32_t>(key);
    const auto system =
        static_cast<uint32_t>(std::upper_bound(firsts.begin(), firsts.end(), rank) - firsts.begin()) - 1;
    placed_.push_back({std::bit_cast<float>(static_cast<uint32_t>(key >> 32)), system, rank - firsts[system]});
    records.push_back(record_of(snapshot.particles[system].sprites[placed_.back().sprite]));
  }
  gl_.BindBuffer(GL_ARRAY_BUFFER, buffer_.id());
  gl_.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(records.size() * sizeof(SpriteRecord)), records.data(),
                 GL_STREAM_DRAW);
  return placed_;
}

void RasterSprites::set_view(const Program& program, const RasterView& view, uint32_t picture_height) {
  program.set("clip_from_local", glm::mat4(view.clip_from_local));
  const glm::dmat3 turn = glm::transpose(glm::dmat3(view.view_from_local));
  program.set("camera_x", glm::vec3(turn[0]));
  program.set("camera_y", glm::vec3(turn[1]));
  program.set("depth_from_local", depth_row(view));
  program.set("along_from_depth", make_view_rays(view).along_from_depth);
  const float pixel = 2.0f / static_cast<float>(picture_height);
  program.set("pixel_at_depth", view.orthographic ? glm::vec2(pixel * view.half_height, 0.0f)
                                                  : glm::vec2(0.0f, pixel * elementary::tan(0.5f * view.yfov)));
}

void RasterSprites::set_system(const Program& program, const model::Snapshot& snapshot, uint32_t system,
                               RasterTextures& textures) {
  const sideray_particles_desc& d = snapshot.particles[system].desc;
  const model::Texture* texture = d.texture ? snapshot.textures[d.texture - 1].get() : nullptr;
  const model::FlipBook book = model::flip_book(d, texture);
  program.set("flip_book", glm::ivec2(d.columns, d.rows));
  program.set("cell_texels", book.cell_texels);
  program.set("last_level", book.last_level);
  program.set("soft_distance", d.soft_distance);
  program.set("blend_mode", static_cast<int>(d.blend_mode));
  textures.bind(unit::material, texture, model::flip_book_slot());
}

void RasterSprites::point_at(uint32_t first) {
  gl_.BindBuffer(GL_ARRAY_BUFFER, buffer_.id());
  constexpr auto stride = static_cast<GLsizei>(sizeof(SpriteRecord));
  const size_t start = first * sizeof(SpriteRecord);
  const auto at = [start](size_t offset) { return reinterpret_cast<const void*>(start + offset); };
  gl_.VertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, stride, at(offsetof(SpriteRecord, position)));
  gl_.VertexAttribPointer(1, 2, GL_FLOAT, GL_FALSE, stride, at(offsetof(SpriteRecord, half_size)));
  gl_.VertexAttribPointer(2, 2, GL_FLOAT, GL_FALSE, stride, at(offsetof(SpriteRecord, turn)));
  gl_.VertexAttribPointer(3, 4, GL_FLOAT, GL_FALSE, stride, at(offsetof(SpriteRecord, color)));
  gl_.VertexAttribIPointer(4, 1, GL_UNSIGNED_INT, stride, at(offsetof(SpriteRecord, cell)));
  for (uint32_t location = 0; location < 5; ++location) {
    gl_.EnableVertexAttribArray(location);
    gl_.VertexAttribDivisor(location, 1);
  }
}

void RasterSprites::draw(const SpriteRun& run) {
  if (run.count == 0) return;
  gl_.BindVertexArray(vertex_array_.id());
  gl_.Disable(GL_CULL_FACE);
  point_at(run.first);
  gl_.DrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, static_cast<GLsizei>(run.count));
}

}  // namespace sideray::gl
