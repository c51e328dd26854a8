// Holds animated values other than node transforms (KHR_animation_pointer): of materials, lights and cameras. Made by
// the loader, then immutable. Any thread.
#pragma once

#include <array>
#include <functional>
#include <glm/glm.hpp>
#include <utility>
#include <vector>

#include "scenes/base/material_slots.h"
#include "scenes/content/channel.h"
#include "scenes/content/content.h"

namespace sideray::scenes {

// KHR_texture_transform.
struct TextureTransform {
  glm::dvec2 offset{0.0}, scale{1.0};
  double rotation = 0;  // radians
};
// Returns the matrix for sideray_texture_slot: scale, then rotate counter-clockwise as seen (v points down), then
// translate.
std::array<double, 6> texture_from_uv(const TextureTransform& transform);

// Holds values at rest, and the channels that change them.
template <typename Values>
struct Animated {
  struct Change {
    Channel channel;
    std::function<void(Values&, const glm::dvec4&)> set;
  };
  Values rest;
  std::vector<Change> changes;

  Values at(double time_s) const {
    Values values = rest;
    for (const Change& change : changes) change.set(values, sample(change.channel, time_s));
    return values;
  }
};

struct MaterialValues {
  sideray_material_desc desc;  // its emission and texture_from_uv are computed from the following values
  glm::vec3 emissive_factor{0.0f};
  float emissive_strength = 1;
  std::array<TextureTransform, material_slots.size()> transforms;  // of slots that changes_transform marks
  std::array<bool, material_slots.size()> changes_transform{};
};

struct AnimatedMaterial : Animated<MaterialValues> {
  // The material in Content::materials and its copies with scaled thickness.
  struct Shown {
    uint32_t material = 0;
    float thickness_scale = 1;
  };
  std::vector<Shown> shown;
};

struct LightValues {
  glm::dvec3 color{1.0};
  double intensity = 1, range = 0, inner_cone = 0, outer_cone = 0;
};
// Returns the inner cone of a spot; if the cones are equal, it has a hard edge.
float inner_cone_of(double inner, float outer);

struct AnimatedLight : Animated<LightValues> {
  uint32_t light = 0;  // index in Content::lights
  uint32_t node = 0;   // index in the rig: a hidden node switches the light off
};

struct AnimatedCamera : Animated<sideray_camera> {
  uint32_t camera = 0;  // index in Content::cameras; the rig has its transform
};

// Set the values of a time in the content.
void set_values(const AnimatedMaterial& animated, double time_s, Content& content);
void set_values(const AnimatedLight& animated, double time_s, bool is_hidden, Content& content);
void set_values(const AnimatedCamera& animated, double time_s, Content& content);

}  // namespace sideray::scenes
