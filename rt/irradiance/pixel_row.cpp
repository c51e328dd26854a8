#include "rt/irradiance/pixel_row.h"

#include <algorithm>
#include <cmath>

namespace sideray::rt {
namespace {

constexpr float least_share = 0.5f, whole_share = 0.99f;  // of a plane
constexpr float same_normal = 0.8f;                       // cosine
constexpr int most_rings = 2;                             // of cells about a pixel's own

// A pixel's place in the picture, in cells.
glm::vec2 place_of(uint32_t x, uint32_t y) {
  return (glm::vec2(x, y) + 0.5f) / static_cast<float>(cell_side);
}

// Calls visit(cell, way, bit) for the cells up to `ring` away from a pixel's own that show something: the way there in cells, and a
// bit of their own.
template <typename Visit>
void for_cells_about(const IrradianceCells& cells, uint32_t x, uint32_t y, int ring, const Visit& visit) {
  const int own_x = static_cast<int>(x / cell_side), own_y = static_cast<int>(y / cell_side);
  const int columns = static_cast<int>(cells.columns), rows = static_cast<int>(cells.rows);
  const glm::vec2 place = place_of(x, y);
  for (int v = std::max(own_y - ring, 0); v <= std::min(own_y + ring, rows - 1); ++v)
    for (int u = std::max(own_x - ring, 0); u <= std::min(own_x + ring, columns - 1); ++u) {
      const size_t cell = static_cast<size_t>(v) * cells.columns + static_cast<size_t>(u);
      if (!(cells.places[cell].width > 0.0f)) continue;
      const int bit = (v - own_y + most_rings) * (2 * most_rings + 1) + u - own_x + most_rings;
      visit(cell, glm::vec2(u, v) + 0.5f - place, 1u << bit);
    }
}

}  // namespace

// Looks for the nearest cell that shows the pixel's plane, else the one whose plane is nearest.
void PixelRow::find_plane(const CellsToSpread& from, uint32_t x, glm::vec3 to_eye) {
  Pixel& pixel = pixels_[x];
  pixel.normal = to_eye;
  const size_t own = size_t{y_ / cell_side} * from.cells.columns + x / cell_side;
  const CellPlace& here = from.cells.places[own];
  if (here.width > 0.0f && plane_share(here, pixel.position) > whole_share) {
    pixel.normal = here.normal;
    pixel.has_plane = true;
    return;
  }
  float best = least_share;
  for_cells_about(from.cells, x, y_, 1, [&](size_t cell, glm::vec2 way, uint32_t) {
    const float share = plane_share(from.cells.places[cell], pixel.position);
    const float score = share > whole_share ? 2.0f - 0.1f * glm::dot(way, way) : share;
    if (score <= best) return;
    best = score;
    pixel.normal = from.cells.places[cell].normal;
    pixel.has_plane = true;
  });
}

// Asks whether something hides cells from the pixel, of those in whose reach anything is.
void PixelRow::ask(const CellsToSpread& from, uint32_t x, int ring) {
  const Pixel& pixel = pixels_[x];
  for_cells_about(from.cells, x, y_, ring, [&](size_t cell, glm::vec2, uint32_t bit) {
    const CellPlace& there = from.cells.places[cell];
    const glm::vec3 way = there.position - pixel.position;
    if (!from.walls.is_near(cell, glm::dot(way, way))) return;
    if (pixel.has_plane && use_of(from, pixel, cell, bit) != Use::same_plane) return;
    rays_.push_back(ray_between(there, {pixel.position, pixel.normal}));
    questions_.push_back({x, bit});
  });
}

void PixelRow::answer(const Intersector& intersector) {
  if (rays_.empty()) return;
  occluded_.resize(rays_.size());
  intersector.occluded(rays_, false, occluded_.data(), OpaqueSet::visible_in_reflection);
  for (size_t i = 0; i < rays_.size(); ++i)
    if (occluded_[i]) pixels_[questions_[i].pixel].hidden |= questions_[i].hidden;
  rays_.clear(), questions_.clear();
}

PixelRow::Use PixelRow::use_of(const CellsToSpread& from, const Pixel& pixel, size_t cell, uint32_t bit) const {
  if (!(from.lights[cell].w > 0.0f)) return Use::none;
  if (pixel.hidden & bit) return Use::other_side;
  const CellPlace& there = from.cells.places[cell];
  const bool is_same = pixel.has_plane && glm::dot(there.normal, pixel.normal) > same_normal &&
                       plane_share(there, pixel.position) > 0.0f;
  return is_same ? Use::same_plane : Use::other_plane;
}

bool PixelRow::has_light(const CellsToSpread& from, uint32_t x, int ring) const {
  bool has = false;
  for_cells_about(from.cells, x, y_, ring, [&](size_t cell, glm::vec2, uint32_t bit) {
    has = has || use_of(from, pixels_[x], cell, bit) == Use::same_plane;
  });
  return has;
}

void PixelRow::find(const FrameCamera& camera, const CellsToSpread& from, const Intersector& intersector,
                    const float* depths, uint32_t width, uint32_t y) {
  y_ = y;
  pixels_.assign(width, {});
  for (uint32_t x = 0; x < width; ++x) {
    const double depth = depths[x];
    if (!(depth > 0.0)) continue;
    const glm::dvec2 at(x, y);
    const glm::dvec3 ray = camera.ray_at(at);
    pixels_[x].position = glm::vec3(camera.origin_at(at) + depth * ray);
    pixels_[x].rings = 1;
    find_plane(from, x, -glm::normalize(glm::vec3(ray)));
    ask(from, x, 1);
  }
  answer(intersector);
  for (uint32_t x = 0; x < width; ++x) {
    if (pixels_[x].rings == 0 || has_light(from, x, 1)) continue;
    pixels_[x].rings = most_rings;
    ask(from, x, most_rings);
  }
  answer(intersector);
}

// The mean of the cells that are of most use.
glm::vec4 PixelRow::light(const CellsToSpread& from, uint32_t x) const {
  const Pixel& pixel = pixels_[x];
  const float beyond = 1.5f * static_cast<float>(pixel.rings);
  Use most = Use::none;
  glm::vec3 sum(0.0f);
  float weights = 0.0f;
  if (pixel.rings == 0) return glm::vec4(0.0f);
  for_cells_about(from.cells, x, y_, pixel.rings, [&](size_t cell, glm::vec2 way, uint32_t bit) {
    const Use use = use_of(from, pixel, cell, bit);
    const glm::vec2 near = glm::max(beyond - glm::abs(way), 0.0f);
    float weight = near.x * near.y;
    if (use == Use::same_plane) weight *= plane_share(from.cells.places[cell], pixel.position);
    if (use < most || !(weight > 0.0f)) return;
    if (use > most) sum = glm::vec3(0.0f), weights = 0.0f, most = use;
    sum += weight * glm::vec3(from.lights[cell]);
    weights += weight;
  });
  return weights > 0.0f && most != Use::none ? glm::vec4(sum / weights, 1.0f) : glm::vec4(0.0f);
}

}  // namespace sideray::rt
