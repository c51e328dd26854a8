#include "model/environment.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <span>

#include "elementary/functions.h"
#include "model/failure.h"
#include "model/hemisphere.h"
#include "shaders/shading/shading_cpp.h"

namespace sideray::model {
namespace {

using Image = Environment::Image;

constexpr uint32_t largest_width = 8192;
constexpr float largest_radiance = 65504.0f;   // the largest half float: the rasterizer stores halfs
constexpr uint32_t smallest_level_height = 8;  // height of the last specular level
constexpr uint32_t prefilter_samples = 64;
constexpr uint32_t irradiance_width = 64, irradiance_height = 32;

glm::vec3 direction_of(float u, float v) {
  const float azimuth = (u - 0.5f) * glm::two_pi<float>(), polar = v * glm::pi<float>();
  return {elementary::sin(polar) * elementary::sin(azimuth), elementary::cos(polar), -elementary::sin(polar) * elementary::cos(azimuth)};
}

// Four floats, of which a texel uses three: the compiler computes them at once.
using Four = float __attribute__((vector_size(16)));

struct Texels {
  explicit Texels(const Image& image) : width(image.width), height(image.height), values(image.texels.size()) {
    for (size_t i = 0; i < values.size(); ++i)
      values[i] = Four{image.texels[i].x, image.texels[i].y, image.texels[i].z, 0.0f};
  }
  uint32_t width, height;
  std::vector<Four> values;
};

Four mixed(Four a, Four b, float share) {
  return a * (1.0f - share) + b * share;
}

glm::vec3 to_vec3(Four v) {
  return {v[0], v[1], v[2]};
}

// Samples bilinearly, with u wrapped and v clamped, as the GL sampler of these images does.
Four sample(const Texels& image, glm::vec2 uv) {
  const float x = uv.x * static_cast<float>(image.width) - 0.5f, y = uv.y * static_cast<float>(image.height) - 0.5f;
  const float fx = std::floor(x), fy = std::floor(y);
  const int w = static_cast<int>(image.width), h = static_cast<int>(image.height);
  int i = static_cast<int>(fx);
  const int j = static_cast<int>(fy);
  if (i < 0 || i >= w) i = ((i % w) + w) % w;  // rarely needed: divisions would take a quarter of the time
  const int next = i + 1 == w ? 0 : i + 1;
  const Four* above = &image.values[static_cast<size_t>(std::clamp(j, 0, h - 1)) * image.width];
  const Four* below = &image.values[static_cast<size_t>(std::clamp(j + 1, 0, h - 1)) * image.width];
  return mixed(mixed(above[i], above[next], x - fx), mixed(below[i], below[next], x - fx), y - fy);
}

Image import(uint32_t width, uint32_t height, const float* rgb, float scale) {
  Image source{width, height, std::vector<glm::vec3>(size_t{width} * height)};
  for (size_t i = 0; i < source.texels.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      const float value = rgb[3 * i + static_cast<size_t>(c)] * scale;
      source.texels[i][c] = std::isfinite(value) ? std::clamp(value, 0.0f, largest_radiance) : 0.0f;
    }
  return source;
}

// Turns it counter-clockwise as seen from above, which moves content toward smaller u.
Image turned(Image source, float rotation_deg) {
  const float turns = rotation_deg / 360.0f;
  if (turns - std::floor(turns) == 0.0f) return source;
  Image result = source;
  const Texels texels(source);
  for (uint32_t y = 0; y < source.height; ++y)
    for (uint32_t x = 0; x < source.width; ++x)
      result.texels[size_t{y} * source.width + x] =
          to_vec3(sample(texels, {(static_cast<float>(x) + 0.5f) / static_cast<float>(source.width) + turns,
                                  (static_cast<float>(y) + 0.5f) / static_cast<float>(source.height)}));
  return result;
}

Image halve(const Image& from) {
  Image to{std::max(1u, from.width / 2), std::max(1u, from.height / 2), {}};
  to.texels.resize(size_t{to.width} * to.height);
  for (uint32_t y = 0; y < to.height; ++y)
    for (uint32_t x = 0; x < to.width; ++x) {
      glm::vec3 sum(0);
      for (uint32_t k = 0; k < 4; ++k)
        sum += from.texels[size_t{std::min(2 * y + (k >> 1), from.height - 1)} * from.width +
                           std::min(2 * x + (k & 1), from.width - 1)];
      to.texels[size_t{y} * to.width + x] = sum * 0.25f;
    }
  return to;
}

std::vector<Image> pyramid(Image top) {
  std::vector<Image> levels{std::move(top)};
  while (levels.back().width > 4 && levels.back().height > 2) levels.push_back(halve(levels.back()));
  return levels;
}

// Holds one direction of a lobe about +Z, its weight, and the level of the source that it reads.
struct LobeSample {
  glm::vec3 direction;
  float weight, level;
};

// Samples the GGX lobe around the mirror direction n = v (Karis 2013). Each sample reads the level whose texels match
// the sample's solid angle (Krivanek and Colbert 2008), which keeps 64 samples free of noise.
std::vector<LobeSample> lobe_samples(const Texels& source, float roughness) {
  const float alpha = std::max(roughness * roughness, 1e-3f);
  const float texel_solid_angle =
      2.0f * glm::pi<float>() * glm::pi<float>() / static_cast<float>(source.width * source.height);
  std::vector<LobeSample> samples;
  for (uint32_t i = 0; i < prefilter_samples; ++i) {
    const glm::vec3 h = sample_ggx(hammersley(i, prefilter_samples), alpha);
    const glm::vec3 l(2.0f * h.z * h.x, 2.0f * h.z * h.y, 2.0f * h.z * h.z - 1.0f);
    if (l.z <= 0.0f) continue;
    const float pdf = ggx_density(h.z, alpha) * 0.25f;  // n = v: d * n.h / (4 v.h) = d / 4
    const float level =
        0.5f * elementary::log2(1.0f / (static_cast<float>(prefilter_samples) * pdf * texel_solid_angle)) + 1.0f;
    samples.push_back({l, l.z, level});
  }
  return samples;
}

// Describes how one lobe direction reads a level for all texels of a row: their lobes differ only by a rotation about
// the vertical axis, so that each reads the same two rows of the source, further to the right.
struct RowRead {
  const Four *above, *below;  // rows of the source
  float down;                 // share of the lower one
  float first, step;          // columns: of the first texel, from 0 to 2 * width, and from one texel to the next
  uint32_t width;
  float weight;
};

void add_row(std::vector<Four>& sums, const RowRead& read) {
  const int width = static_cast<int>(read.width);
  for (size_t x = 0; x < sums.size(); ++x) {
    const float column = read.first + static_cast<float>(x) * read.step;
    const int floor = static_cast<int>(column);
    int i = floor;
    while (i >= width) i -= width;  // at most twice; divisions would take a quarter of the time
    const int next = i + 1 == width ? 0 : i + 1;
    const float right = column - static_cast<float>(floor);
    const Four upper = mixed(read.above[i], read.above[next], right),
               lower = mixed(read.below[i], read.below[next], right);
    sums[x] += mixed(upper, lower, read.down) * read.weight;
  }
}

// `turn`: horizontal position that the first texel reads, from 0 to 1.
RowRead row_read(const Texels& level, float turn, float v, size_t texels, float weight) {
  const float y = v * static_cast<float>(level.height) - 0.5f, row = std::floor(y);
  const int last = static_cast<int>(level.height) - 1, j = static_cast<int>(row);
  const auto row_at = [&](int k) { return &level.values[static_cast<size_t>(std::clamp(k, 0, last)) * level.width]; };
  float first = turn * static_cast<float>(level.width) - 0.5f;
  if (first < 0.0f) first += static_cast<float>(level.width);
  return {row_at(j), row_at(j + 1), y - row, first, static_cast<float>(level.width) / static_cast<float>(texels),
          level.width, weight};
}

// Adds a sample, between mip levels, with u wrapped and v clamped, as the GL sampler of these images does.
void add_sample(std::vector<Four>& sums, const std::vector<Texels>& source, const LobeSample& sample, glm::vec2 uv) {
  const float turn = uv.x - std::floor(uv.x), top = static_cast<float>(source.size() - 1);
  const float level = std::clamp(sample.level, 0.0f, top);
  const size_t finer = static_cast<size_t>(level);
  const float share = level - static_cast<float>(finer);
  add_row(sums, row_read(source[finer], turn, uv.y, sums.size(), sample.weight * (1.0f - share)));
  if (share > 0.0f)
    add_row(sums, row_read(source[finer + 1], turn, uv.y, sums.size(), sample.weight * share));
}

// Filters one row. The frame of its lobes follows the meridian, so that all texels share the trigonometry of a
// direction, and a rotated environment gives a rotated picture.
void prefilter_row(const std::vector<Texels>& source, const std::vector<LobeSample>& samples, float v,
                   std::span<glm::vec3> row) {
  const float u = 0.5f / static_cast<float>(row.size()), polar = v * glm::pi<float>();
  const glm::vec3 n = direction_of(0.5f, v), east(1.0f, 0.0f, 0.0f), south(0.0f, -elementary::sin(polar), -elementary::cos(polar));
  std::vector<Four> sums(row.size());
  float weight = 0;
  for (const LobeSample& s : samples) {
    const glm::vec2 uv = shading::sr_latlong(east * s.direction.x + south * s.direction.y + n * s.direction.z);
    add_sample(sums, source, s, {uv.x - 0.5f + u, uv.y});
    weight += s.weight;
  }
  for (size_t x = 0; x < row.size(); ++x) row[x] = to_vec3(sums[x] / weight);
}

Image prefiltered_level(const std::vector<Texels>& source, uint32_t level, float roughness) {
  Image image{std::max(1u, source[0].width >> level), std::max(1u, source[0].height >> level), {}};
  image.texels.resize(size_t{image.width} * image.height);
  const std::vector<LobeSample> samples = lobe_samples(source[0], roughness);
  tbb::parallel_for(0u, image.height, [&](uint32_t y) {
    prefilter_row(source, samples, (static_cast<float>(y) + 0.5f) / static_cast<float>(image.height),
                  std::span(image.texels).subspan(size_t{y} * image.width, image.width));
  });
  return image;
}

// Sums the light of one row of the irradiance image. Adds each direction to all texels before the next one, so that the
// compiler computes several texels at a time.
class IrradianceRow {
 public:
  explicit IrradianceRow(uint32_t y) {
    for (uint32_t x = 0; x < irradiance_width; ++x) {
      const glm::vec3 n = direction_of((static_cast<float>(x) + 0.5f) / irradiance_width,
                                       (static_cast<float>(y) + 0.5f) / irradiance_height);
      x_[x] = n.x;
      y_[x] = n.y;
      z_[x] = n.z;
    }
  }

