#include "rt/textures/sky_directions.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>

#include "elementary/functions.h"
#include "rt/textures/environment_lookup.h"

namespace sideray::rt {
namespace {

constexpr uint32_t faces = 6;
constexpr uint32_t cells_across = 16, face_cells = cells_across * cells_across, cell_count = faces * face_cells;
// Odd: the normals of walls and floors are at cells' centres. At an edge of cells, rounding would select their table.
constexpr uint32_t facings_across = 9, facing_count = faces * facings_across * facings_across;
constexpr uint32_t guide_count = 1024;
// Share of the samples that ignore the environment. They bound every weight: if a table is too low, because a normal is
// not at its cell's centre, only noise grows (defensive sampling, Hesterberg 1995).
constexpr double blind = 0.25;
// About the sine of the largest angle between a direction or normal and its cell's centre.
constexpr float doubt = 0.2f;

// Returns the point at the coordinates -1..1 on a face of the cube. The faces are +X, -X, +Y, and so on.
glm::vec3 point_on(uint32_t face, float s, float t) {
  const float side = face % 2 == 0 ? 1.0f : -1.0f;
  return face < 2 ? glm::vec3(side, s, t) : face < 4 ? glm::vec3(t, side, s) : glm::vec3(s, t, side);
}

// Returns a vector along a face.
glm::vec3 shift_along(uint32_t face, float s, float t) {
  return face < 2 ? glm::vec3(0.0f, s, t) : face < 4 ? glm::vec3(t, 0.0f, s) : glm::vec3(s, t, 0.0f);
}

uint32_t cell_along(float s, uint32_t across) {
  const float x = (0.5f * s + 0.5f) * static_cast<float>(across);
  return x > 0.0f ? std::min(static_cast<uint32_t>(x), across - 1) : 0;
}

// Returns the cell of a direction, in a cube with `across` by `across` cells a face.
uint32_t cell_of(glm::vec3 d, uint32_t across) {
  const glm::vec3 size = glm::abs(d);
  const bool on_x = size.x >= size.y && size.x >= size.z, on_y = !on_x && size.y >= size.z;
  const glm::vec3 turned = on_x ? d : on_y ? glm::vec3(d.y, d.z, d.x) : glm::vec3(d.z, d.x, d.y);
  const uint32_t face = (on_x ? 0u : on_y ? 2u : 4u) + (turned.x < 0.0f ? 1u : 0u);
  const float scale = 1.0f / std::abs(turned.x);
  return (face * across + cell_along(turned.z * scale, across)) * across + cell_along(turned.y * scale, across);
}

// Returns the coordinate -1..1 along a face's side at `within` cells behind the start of cell i.
float along_side(uint32_t i, float within, uint32_t across) {
  return (static_cast<float>(i) + within) * (2.0f / static_cast<float>(across)) - 1.0f;
}

glm::vec3 point_of(uint32_t cell, float within, uint32_t across) {
  return point_on(cell / (across * across), along_side(cell % across, within, across),
                  along_side(cell / across % across, within, across));
}

glm::vec3 middle_of(uint32_t cell, uint32_t across) {
  return glm::normalize(point_of(cell, 0.5f, across));
}

// Returns a cosine that is positive if it is for any direction and normal of the two cells.
float cosine_of_cells(float cosine) {
  if (cosine >= doubt) return cosine;
  const float above = std::max(cosine + doubt, 0.0f);
  return above * above / (4.0f * doubt);
}

}  // namespace

SkyDirections::SkyDirections(std::shared_ptr<const model::Environment> environment)
    : environment_(std::move(environment)) {
  if (environment_->black) return;
  const std::vector<float> solid_angles = sum_cells();
  if (!cells_.empty()) sum_facings(solid_angles);
}

// Integrates over the texels, or over points between them in small images. Returns the cells' solid angles. Makes no
// cells for a black environment.
std::vector<float> SkyDirections::sum_cells() {
  const model::Environment::Image& image = environment_->specular.front();
  const uint32_t width = std::max(image.width, 512u), height = std::max(image.height, 256u);
  std::vector<double> power(cell_count), solid_angle(cell_count);
  std::vector<glm::vec2> turns(width);
  for (uint32_t x = 0; x < width; ++x) {
    const double turn = ((x + 0.5) / width - 0.5) * glm::two_pi<double>();
    turns[x] = {elementary::sin(turn), -elementary::cos(turn)};
  }
  for (uint32_t y = 0; y < height; ++y) {
    const double angle = (y + 0.5) / height * glm::pi<double>();
    const double share = elementary::sin(angle) * glm::pi<double>() / height * glm::two_pi<double>() / width;
    const auto sine = static_cast<float>(elementary::sin(angle)), cosine = static_cast<float>(elementary::cos(angle));
    for (uint32_t x = 0; x < width; ++x) {
      const glm::vec3 d(turns[x].x * sine, cosine, turns[x].y * sine);
      const glm::vec3 c = environment_specular(*environment_, d, 0.0f);
      const uint32_t cell = cell_of(d, cells_across);
      power[cell] += share * (double{c.x} + double{c.y} + double{c.z}) / 3.0;
      solid_angle[cell] += share;
    }
  }
  if (std::all_of(power.begin(), power.end(), [](double p) { return p <= 0.0; })) return {};
  cells_.resize(cell_count);
  for (uint32_t i = 0; i < cell_count; ++i) cells_[i] = {point_of(i, 0.0f, cells_across), static_cast<float>(power[i])};
  return {solid_angle.begin(), solid_angle.end()};
}

void SkyDirections::sum_facings(const std::vector<float>& solid_angles) {
  shares_.resize(size_t{facing_count} * cell_count);
  guides_.resize(size_t{facing_count} * guide_count);
  std::vector<glm::vec3> middles(cell_count);
  for (uint32_t i = 0; i < cell_count; ++i) middles[i] = middle_of(i, cells_across);
  std::vector<float> cosines(cell_count);
  for (uint32_t f = 0; f < facing_count; ++f) {
    const glm::vec3 normal = middle_of(f, facings_across);
    double power = 0.0, aperture = 0.0, sum = 0.0;
    for (uint32_t i = 0; i < cell_count; ++i) {
      cosines[i] = cosine_of_cells(glm::dot(normal, middles[i]));
      power += double{cosines[i] * cells_[i].power};
      aperture += double{cosines[i] * solid_angles[i]};
    }
    const double seeing = power > 0.0 ? (1.0 - blind) / power : 0.0;
    const double not_seeing = (power > 0.0 ? blind : 1.0) / aperture;
    float* shares = &shares_[size_t{f} * cell_count];
    for (uint32_t i = 0; i < cell_count; ++i) {
      sum += double{cosines[i]} * (seeing * double{cells_[i].power} + not_seeing * double{solid_angles[i]});
      shares[i] = static_cast<float>(sum);
    }
    uint32_t cell = 0;
    for (uint32_t g = 0; g < guide_count; ++g) {
      while (cell + 1 < cell_count && shares[cell] <= static_cast<float>(g) / guide_count) ++cell;
      guides_[size_t{f} * guide_count + g] = static_cast<uint16_t>(cell);
    }
  }
}

uint32_t SkyDirections::facing(glm::vec3 normal) {
  return cell_of(normal, facings_across);
}

SkyDirections::Draw SkyDirections::draw(uint32_t facing, glm::vec3 normal, glm::vec2 u) const {
  const float* shares = &shares_[size_t{facing} * cell_count];
  uint32_t i = guides_[size_t{facing} * guide_count + static_cast<size_t>(u.x * guide_count)];
  while (i + 1 < cell_count && shares[i] <= u.x) ++i;
  // Rounding may leave the last cells without a share although the largest numbers select them.
  const float low = i > 0 ? shares[i - 1] : 0.0f, share = std::max(shares[i] - low, 0x1p-24f);
  const float within = std::min((u.x - low) / share, 1.0f) * (2.0f / cells_across), above = u.y * (2.0f / cells_across);
  const Cell& cell = cells_[i];
  const glm::vec3 point = cell.corner + shift_along(i / face_cells, within, above);
  const glm::vec3 direction = point * (1.0f / std::sqrt(glm::dot(point, point)));
  return {direction, std::max(glm::dot(normal, direction), 0.0f) * cell.power / share};
}

}  // namespace sideray::rt
