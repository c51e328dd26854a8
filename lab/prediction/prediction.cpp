#include "lab/prediction/prediction.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace sideray::lab {
namespace {

using Count = uint64_t sideray_plan_work::*;

// These counts depend on the picture; the bytes of the cache depend on its size alone.
constexpr Count drawn_counts[] = {&sideray_plan_work::rays_primary, &sideray_plan_work::rays_reflection,
                                  &sideray_plan_work::rays_shadow,  &sideray_plan_work::rays_ao,
                                  &sideray_plan_work::rays_bounce,  &sideray_plan_work::fragments,
                                  &sideray_plan_work::bytes_readback, &sideray_plan_work::bytes_upload};
constexpr const char* count_names[] = {"rays_primary", "rays_reflection", "rays_shadow", "rays_ao",
                                       "rays_bounce",  "fragments",       "bytes_readback", "bytes_upload"};
static_assert(std::size(drawn_counts) == std::size(count_names));

// Smaller frames show too little of small objects, and their time says little about the whole.
constexpr double fewest_pixels = 40000;

FrameSize scaled(FrameSize whole, double scale) {
  const auto side = [&](uint32_t length) {
    return std::clamp(static_cast<uint32_t>(std::lround(length * scale)), 1u, length);
  };
  return {side(whole.width), side(whole.height)};
}

nlohmann::json to_json(const FrameCost& cost) {
  nlohmann::json json = {{"pixels", cost.pixels}, {"stage_ms", cost.stage_ms}};
  for (size_t i = 0; i < std::size(drawn_counts); ++i) json[count_names[i]] = cost.work.*drawn_counts[i];
  return json;
}

FrameCost parse_cost(const nlohmann::json& json) {
  FrameCost cost;
  cost.pixels = json.at("pixels").get<uint64_t>();
  const nlohmann::json& stages = json.at("stage_ms");
  for (size_t i = 0; i < cost.stage_ms.size(); ++i) cost.stage_ms[i] = stages.at(i).get<double>();
  for (size_t i = 0; i < std::size(drawn_counts); ++i)
    cost.work.*drawn_counts[i] = json.at(count_names[i]).get<uint64_t>();
  return cost;
}

}  // namespace

ProbeSizes probe_sizes(FrameSize whole) {
  const double least = std::sqrt(fewest_pixels / static_cast<double>(whole.pixels()));
  const double small = std::min(std::max(0.25, least), 1.0);
  return {scaled(whole, small), scaled(whole, std::min(2 * small, 1.0))};
}

double count_at(double small_pixels, double small, double large_pixels, double large, double pixels) {
  if (large_pixels >= pixels || small_pixels >= large_pixels) return large * pixels / large_pixels;
  const double n0 = std::sqrt(small_pixels), n1 = std::sqrt(large_pixels), n = std::sqrt(pixels);
  const double area = (large / n1 - small / n0) / (n1 - n0);
  const double edge = small / n0 - area * n0;
  return std::max((area * n + edge) * n, 0.0);
}

double time_at(double small_pixels, double small, double large_pixels, double large, double pixels) {
  if (large_pixels >= pixels || small_pixels >= large_pixels) return large * pixels / large_pixels;
  const double a_pixel = (large - small) / (large_pixels - small_pixels);
  if (a_pixel <= 0) return large;
  const double fixed = small - a_pixel * small_pixels;
  return fixed <= 0 ? large * pixels / large_pixels : fixed + a_pixel * pixels;
}

FrameCost predict(const Probe& probe, uint64_t pixels, const sideray_plan_work& most, uint32_t positions) {
  const auto n0 = static_cast<double>(probe.small.pixels), n1 = static_cast<double>(probe.large.pixels);
  const auto n = static_cast<double>(pixels);
  FrameCost cost;
  cost.pixels = pixels * positions;
  for (const Count count : drawn_counts) {
    const double value =
        count_at(n0, static_cast<double>(probe.small.work.*count), n1, static_cast<double>(probe.large.work.*count), n);
    cost.work.*count = std::min(static_cast<uint64_t>(std::llround(value * positions)), most.*count);
  }
  cost.work.bytes_cache = most.bytes_cache;
  for (size_t i = 0; i < cost.stage_ms.size(); ++i)
    cost.stage_ms[i] = positions * time_at(n0, probe.small.stage_ms[i], n1, probe.large.stage_ms[i], n);
  return cost;
}

nlohmann::json to_json(const Probe& probe) {
  return {{"small", to_json(probe.small)}, {"large", to_json(probe.large)}};
}

std::optional<Probe> parse_probe(const nlohmann::json& json) {
  try {
    const Probe probe{parse_cost(json.at("small")), parse_cost(json.at("large"))};
    if (probe.small.pixels == 0 || probe.large.pixels < probe.small.pixels) return {};
    return probe;
  } catch (const nlohmann::json::exception&) {
    return {};
  }
}

}  // namespace sideray::lab
