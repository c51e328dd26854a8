// Tests reflections of opaque surfaces: a floor whose mirror images have closed forms.
#include "rt/reflections/reflection_tracing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "rt/base/view_rays.h"
#include "rt/reflections/older_reflections.h"
#include "rt/textures/environment_lookup.h"
#include "rt/tracer_scene.h"

namespace sideray::rt::opaque_reflections_test {
namespace {

using namespace test;

constexpr uint32_t width = 64, height = 48;
constexpr float smooth = 0.04f, most = 0.3f;
constexpr float sky = 0.25f;

// A view of the floor y = 0, whose depth a rasterizer has stored; upper pixels show nothing.
struct FloorFrame {
  TraceView view = perspective({0, 1, 0}, {0, 0.4, -3}, 0.8, double{width} / height);
  ViewRays rays{view, width, height};
  DepthBuffer depth{width, height, 0.0f, 0};
  std::vector<glm::vec4> normals = std::vector<glm::vec4>(size_t{width} * height, glm::vec4(0));
  std::vector<glm::dvec3> floor = std::vector<glm::dvec3>(normals.size(), glm::dvec3(NAN));

  explicit FloorFrame(float roughness) {
    for (uint32_t y = 0; y < height; ++y)
      for (uint32_t x = 0; x < width; ++x) {
        const Ray ray = rays.ray(x, y);
        if (ray.direction.y >= -0.02f) continue;
        const glm::dvec3 o(ray.origin), d(ray.direction), p = o - d * (o.y / d.y);
        const glm::dvec4 clip = view.clip_from_local * glm::dvec4(p, 1.0);
        depth.set(x, y, static_cast<float>(clip.z / clip.w), 0);
        floor[y * width + x] = p;
        normals[y * width + x] = {0, 1, 0, roughness};
      }
  }
  ReflectionRequest request() const {
    ReflectionRequest r;
    r.view = view;
    r.width = width, r.height = height;
    r.depth = depth.image();
    r.normals = NormalTexels(normals);
    r.max_roughness = most;
    return r;
  }
  bool shows_floor(size_t texel) const { return normals[texel].y > 0; }
  // Where the mirrored ray passes the plane z; not finite where it does not.
  glm::dvec2 met(size_t texel, double z) const {
    const glm::dvec3 p = floor[texel], d = p - glm::dvec3(0, 1, 0), m(d.x, -d.y, d.z);
    const double t = (z - p.z) / m.z;
    return t > 0 ? glm::dvec2(p + m * t) : glm::dvec2(INFINITY);
  }
};

ReflectionImage traced(const std::shared_ptr<const model::Snapshot>& snapshot, const ReflectionRequest& request,
                       uint32_t threads = 2) {
  Tracer tracer({threads, ""});
  tracer.set_scene(snapshot);
  ReflectionImage image;
  tracer.trace_reflections(request, image);
  return image;
}

float alpha(const ReflectionImage& image, size_t texel) {
  return glm::unpackHalf1x16(image.radiance[4 * texel + 3]);
}

sideray_material_desc black(float opacity) {
  sideray_material_desc m = blended(glm::vec3(0.0f), opacity);
  m.specular = 0.0f;
  return m;
}

// How far inside a square about (0, 1) of half width `size` the point is; negative outside.
double inside(glm::dvec2 at, double size) {
  return size - std::max(std::abs(at.x), std::abs(at.y - 1.0));
}

std::shared_ptr<const model::Snapshot> room(bool pane) {
  TestScene scene;
  scene.quad({0, 0, 0}, {50, 0, 0}, {0, 0, 50}, plain_material());
  scene.quad({0, 1, -6}, {1, 0, 0}, {0, 1, 0}, glowing({4, 2, 1}));
  if (pane) scene.quad({0, 1, -5}, {1, 0, 0}, {0, 1, 0}, black(0.5f));
  scene.environment(glm::vec3(sky));
  return scene.commit();
}

// The glowing square, or the sky around it, by half through the pane before it.
TEST(OpaqueReflections, AMirrorShowsWhatStandsThere) {
  const FloorFrame frame(smooth);
  for (const bool pane : {false, true}) {
    const ReflectionImage image = traced(room(pane), frame.request());
    size_t of_square = 0, of_sky = 0;
    for (size_t t = 0; t < frame.normals.size(); ++t) {
      if (!frame.shows_floor(t)) {
        EXPECT_EQ(alpha(image, t), 0.0f);
        continue;
      }
      EXPECT_EQ(alpha(image, t), 1.0f);
      const double square = inside(frame.met(t, -6.0), 1.0), glass = pane ? inside(frame.met(t, -5.0), 1.0) : -1.0;
      if (std::abs(square) < 1e-3 || std::abs(glass) < 1e-3) continue;
      const glm::vec3 behind = square > 0 ? glm::vec3(4, 2, 1) : glm::vec3(sky);
      const glm::vec3 expected = glass > 0 ? 0.5f * behind : behind;
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(rgb(image.radiance, t)[c], expected[c], 2e-3f) << t;
      ++(square > 0 ? of_square : of_sky);
    }
    EXPECT_GT(of_square, 50u);
    EXPECT_GT(of_sky, 300u);
  }
}

// Seen through gaps of a pixel, as between blades of grass: the depth alone does not say how the floor lies.
TEST(OpaqueReflections, SinglePixelsMirrorToo) {
  FloorFrame frame(smooth);
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) {
      if (x % 4 == 0 && y % 4 == 0) continue;
      frame.depth.set(x, y, 0.5f, 0);
      frame.normals[y * width + x] = glm::vec4(0);
    }
  const ReflectionImage image = traced(room(false), frame.request());
  size_t of_square = 0, of_sky = 0;
  for (size_t t = 0; t < frame.normals.size(); ++t) {
    if (!frame.shows_floor(t)) continue;
    // Rays skip half a pixel there.
    const double square = inside(frame.met(t, -6.0), 1.0);
    if (std::abs(square) < 0.1) continue;
    ASSERT_NEAR(rgb(image.radiance, t).x, square > 0 ? 4.0f : sky, 2e-3f) << t;
    ++(square > 0 ? of_square : of_sky);
  }
  EXPECT_GT(of_square, 5u);
  EXPECT_GT(of_sky, 20u);
}

// A white wall under a sun, in the shadow of what mirrors do not show; shadows may be off.
TEST(OpaqueReflections, WhatIsMirroredLiesInShadows) {
  TestScene scene;
  sideray_material_desc wall = plain_material();
  wall.specular = 0.0f;
  scene.quad({0, 1, -6}, {2, 0, 0}, {0, 2, 0}, wall);
  scene.quad({1, 1, -5.5f}, {1, 0, 0}, {0, 2, 0}, wall, SIDERAY_VISIBLE_SHADOW);
  scene.lights({directional_light({0, 0, -1}, 3.0f)});
  const auto snapshot = scene.commit();
  const FloorFrame frame(smooth);
  for (const bool shadows : {true, false}) {
    ReflectionRequest request = frame.request();
    request.shadows = shadows;
    const ReflectionImage image = traced(snapshot, request);
    size_t lit = 0, dark = 0;
    for (size_t t = 0; t < frame.normals.size(); ++t) {
      const glm::dvec2 at = frame.shows_floor(t) ? frame.met(t, -6.0) : glm::dvec2(INFINITY);
      if (inside(at, 2.0) < 1e-3 || std::abs(at.x) < 1e-3) continue;
      const bool blocked = shadows && at.x > 0;
      ASSERT_NEAR(rgb(image.radiance, t).x, blocked ? 0.0 : 3.0 / 3.14159265, 2e-3) << t;
      ++(blocked ? dark : lit);
    }
    EXPECT_GT(lit, 50u);
    EXPECT_EQ(dark > 50, shadows);
  }
}

TEST(OpaqueReflections, FadeTowardTheLargestRoughness) {
  EXPECT_EQ(reflection_share(0.0f, 0.3f), 1.0f);
  EXPECT_EQ(reflection_share(0.2f, 0.3f), 1.0f);
  EXPECT_NEAR(reflection_share(0.25f, 0.3f), 0.5f, 1e-6f);
  EXPECT_EQ(reflection_share(0.3f, 0.3f), 0.0f);
  EXPECT_EQ(reflection_share(0.31f, 0.3f), 0.0f);
  EXPECT_EQ(reflection_share(0.04f, 0.04f), 1.0f) << "mirrors alone";
  EXPECT_EQ(reflection_share(0.05f, 0.04f), 0.0f);
  const auto snapshot = room(false);
  for (const float roughness : {0.1f, 0.25f, 0.4f}) {
    const FloorFrame frame(roughness);
    const ReflectionImage image = traced(snapshot, frame.request());
    for (size_t t = 0; t < frame.normals.size(); ++t)
      EXPECT_NEAR(alpha(image, t), frame.shows_floor(t) ? reflection_share(roughness, most) : 0.0f, 1e-3f);
  }
}

// One direction a pixel is noise about the mean; the filter keeps the mean and takes most of the noise.
TEST(OpaqueReflections, RoughOnesAreFiltered) {
  const auto snapshot = room(false);
  const FloorFrame frame(0.19f);
  ReflectionRequest request = frame.request();
  const ReflectionImage noisy = traced(snapshot, request);
  request.denoise = true;
  const ReflectionImage filtered = traced(snapshot, request);
  const auto sums = [&](const ReflectionImage& image) {
    glm::dvec2 sum(0);  // light, and differences of neighbours
    for (size_t t = 0; t + 1 < frame.normals.size(); ++t) {
      if (!frame.shows_floor(t) || !frame.shows_floor(t + 1)) continue;
      const double here = double{rgb(image.radiance, t).x}, next = double{rgb(image.radiance, t + 1).x};
      sum += glm::dvec2(here, std::abs(here - next));
    }
    return sum;
  };
  const glm::dvec2 before = sums(noisy), after = sums(filtered);
  EXPECT_NEAR(after.x / before.x, 1.0, 0.05);
  EXPECT_LT(after.y, 0.5 * before.y);
}

TEST(OpaqueReflections, TheSkyAloneStaysAsItIsPrefiltered) {
  TestScene scene;
  scene.quad({0, 0, 0}, {50, 0, 0}, {0, 0, 50}, plain_material());
  scene.environment(glm::vec3(sky));
  const FloorFrame frame(0.15f);
  ReflectionRequest request = frame.request();
  request.denoise = true;
  const ReflectionImage image = traced(scene.commit(), request);
  for (size_t t = 0; t < frame.normals.size(); ++t)
    if (frame.shows_floor(t)) {
      EXPECT_NEAR(rgb(image.radiance, t).x, sky, 1e-3f);
    }
}

// Surroundings of 64x32 texels that shine where `shines` says of a direction.
template <typename Shines>
void partly_bright(TestScene& scene, const Shines& shines) {
  constexpr int columns = 64, rows = 32;
  std::vector<glm::vec3> texels;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      const float polar = (static_cast<float>(row) + 0.5f) / rows * 3.14159265f;
      const float around = ((static_cast<float>(column) + 0.5f) / columns - 0.5f) * 6.2831853f;
      const glm::vec3 d{std::sin(polar) * std::sin(around), std::cos(polar), -std::sin(polar) * std::cos(around)};
      texels.push_back(shines(d) ? glm::vec3(4, 2, 1) : glm::vec3(0));
    }
  scene.scene.set_environment(columns, rows, &texels[0].x, 1.0f, 0.0f);
}

