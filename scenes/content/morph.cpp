#include "scenes/content/morph.h"

#include <algorithm>
#include <cmath>

#include "elementary/functions.h"
#include "scenes/base/limits.h"

namespace sideray::scenes {
namespace {

using Attribute = std::vector<float> MorphTarget::*;

bool changes(const MorphTargets& targets, std::span<const double> weights, Attribute attribute) {
  for (size_t t = 0; t < targets.size(); ++t)
    if (weights[t] != 0.0 && !(targets[t].*attribute).empty()) return true;
  return false;
}

// Returns the blended values, `stride` a vertex in the base and `components` of them in the targets.
std::vector<double> sum(const std::vector<float>& base, const MorphTargets& targets, std::span<const double> weights,
                        Attribute attribute, size_t stride, size_t components) {
  std::vector<double> values(base.begin(), base.end());
  for (size_t t = 0; t < targets.size(); ++t) {
    const std::vector<float>& added = targets[t].*attribute;
    if (weights[t] == 0.0 || added.empty()) continue;
    for (size_t v = 0; v < base.size() / stride; ++v)
      for (size_t c = 0; c < components; ++c)
        values[v * stride + c] += weights[t] * double{added[v * components + c]};
  }
  return values;
}

void blend_positions(const Mesh& base, const MorphTargets& targets, std::span<const double> weights,
                     std::vector<float>& to) {
  to = base.positions;
  if (!changes(targets, weights, &MorphTarget::positions)) return;
  const std::vector<double> values = sum(base.positions, targets, weights, &MorphTarget::positions, 3, 3);
  for (size_t v = 0; v + 2 < values.size(); v += 3) {
    const bool is_somewhere = std::all_of(&values[v], &values[v] + 3,
                                          [](double x) { return std::abs(x) <= limits::coordinate; });
    for (size_t c = 0; is_somewhere && c < 3; ++c) to[v + c] = static_cast<float>(values[v + c]);
  }
}

// Blends directions of 3 numbers a vertex, or of 4, whose last number stays. Where the sum is 0 the base's direction
// stays.
void blend_directions(const std::vector<float>& base, const MorphTargets& targets, std::span<const double> weights,
                      Attribute attribute, size_t stride, std::vector<float>& to) {
  to = base;
  if (base.empty() || !changes(targets, weights, attribute)) return;
  const std::vector<double> values = sum(base, targets, weights, attribute, stride, 3);
  for (size_t v = 0; v + stride <= values.size(); v += stride) {
    const double length = elementary::hypot(values[v], values[v + 1], values[v + 2]);
    for (size_t c = 0; length > 1e-30 && std::isfinite(length) && c < 3; ++c)
      to[v + c] = static_cast<float>(values[v + c] / length);
  }
}

void blend_values(const std::vector<float>& base, const MorphTargets& targets, std::span<const double> weights,
                  Attribute attribute, size_t components, std::vector<float>& to) {
  to = base;
  if (base.empty() || !changes(targets, weights, attribute)) return;
  const std::vector<double> values = sum(base, targets, weights, attribute, components, components);
  const bool is_color = attribute == &MorphTarget::colors;
  std::transform(values.begin(), values.end(), to.begin(), [is_color](double x) {
    return static_cast<float>(is_color ? std::clamp(x, 0.0, 1.0) : x);
  });
}

}  // namespace

void blend(const Mesh& base, const MorphTargets& targets, std::span<const double> weights, Mesh& mesh) {
  blend_positions(base, targets, weights, mesh.positions);
  blend_directions(base.normals, targets, weights, &MorphTarget::normals, 3, mesh.normals);
  blend_directions(base.tangents, targets, weights, &MorphTarget::tangents, 4, mesh.tangents);
  blend_values(base.uv0, targets, weights, &MorphTarget::uv0, 2, mesh.uv0);
  blend_values(base.uv1, targets, weights, &MorphTarget::uv1, 2, mesh.uv1);
  blend_values(base.colors, targets, weights, &MorphTarget::colors, 4, mesh.colors);
}

std::vector<float> generic_positions(const MorphedMesh& morphed) {
  constexpr double golden = 0.6180339887498949;
  std::vector<double> weights(morphed.targets->size());
  for (size_t t = 0; t < weights.size(); ++t) {
    const double turn = golden * static_cast<double>(t + 1);
    weights[t] = 0.25 + 0.5 * (turn - std::floor(turn));
  }
  std::vector<float> positions;
  blend_positions(morphed.base, *morphed.targets, weights, positions);
  return positions;
}

}  // namespace sideray::scenes
