// Values that animations change besides the places of nodes (KHR_animation_pointer): of materials, lights and cameras.
// Made by the loader, read only afterwards. Any thread.
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
// As sideray_texture_slot has it: scale, then turn counter-clockwise as seen (v points down), then move.
std::array<double, 6> texture_from_uv(const TextureTransform& transform);

// What a thing has at rest, and the channels that change it.
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
  sideray_material_desc desc;  // with emission and texture_from_uv that the following values are made into
  glm::vec3 emissive_factor{0.0f};
  float emissive_strength = 1;
  std::array<TextureTransform, material_slots.size()> transforms;  // of the slots that changes_transform names
  std::array<bool, material_slots.size()> changes_transform{};
};

struct AnimatedMaterial : Animated<MaterialValues> {
  // Of Content::materials: itself, and copies whose thickness is scaled.
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
// A spot whose cones do not differ has a hard edge.
float inner_cone_of(double inner, float outer);

struct AnimatedLight : Animated<LightValues> {
  uint32_t light = 0;  // of Content::lights
  uint32_t node = 0;   // of the rig: where it is hidden, the light is out
};

struct AnimatedCamera : Animated<sideray_camera> {
  uint32_t camera = 0;  // of Content::cameras; its place is the rig's
};

// Puts the values at a time into the content.
void set_values(const AnimatedMaterial& animated, double time_s, Content& content);
void set_values(const AnimatedLight& animated, double time_s, bool is_hidden, Content& content);
void set_values(const AnimatedCamera& animated, double time_s, Content& content);

}  // namespace sideray::scenes