// Bump normals give mirror directions below the floor, where the rasterizer still looks up the environment: where rays
// hit nothing both must agree.
TEST(OpaqueReflections, RoughBumpsSeeTheSurroundingsOfTheRasterizer) {
  TestScene scene;
  scene.quad({0, 0, 0}, {50, 0, 0}, {0, 0, 50}, plain_material());
  partly_bright(scene, [](glm::vec3 d) { return d.y > 0.0f; });
  const auto snapshot = scene.commit();
  FloorFrame frame(0.19f);
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x)
      if (frame.shows_floor(size_t{y} * width + x)) {
        const float tilt = 0.3f * std::sin(2.4f * static_cast<float>(y));
        frame.normals[size_t{y} * width + x] = glm::vec4(glm::normalize(glm::vec3(0, 1, tilt)), 0.19f);
      }
  ReflectionRequest request = frame.request();
  for (const bool denoise : {false, true}) {
    request.denoise = denoise;
    const ReflectionImage image = traced(snapshot, request);
    size_t below = 0;
    for (size_t t = 0; t < frame.normals.size(); ++t) {
      if (!frame.shows_floor(t)) continue;
      const glm::vec3 n(frame.normals[t]), to_eye = glm::normalize(glm::vec3(glm::dvec3(0, 1, 0) - frame.floor[t]));
      if (glm::dot(to_eye, n) < 0.01f) continue;  // seen from behind
      const glm::vec3 mirrored = 2.0f * glm::dot(to_eye, n) * n - to_eye;
      const glm::vec3 expected =
          environment_specular(*snapshot->environment, shading::sr_dominant(n, mirrored, 0.19f), 0.19f);
      ASSERT_NEAR(rgb(image.radiance, t).x, expected.x, 2e-3f) << t;
      below += mirrored.y < -0.05f ? 1 : 0;
    }
    EXPECT_GT(below, 100u);
  }
}

