#include "rt/irradiance/pixel_row.h"

#include <algorithm>
#include <cmath>

namespace sideray::rt {
namespace {

constexpr float least_share = 0.5f, whole_share = 0.99f;  // how well a position lies on a plane
constexpr float same_normal = 0.8f;                       // cosine
constexpr int most_rings = 2;                             // of cells around a pixel's own

// Returns a pixel's position in the picture, in cells.
glm::vec2 place_of(uint32_t x, uint32_t y) {
  return (glm::vec2(x, y) + 0.5f) / static_cast<float>(cell_side);
}

// Calls visit(cell, way, bit) for the cells with a surface up to `ring` away from a pixel's own: the offset in cells,
// and the cell's bit.
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

PixelColumns PixelRow::HalfRow::at(size_t cell) {
  PixelColumns columns;
  for (int k = 0; k < 3; ++k) columns.position[k] = &position[k][cell], columns.light[k] = &light[k][cell];
  columns.depth = &depth[cell];
  return columns;
}

// Computes the positions of the row's pixels.
void PixelRow::locate(const FrameCamera& camera, const float* depths, uint32_t width) {
  const size_t count = (width / cell_side / cells_at_once + 1) * cells_at_once;
  for (HalfRow& half : halves_) {
    for (int k = 0; k < 3; ++k) half.position[k].resize(count), half.light[k].resize(count);
    half.depth.assign(count, 0.0f);
  }
  for (uint32_t x = 0; x < width; ++x) {
    const double depth = depths[x];
    if (!(depth > 0.0)) continue;
    const glm::dvec2 at(x, y_);
    const glm::vec3 position(camera.origin_at(at) + depth * camera.ray_at(at));
    HalfRow& half = halves_[x % cell_side];
    for (int k = 0; k < 3; ++k) half.position[k][x / cell_side] = position[k];
    half.depth[x / cell_side] = depths[x];
  }
}

// Interpolates the light of pixels that need no rays.
void PixelRow::spread(const CellsToSpread& from, const IrradianceKernels& kernels, uint32_t width) {
  lights_.resize(width);
  pixels_.clear();
  const int32_t first = from.table.row(y_ / cell_side);
  for (uint32_t block = 0; block < from.cells.columns; block += cells_at_once) {
    uint32_t done[cell_side];
    for (uint32_t i = 0; i < cell_side; ++i)
      done[i] = kernels.spread(from.table.columns(), first + static_cast<int32_t>(block), static_cast<int32_t>(i),
                               static_cast<int32_t>(y_ % cell_side), halves_[i].at(block));
    const uint32_t x0 = block * cell_side, end = std::min(x0 + cells_at_once * cell_side, width);
    for (uint32_t x = x0; x < end; ++x) {
      const HalfRow& half = halves_[x % cell_side];
      const size_t cell = x / cell_side;
      const auto position = [&] { return glm::vec3(half.position[0][cell], half.position[1][cell], half.position[2][cell]); };
      lights_[x] = glm::vec4(0.0f);
      if (!(half.depth[cell] > 0.0f)) continue;
      if ((done[x % cell_side] >> (cell - block) & 1u) == 0) pixels_.push_back({.x = x, .position = position()});
      else lights_[x] = {half.light[0][cell], half.light[1][cell], half.light[2][cell], 1.0f};
    }
  }
}

// Finds the nearest cell that shows the pixel's plane, else the one whose plane is nearest.
void PixelRow::find_plane(const CellsToSpread& from, Pixel& pixel, glm::vec3 to_eye) {
  pixel.normal = to_eye;
  const size_t own = size_t{y_ / cell_side} * from.cells.columns + pixel.x / cell_side;
  const CellPlace& here = from.cells.places[own];
  if (here.width > 0.0f && plane_share(here, pixel.position) > whole_share) {
    pixel.normal = here.normal;
    pixel.has_plane = true;
    return;
  }
  float best = least_share;
  for_cells_about(from.cells, pixel.x, y_, 1, [&](size_t cell, glm::vec2 way, uint32_t) {
    const float share = plane_share(from.cells.places[cell], pixel.position);
    const float score = share > whole_share ? 2.0f - 0.1f * glm::dot(way, way) : share;
    if (score <= best) return;
    best = score;
    pixel.normal = from.cells.places[cell].normal;
    pixel.has_plane = true;
  });
}

// Adds a ray that tests whether something occludes a pixel's own cell. If not, that cell's walls tell which cells
// around are occluded. Returns whether the own cell is usable at all.
bool PixelRow::ask_own(const CellsToSpread& from, uint32_t number) {
  Pixel& pixel = pixels_[number];
  bool is_used = false;
  for_cells_about(from.cells, pixel.x, y_, 0, [&](size_t cell, glm::vec2, uint32_t bit) {
    is_used = pixel.has_plane && use_of(from, pixel, cell, bit) == Use::same_plane;
    if (is_used) ask(from, number, cell, bit);
  });
  return is_used;
}

// Adds rays to the cells around, for a pixel whose own cell is not usable.
void PixelRow::ask_around(const CellsToSpread& from, uint32_t number, int ring) {
  const Pixel& pixel = pixels_[number];
  for_cells_about(from.cells, pixel.x, y_, ring, [&](size_t cell, glm::vec2, uint32_t bit) {
    if (!pixel.has_plane || use_of(from, pixel, cell, bit) == Use::same_plane) ask(from, number, cell, bit);
  });
}

void PixelRow::ask(const CellsToSpread& from, uint32_t number, size_t cell, uint32_t bit) {
  const Pixel& pixel = pixels_[number];
  const CellPlace& there = from.cells.places[cell];
  const glm::vec3 way = there.position - pixel.position;
  if (!from.walls.is_near(cell, glm::dot(way, way))) return;
  rays_.push_back(ray_between(there, {pixel.position, pixel.normal}));
  questions_.push_back({number, bit});
}

void PixelRow::answer(const Intersector& intersector) {
  if (rays_.empty()) return;
  occluded_.resize(rays_.size());
  intersector.occluded(rays_, false, occluded_.data(), OpaqueSet::walls);
  for (size_t i = 0; i < rays_.size(); ++i)
    if (occluded_[i]) pixels_[questions_[i].pixel].hidden |= questions_[i].hidden;
  rays_.clear(), questions_.clear();
}

PixelRow::Use PixelRow::use_of(const CellsToSpread& from, const Pixel& pixel, size_t cell, uint32_t bit) const {
  if (!(from.cells.lights[cell].samples > 0.0f)) return Use::none;
  if (pixel.hidden & bit) return Use::other_side;
  const CellPlace& there = from.cells.places[cell];
  const bool is_same = pixel.has_plane && glm::dot(there.normal, pixel.normal) > same_normal &&
                       plane_share(there, pixel.position) > 0.0f;
  return is_same ? Use::same_plane : Use::other_plane;
}

bool PixelRow::has_light(const CellsToSpread& from, const Pixel& pixel, int ring) const {
  bool has = false;
  for_cells_about(from.cells, pixel.x, y_, ring, [&](size_t cell, glm::vec2, uint32_t bit) {
    has = has || use_of(from, pixel, cell, bit) == Use::same_plane;
  });
  return has;
}

void PixelRow::find(const FrameCamera& camera, const CellsToSpread& from, const Intersector& intersector,
                    const float* depths, uint32_t width, uint32_t y) {
  y_ = y;
  locate(camera, depths, width);
  spread(from, irradiance_kernels(intersector.isa().c_str()), width);
  for (uint32_t i = 0; i < pixels_.size(); ++i) {
    find_plane(from, pixels_[i], -glm::normalize(glm::vec3(camera.ray_at(glm::dvec2(pixels_[i].x, y)))));
    pixels_[i].by_own = ask_own(from, i);
  }
  answer(intersector);
  for (uint32_t i = 0; i < pixels_.size(); ++i) {
    Pixel& pixel = pixels_[i];
    pixel.by_own = pixel.by_own && pixel.hidden == 0;
    if (pixel.by_own) hide_behind_walls(from, pixel);
    else ask_around(from, i, 1);
  }
  answer(intersector);
  for (uint32_t i = 0; i < pixels_.size(); ++i) {
    if (pixels_[i].by_own || has_light(from, pixels_[i], 1)) continue;
    pixels_[i].rings = most_rings;
    ask_around(from, i, most_rings);
  }
  answer(intersector);
  for (const Pixel& pixel : pixels_) lights_[pixel.x] = mean_light(from, pixel);
}

// Marks cells as occluded that are occluded from the pixel's own cell.
void PixelRow::hide_behind_walls(const CellsToSpread& from, Pixel& pixel) const {
  const size_t own = size_t{y_ / cell_side} * from.cells.columns + pixel.x / cell_side;
  for_cells_about(from.cells, pixel.x, y_, 1, [&](size_t cell, glm::vec2, uint32_t bit) {
    if (cell != own && from.table.is_wall_between(own, cell)) pixel.hidden |= bit;
  });
}

// Returns the mean of the most usable cells.
glm::vec4 PixelRow::mean_light(const CellsToSpread& from, const Pixel& pixel) const {
  const float beyond = 1.5f * static_cast<float>(pixel.rings);
  Use most = Use::none;
  glm::vec3 sum(0.0f);
  float weights = 0.0f;
  for_cells_about(from.cells, pixel.x, y_, pixel.rings, [&](size_t cell, glm::vec2 way, uint32_t bit) {
    const Use use = use_of(from, pixel, cell, bit);
    const glm::vec2 near = glm::max(beyond - glm::abs(way), 0.0f);
    float weight = near.x * near.y;
    if (use == Use::same_plane) weight *= plane_share(from.cells.places[cell], pixel.position);
    if (use < most || !(weight > 0.0f)) return;
    if (use > most) sum = glm::vec3(0.0f), weights = 0.0f, most = use;
    sum += weight * from.table.light(cell);
    weights += weight;
  });
  return weights > 0.0f && most != Use::none ? glm::vec4(sum / weights, 1.0f) : glm::vec4(0.0f);
}

}  // namespace sideray::rt
