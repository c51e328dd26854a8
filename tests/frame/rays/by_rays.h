// Shared code for tests of frames drawn by rays alone.
#pragma once

#include "frame/frame.h"
#include "lab/metrics/metrics.h"

namespace sideray::tests {

inline scenes::Image picture_of(const Frame& f) {
  scenes::Image image{f.width, f.height, {}, true};
  for (const char* name : {"R", "G", "B"})
    image.planes.push_back({name, scenes::Plane::Type::single, f.planes.at(name), {}});
  return image;
}

inline double flip_of(const Frame& test, const Frame& reference) {
  return lab::compare(picture_of(test), picture_of(reference)).metrics.flip.value();
}

inline Setup by_rays(Setup setup) {
  setup.gl = "none";
  return setup;
}

inline void expect_same_bits(const Frame& a, const Frame& b, const std::string& what) {
  for (const auto& [name, plane] : a.planes) EXPECT_EQ(plane, b.planes.at(name)) << what << ", " << name;
  for (const auto& [name, plane] : a.uint_planes) EXPECT_EQ(plane, b.uint_planes.at(name)) << what << ", " << name;
}

// Draws two scenes by one thread and by two.
inline void expect_same_bits_for_any_threads(Setup setup) {
  setup.width = 160, setup.height = 90;
  for (const char* scene : {"solids", "smoke"}) {
    const scenes::Content content = scenes::generate(scene, {});
    setup.threads = 1;
    const Frame one = render(content, setup);
    setup.threads = 2;
    expect_same_bits(one, render(content, setup), scene);
  }
}

inline Renderer renderer_by_rays() {
  sideray_renderer_desc desc = sideray_renderer_defaults();
  desc.gl = "none";
  return Renderer::create(desc).value();
}

}  // namespace sideray::tests