// A black wall hides everything bright, and beyond its edges all is dark: the directions that pass the wall must not
// show the average of the whole lobe without it.
TEST(OpaqueReflections, RoughOnesDoNotSeeWhatIsHidden) {
  const auto light = [](bool wall) {
    TestScene scene;
    scene.quad({0, 0, 0}, {50, 0, 0}, {0, 0, 50}, plain_material());
    if (wall) scene.quad({0, 1, -6}, {1.5f, 0, 0}, {0, 1.5f, 0}, black(1.0f));
    // The middle of the wall, as seen from the floor before it.
    partly_bright(scene, [](glm::vec3 d) {
      return d.z < 0.0f && std::abs(d.x / d.z) < 0.12f && std::abs(d.y / d.z - 0.25f) < 0.12f;
    });
    const FloorFrame frame(0.19f);
    ReflectionRequest request = frame.request();
    request.denoise = true;
    const ReflectionImage image = traced(scene.commit(), request);
    double sum = 0;
    for (size_t t = 0; t < frame.normals.size(); ++t) {
      if (!frame.shows_floor(t)) continue;
      const glm::dvec3 p = frame.floor[t];
      if (std::abs(p.x) < 0.5 && p.z > -4.0 && p.z < -1.5) sum += double{rgb(image.radiance, t).x};
    }
    return sum;
  };
  const double hidden = light(true), open = light(false);
  EXPECT_GT(open, 1.0);
  EXPECT_LT(hidden, 0.1 * open);
}