  void add(glm::vec3 direction, float solid_angle, glm::vec3 radiance) {
    for (uint32_t x = 0; x < irradiance_width; ++x) {
      const float cosine = x_[x] * direction.x + y_[x] * direction.y + z_[x] * direction.z;
      const float w = std::max(cosine, 0.0f) * solid_angle;
      part_.red[x] += radiance.x * w;
      part_.green[x] += radiance.y * w;
      part_.blue[x] += radiance.z * w;
      part_.weight[x] += w;
    }
  }

  // Sums floats over only one row of the source, which keeps them exact enough.
  void end_row() {
    for (uint32_t x = 0; x < irradiance_width; ++x) {
      sum_.red[x] += double{part_.red[x]};
      sum_.green[x] += double{part_.green[x]};
      sum_.blue[x] += double{part_.blue[x]};
      sum_.weight[x] += double{part_.weight[x]};
    }
    part_ = {};
  }

  // Divides by the weight instead of pi, so that a constant environment comes back exactly.
  glm::vec3 mean(uint32_t x) const {
    return glm::dvec3(sum_.red[x], sum_.green[x], sum_.blue[x]) / sum_.weight[x];
  }

 private:
  template <class Real>
  struct Sums {
    std::array<Real, irradiance_width> red{}, green{}, blue{}, weight{};
  };
  std::array<float, irradiance_width> x_, y_, z_;
  Sums<float> part_;
  Sums<double> sum_;
};

// Convolves the source at about 128 x 64 exactly with the cosine: E / pi.
Image irradiance_image(const std::vector<Image>& source) {
  size_t level = 0;
  while (level + 1 < source.size() && source[level].width > 128) ++level;
  const Image& from = source[level];
  Image image{irradiance_width, irradiance_height, {}};
  image.texels.resize(size_t{image.width} * image.height);
  std::vector<glm::vec3> directions(from.texels.size());
  std::vector<float> solid_angles(from.height);
  for (uint32_t y = 0; y < from.height; ++y) {
    const float top = static_cast<float>(y) / static_cast<float>(from.height),
                bottom = static_cast<float>(y + 1) / static_cast<float>(from.height);
    solid_angles[y] = (elementary::cos(top * glm::pi<float>()) - elementary::cos(bottom * glm::pi<float>())) * glm::two_pi<float>() /
                      static_cast<float>(from.width);
    for (uint32_t x = 0; x < from.width; ++x)
      directions[size_t{y} * from.width + x] =
          direction_of((static_cast<float>(x) + 0.5f) / static_cast<float>(from.width), 0.5f * (top + bottom));
  }
  tbb::parallel_for(0u, image.height, [&](uint32_t y) {
    IrradianceRow row(y);
    for (uint32_t from_y = 0; from_y < from.height; ++from_y) {
      for (size_t i = size_t{from_y} * from.width, end = i + from.width; i < end; ++i)
        row.add(directions[i], solid_angles[from_y], from.texels[i]);
      row.end_row();
    }
    for (uint32_t x = 0; x < image.width; ++x) image.texels[size_t{y} * image.width + x] = row.mean(x);
  });
  return image;
}

// Returns the mean radiance over all directions and channels, which equals the mean of E / pi over all normals.
float mean_radiance(const Image& irradiance) {
  double sum = 0.0, weights = 0.0;
  for (uint32_t y = 0; y < irradiance.height; ++y) {
    const double weight = elementary::sin(glm::pi<double>() * (y + 0.5) / irradiance.height);
    for (uint32_t x = 0; x < irradiance.width; ++x) {
      const glm::vec3 e = irradiance.texels[size_t{y} * irradiance.width + x];
      sum += weight * (double{e.x} + double{e.y} + double{e.z}) / 3.0;
      weights += weight;
    }
  }
  return static_cast<float>(sum / weights);
}

std::shared_ptr<const Environment> black_environment() {
  auto environment = std::make_shared<Environment>();
  const Image black{1, 1, {glm::vec3(0)}};
  environment->specular = {black};
  environment->irradiance = black;
  return environment;
}

bool is_uniform(const Image& image) {
  return std::ranges::all_of(image.texels, [&](glm::vec3 texel) { return texel == image.texels[0]; });
}

// Every lobe sees the same of such surroundings: nothing is filtered.
std::shared_ptr<const Environment> uniform_environment(Image input) {
  auto environment = std::make_shared<Environment>();
  environment->black = false;
  environment->uniform = true;
  environment->irradiance = {1, 1, {input.texels[0]}};
  environment->mean = mean_radiance(environment->irradiance);
  environment->specular.push_back(std::move(input));
  return environment;
}

}  // namespace

std::shared_ptr<const Environment> build_environment(uint32_t width, uint32_t height, const float* rgb, float scale,
                                                     float rotation_deg) {
  if (!std::isfinite(scale) || scale < 0.0f)
    fail(SIDERAY_INVALID_ARGUMENT, "environment scale {}: give a finite number, 0 or more", scale);
  if (!std::isfinite(rotation_deg)) fail(SIDERAY_INVALID_ARGUMENT, "environment rotation: not finite; give degrees");
  if (!rgb) return black_environment();
  if (width < 2 || height < 2 || width > largest_width || height > largest_width)
    fail(SIDERAY_INVALID_ARGUMENT, "environment of {}x{} pixels; give 2 to {} a side", width, height, largest_width);
  Image input = import(width, height, rgb, scale);
  if (is_uniform(input)) return uniform_environment(std::move(input));
  auto environment = std::make_shared<Environment>();
  environment->black = false;
  const std::vector<Image> source = pyramid(turned(std::move(input), rotation_deg));
  uint32_t levels = 1;
  while ((height >> levels) >= smallest_level_height) ++levels;
  environment->specular.push_back(source[0]);
  const std::vector<Texels> texels(source.begin(), source.end());
  for (uint32_t level = 1; level < levels; ++level)
    environment->specular.push_back(
        prefiltered_level(texels, level, static_cast<float>(level) / static_cast<float>(levels - 1)));
  environment->irradiance = irradiance_image(source);
  environment->mean = mean_radiance(environment->irradiance);
  return environment;
}

std::shared_ptr<const Environment> encoded_environment(const Environment& linear, sideray_radiance_space space) {
  auto encoded = std::make_shared<Environment>(linear);
  for (Environment::Image& level : encoded->specular)
    for (glm::vec3& texel : level.texels)
      for (int c = 0; c < 3; ++c) texel[c] = encode_radiance(texel[c], space, 1.0f);
  return encoded;
}

}  // namespace sideray::model
