#include "rt/textures/environment_sampler.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>

#include "elementary/functions.h"
#include "rt/textures/environment_lookup.h"
#include "shaders/shading/shading_cpp.h"

namespace sideray::rt {
namespace {

using Image = model::Environment::Image;

// Returns the upper edge of a row of cells, as the cosine to +Y.
double edge_cosine(uint32_t row, uint32_t rows) {
  return elementary::cos(glm::pi<double>() * row / rows);
}

// Returns the solid angle of one cell of a row.
double cell_solid_angle(uint32_t row, uint32_t rows, uint32_t columns) {
  return (edge_cosine(row, rows) - edge_cosine(row + 1, rows)) * glm::two_pi<double>() / columns;
}

// Integrates the bilinear look-up over each texel of a row, so that a weight is positive wherever the look-up is.
std::vector<double> row_weights(const Image& image, uint32_t y) {
  const uint32_t w = image.width, h = image.height;
  const uint32_t above = y == 0 ? 0 : y - 1, below = std::min(y + 1, h - 1);
  const auto texel = [&](uint32_t x, uint32_t row) {
    const glm::vec3 c = image.texels[size_t{row} * w + x];
    return double{c.x} + double{c.y} + double{c.z};
  };
  std::vector<double> blurred(w), weights(w);
  for (uint32_t x = 0; x < w; ++x) blurred[x] = (texel(x, above) + 6.0 * texel(x, y) + texel(x, below)) / 8.0;
  for (uint32_t x = 0; x < w; ++x)
    weights[x] = (blurred[x == 0 ? w - 1 : x - 1] + 6.0 * blurred[x] + blurred[x + 1 == w ? 0 : x + 1]) / 8.0;
  return weights;
}

// Writes the cumulative normalized weights, and returns the weights' sum.
double accumulate(const std::vector<double>& weights, float* shares) {
  double total = 0;
  for (const double w : weights) total += w;
  double sum = 0;
  shares[0] = 0.0f;
  for (size_t i = 0; i < weights.size(); ++i) {
    sum += weights[i];
    shares[i + 1] =
        total > 0.0 ? static_cast<float>(sum / total) : static_cast<float>(i + 1) / static_cast<float>(weights.size());
  }
  shares[weights.size()] = 1.0f;
  return total;
}

struct Choice {
  uint32_t cell;
  float within;  // position in the cell, 0..1
};

// Finds the cell, out of `count`, whose share contains u.
Choice choose(const float* shares, uint32_t count, float u) {
  const float* next = std::upper_bound(shares + 1, shares + count, u);
  const auto cell = static_cast<uint32_t>(next - shares - 1);
  const float low = shares[cell], size = shares[cell + 1] - low;
  return {cell, size > 0.0f ? std::min((u - low) / size, 1.0f) : 0.5f};
}

}  // namespace

EnvironmentSampler::EnvironmentSampler(std::shared_ptr<const model::Environment> environment)
    : environment_(std::move(environment)) {
  if (environment_->black) return;
  const Image& image = environment_->specular.front();
  width_ = image.width;
  columns_.resize(size_t{image.height} * (width_ + 1));
  std::vector<double> row_sums(image.height);
  double total = 0;
  for (uint32_t y = 0; y < image.height; ++y) {
    row_sums[y] = accumulate(row_weights(image, y), &columns_[size_t{y} * (width_ + 1)]) *
                  cell_solid_angle(y, image.height, width_);
    total += row_sums[y];
  }
  mean_radiance_ = static_cast<float>(total / 3.0 / (4.0 * glm::pi<double>()));
  if (!(total > 0.0)) return;
  rows_.resize(size_t{image.height} + 1);
  accumulate(row_sums, rows_.data());
  edges_.push_back(1.0);
  for (uint32_t y = 0; y < image.height; ++y) {
    edges_.push_back(edge_cosine(y + 1, image.height));
    row_densities_.push_back((rows_[y + 1] - rows_[y]) / static_cast<float>(cell_solid_angle(y, image.height, width_)));
  }
}

EnvironmentSampler::Sample EnvironmentSampler::sample(glm::vec2 u) const {
  const auto height = static_cast<uint32_t>(rows_.size() - 1);
  const Choice row = choose(rows_.data(), height, u.y);
  const float* columns = &columns_[size_t{row.cell} * (width_ + 1)];
  const Choice column = choose(columns, width_, u.x);
  const double top = edges_[row.cell], bottom = edges_[row.cell + 1];
  const auto cosine = static_cast<float>(top + (bottom - top) * double{row.within});
  const float across = (static_cast<float>(column.cell) + column.within) / static_cast<float>(width_);
  const float azimuth = (across - 0.5f) * glm::two_pi<float>();
  const float sine = std::sqrt(std::max(1.0f - cosine * cosine, 0.0f));
  return {{sine * elementary::sin(azimuth), cosine, -sine * elementary::cos(azimuth)},
          row_densities_[row.cell] * (columns[column.cell + 1] - columns[column.cell])};
}

float EnvironmentSampler::density(glm::vec3 direction) const {
  if (black()) return 0.0f;
  const auto height = static_cast<uint32_t>(rows_.size() - 1);
  const glm::vec2 uv = shading::sr_latlong(direction);
  const auto cell = [](float x, uint32_t count) {
    return std::min(static_cast<uint32_t>(std::max(x, 0.0f) * static_cast<float>(count)), count - 1);
  };
  const uint32_t row = cell(uv.y, height), column = cell(uv.x, width_);
  const float* columns = &columns_[size_t{row} * (width_ + 1)];
  return row_densities_[row] * (columns[column + 1] - columns[column]);
}

glm::vec3 EnvironmentSampler::radiance(glm::vec3 direction) const {
  return environment_specular(*environment_, direction, 0.0f);
}

}  // namespace sideray::rt