// A floor without light hides the bright lower half of the surroundings from a ball, whose normals turn from pixel to
// pixel. The tail of a lobe that looks up must not show it.
TEST(OpaqueReflections, RoughOnesOnCurvesDoNotSeeWhatIsHidden) {
  TestScene scene;
  const glm::dvec3 centre(0, 0.4, -3);
  constexpr double radius = 1.1;
  scene.quad({0, -1, 0}, {500, 0, 0}, {0, 0, 500}, glowing(glm::vec3(0.0f)));
  partly_bright(scene, [](glm::vec3 d) { return d.y < -0.3f; });
  constexpr float roughness = 0.3f;
  FloorFrame frame(roughness);
  std::vector<bool> looks_low(frame.normals.size());  // up, but not far from the horizon
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) {
      const Ray ray = frame.rays.ray(x, y);
      const glm::dvec3 from = glm::dvec3(ray.origin) - centre, d(ray.direction);
      const double b = glm::dot(from, d), inside = b * b - glm::dot(from, from) + radius * radius;
      const glm::dvec3 normal = (from + d * (-b - std::sqrt(std::max(inside, 0.0)))) / radius;
      const glm::dvec4 clip = frame.view.clip_from_local * glm::dvec4(centre + normal * radius, 1.0);
      frame.depth.set(x, y, inside > 0 ? static_cast<float>(clip.z / clip.w) : 0.0f, 0);
      frame.normals[size_t{y} * width + x] = inside > 0 ? glm::vec4(normal, roughness) : glm::vec4(0);
      const double rise = d.y - 2 * glm::dot(d, normal) * normal.y;
      looks_low[size_t{y} * width + x] = inside > 0.1 && rise > 0 && rise < 0.2;
    }
  ReflectionRequest request = frame.request();
  request.max_roughness = 0.5f;
  request.denoise = true;
  const ReflectionImage image = traced(scene.commit(), request);
  double sum = 0;
  size_t count = 0;
  for (size_t t = 0; t < frame.normals.size(); ++t)
    if (looks_low[t]) sum += double{rgb(image.radiance, t).x}, ++count;
  EXPECT_GT(count, 50u);
  EXPECT_LT(sum, 0.05 * 4.0 * static_cast<double>(count));
}

// A budget may take more frames for all tiles than a reflection lasts in motion. A view at rest must be complete then.
TEST(OpaqueReflections, ExpireUnderABudgetWhileTheEyeMovesAlone) {
  const auto snapshot = room(false);
  for (const bool moves : {false, true}) {
    Tracer tracer({2, ""});
    tracer.set_scene(snapshot);
    FloorFrame frame(smooth);
    OlderReflections older;
    ReflectionImage image;
    Counters counters;
    for (int number = 0; number <= OlderReflections::oldest + 1; ++number) {
      PiecesLeft pieces = number == 0 ? 100 : 0;
      ReflectionRequest request = frame.request();
      request.sequence = number == 0 ? SequenceStep::first : SequenceStep::next;
      request.older = &older;
      request.work.pieces = &pieces;
      if (moves) request.view = perspective({1e-5 * number, 1, 0}, {0, 0.4, -3}, 0.8, double{width} / height);
      counters = tracer.trace_reflections(request, image);
      if (number == OlderReflections::oldest) {
        EXPECT_GT(counters.reflection_pixels_older, 400u) << moves;
      }
    }
    EXPECT_EQ(counters.reflection_pixels_older == 0, moves);
    EXPECT_EQ(counters.reflection_pixels_late == 0, !moves);
    const std::vector<uint8_t> answers = older.answers();
    EXPECT_EQ(std::ranges::count(answers, 0), 0) << "nothing was traced";
  }
}

TEST(OpaqueReflections, TheSameBitsForAnyNumberOfThreads) {
  const auto snapshot = room(true);
  const FloorFrame frame(0.15f);
  ReflectionRequest request = frame.request();
  request.denoise = true;
  EXPECT_EQ(traced(snapshot, request, 1).radiance, traced(snapshot, request, 3).radiance);
}

}  // namespace
}  // namespace sideray::rt::opaque_reflections_test
