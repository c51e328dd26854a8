#include "viewer/drawing/modes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string>

#include "lab/metrics/metrics.h"
#include "scenes/images/images.h"

namespace sideray::viewer {
namespace {

constexpr Mode list[] = {
    {"colours", "Picture", 0, "", Coloring::color, true},
    {"distance", "Opaque surfaces", SIDERAY_AOV_Z, "Z", Coloring::distance, false},
    {"normals", "Opaque surfaces", SIDERAY_AOV_NORMAL, "N", Coloring::direction, false},
    {"albedo", "Opaque surfaces", SIDERAY_AOV_ALBEDO, "albedo", Coloring::color, false},
    {"roughness", "Opaque surfaces", SIDERAY_AOV_MATERIAL, "material.roughness", Coloring::share, false},
    {"metallic", "Opaque surfaces", SIDERAY_AOV_MATERIAL, "material.metallic", Coloring::share, false},
    {"objects", "Opaque surfaces", SIDERAY_AOV_ID, "id.surface", Coloring::number, false},
    {"triangles", "Opaque surfaces", SIDERAY_AOV_ID, "id.primitive", Coloring::number, false},
    {"motion", "Opaque surfaces", SIDERAY_AOV_MOTION, "motion", Coloring::offset, false},
    {"shadow of the first light", "Rays", SIDERAY_AOV_SHADOW, "shadow.0", Coloring::share, true},
    {"shadow of all lights", "Rays", SIDERAY_AOV_SHADOW, "shadow.combined", Coloring::share, true},
    {"distance to the first light's shadow", "Rays", SIDERAY_AOV_HIT_DISTANCE, "hitdist.0", Coloring::distance, true},
    {"inexact shadow test", "Rays", SIDERAY_AOV_INEXACT, "mask.inexact", Coloring::count, true},
    {"translucent surfaces, counted", "Rays", SIDERAY_AOV_MASK, "mask.count", Coloring::count, true},
    {"age of light", "Rays", SIDERAY_AOV_ANSWERS, "answer.lights", Coloring::age, true},
    {"age of the sky's light", "Rays", SIDERAY_AOV_ANSWERS, "answer.sky", Coloring::age, true},
    {"age of reflections", "Rays", SIDERAY_AOV_ANSWERS, "answer.reflections", Coloring::age, true},
    {"age of glass", "Rays", SIDERAY_AOV_ANSWERS, "answer.layers", Coloring::age, true},
    {"layer 0", "Rays", SIDERAY_AOV_LAYERS, "layer0", Coloring::color, true},
    {"layer 1", "Rays", SIDERAY_AOV_LAYERS, "layer1", Coloring::color, true},
    {"layer 2", "Rays", SIDERAY_AOV_LAYERS, "layer2", Coloring::color, true},
    {"layer 3", "Rays", SIDERAY_AOV_LAYERS, "layer3", Coloring::color, true},
    {"first surface: distance", "Ground truth", SIDERAY_AOV_FIRST, "first.Z", Coloring::distance, false},
    {"first surface: object", "Ground truth", SIDERAY_AOV_FIRST, "first.surface", Coloring::number, false},
    {"first surface: normals", "Ground truth", SIDERAY_AOV_FIRST, "first.N", Coloring::direction, false},
    {"glass: object", "Ground truth", SIDERAY_AOV_GLASS, "glass.surface", Coloring::number, false},
    {"behind glass: object", "Ground truth", SIDERAY_AOV_BEHIND, "behind.surface", Coloring::number, false},
    {"behind glass: distance", "Ground truth", SIDERAY_AOV_BEHIND, "behind.Z", Coloring::distance, false},
    {"refraction", "Ground truth", SIDERAY_AOV_REFRACTION, "refraction", Coloring::offset, false},
};

const sideray_channel* find(const Picture& picture, const std::string& name, sideray_channel& channel) {
  for (size_t i = 0; i < picture.channel_count(); ++i)
    if (channel = picture.channel(i); name == channel.name) return &channel;
  return nullptr;
}

uint8_t byte_of(float value) {
  return static_cast<uint8_t>(std::lround(255.0f * std::clamp(value, 0.0f, 1.0f)));
}

// Returns the planes NAME.a, NAME.b, ... in this order; empty if one is missing.
std::vector<const float*> planes_of(const Picture& picture, const Mode& mode, std::initializer_list<const char*> parts) {
  std::vector<const float*> planes;
  for (const char* part : parts) {
    const float* plane = floats_of(picture, (std::string(mode.channel) + part).c_str());
    if (!plane) return {};
    planes.push_back(plane);
  }
  return planes;
}

std::vector<uint8_t> colors(const Picture& picture, const Mode& mode) {
  const std::string dot = *mode.channel ? "." : "";
  scenes::Image image{picture.width(), picture.height(), {}, true};
  for (const char* part : {"R", "G", "B"}) {
    const float* plane = floats_of(picture, (mode.channel + dot + part).c_str());
    if (!plane) return {};
    image.planes.push_back({part, scenes::Plane::Type::single, {plane, plane + size_t{image.width} * image.height}, {}});
  }
  return scenes::quantize(scenes::display_values(image, 0, scenes::Tonemap::none));
}

std::vector<uint8_t> directions(const Picture& picture, const Mode& mode, size_t pixels) {
  std::vector<uint8_t> rgb;
  const auto planes = planes_of(picture, mode, {".X", ".Y", ".Z"});
  for (size_t i = 0; !planes.empty() && i < pixels; ++i)
    for (const float* plane : planes) rgb.push_back(byte_of(0.5f + 0.5f * plane[i]));
  return rgb;
}

// Middle grey is no motion; each pixel of motion is a hundredth of the way to black or white.
std::vector<uint8_t> offsets(const Picture& picture, const Mode& mode, size_t pixels) {
  std::vector<uint8_t> rgb;
  const auto planes = planes_of(picture, mode, {".X", ".Y"});
  for (size_t i = 0; !planes.empty() && i < pixels; ++i) {
    for (const float* plane : planes) rgb.push_back(byte_of(0.5f + 0.01f * plane[i]));
    rgb.push_back(128);
  }
  return rgb;
}

// Near is light and far is dark, on a logarithmic scale between the nearest and the farthest hundredth of the pixels;
// black means that nothing is hit.
std::vector<uint8_t> distances(const float* z, size_t pixels) {
  std::vector<float> finite;
  for (size_t i = 0; i < pixels; ++i)
    if (std::isfinite(z[i]) && z[i] > 0) finite.push_back(std::log(z[i]));
  if (finite.empty()) return std::vector<uint8_t>(3 * pixels);
  std::sort(finite.begin(), finite.end());
  const float low = finite[finite.size() / 100], high = finite[finite.size() - 1 - finite.size() / 100];
  std::vector<float> values(pixels);
  for (size_t i = 0; i < pixels; ++i)
    if (std::isfinite(z[i]) && z[i] > 0)
      values[i] = 1.0f - 0.85f * std::clamp((std::log(z[i]) - low) / std::max(high - low, 1e-6f), 0.0f, 1.0f);
  return lab::false_colours(values);
}

std::vector<uint8_t> shares(const float* values, size_t pixels) {
  std::vector<uint8_t> rgb;
  for (size_t i = 0; i < pixels; ++i) rgb.insert(rgb.end(), 3, byte_of(values[i]));
  return rgb;
}

// Returns a colour for a number; consecutive numbers have very different ones. 0 is black.
std::vector<uint8_t> hashes(const uint32_t* values, size_t pixels) {
  std::vector<uint8_t> rgb;
  for (size_t i = 0; i < pixels; ++i) {
    uint32_t hash = values[i] * 0x9e3779b1u;
    hash = (hash ^ (hash >> 15)) * 0x85ebca6bu;
    hash ^= hash >> 13;
    for (int k = 0; k < 3; ++k) rgb.push_back(values[i] == 0 ? 0 : static_cast<uint8_t>(56 + ((hash >> (8 * k)) & 0xffu) * 3 / 4));
  }
  return rgb;
}

std::vector<uint8_t> counts(const uint32_t* values, size_t pixels) {
  const uint32_t most = std::max(1u, *std::max_element(values, values + pixels));
  std::vector<float> shares_of_most(pixels);
  for (size_t i = 0; i < pixels; ++i) shares_of_most[i] = static_cast<float>(values[i]) / static_cast<float>(most);
  return lab::false_colours(shares_of_most);
}

// See age_legend; at the age `oldest` the colour is red.
std::array<uint8_t, 3> color_of_answer(uint32_t answer) {
  constexpr float oldest = 32;
  if (answer == 0) return {30, 30, 32};
  if (answer == 1) return {150, 70, 190};
  if (answer == 2) return {70, 150, 90};
  const float age = std::min(std::log2(static_cast<float>(answer) - 2.0f) / std::log2(oldest + 1.0f), 1.0f);
  return {230, static_cast<uint8_t>(220.0f - 170.0f * age), 60};
}

std::vector<uint8_t> ages(const uint32_t* answers, size_t pixels) {
  std::vector<uint8_t> rgb;
  for (size_t i = 0; i < pixels; ++i)
    for (const uint8_t c : color_of_answer(answers[i])) rgb.push_back(c);
  return rgb;
}

}  // namespace

std::span<const Mode> modes() {
  return list;
}

const float* floats_of(const Picture& picture, const char* name) {
  sideray_channel channel{};
  if (!find(picture, name, channel) || channel.type != SIDERAY_CHANNEL_FLOAT) return nullptr;
  return static_cast<const float*>(channel.values);
}

const uint32_t* numbers_of(const Picture& picture, const char* name) {
  sideray_channel channel{};
  if (!find(picture, name, channel) || channel.type != SIDERAY_CHANNEL_UINT) return nullptr;
  return static_cast<const uint32_t*>(channel.values);
}

std::vector<uint8_t> shown(const Picture& picture, const Mode& mode) {
  const size_t pixels = size_t{picture.width()} * picture.height();
  switch (mode.coloring) {
    case Coloring::color: return colors(picture, mode);
    case Coloring::direction: return directions(picture, mode, pixels);
    case Coloring::offset: return offsets(picture, mode, pixels);
    default: break;
  }
  const float* values = floats_of(picture, mode.channel);
  const uint32_t* numbers = numbers_of(picture, mode.channel);
  if (mode.coloring == Coloring::distance && values) return distances(values, pixels);
  if (mode.coloring == Coloring::share && values) return shares(values, pixels);
  if (mode.coloring == Coloring::number && numbers) return hashes(numbers, pixels);
  if (mode.coloring == Coloring::count && numbers) return counts(numbers, pixels);
  if (mode.coloring == Coloring::age && numbers) return ages(numbers, pixels);
  return {};
}

}  // namespace sideray::viewer
