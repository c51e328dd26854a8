// Tests the origins of shadow rays against exact geometry: from 0.1 to 10,000 m, for each depth format, surfaces do not
// shadow themselves, and no occluder farther off than seven steps of the depth is lost.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <optional>

#include "rt/base/view_rays.h"
#include "rt/tracer.h"
#include "rt/tracer_scene.h"

namespace sideray::rt::occlusion_bias_test {
namespace {

using namespace test;

constexpr std::array<double, 6> distances{0.1, 1.0, 10.0, 100.0, 1000.0, 10000.0};

enum class Stored { d24, d32f, reversed };
constexpr std::array<Stored, 3> formats{Stored::d24, Stored::d32f, Stored::reversed};

const char* name(Stored s) {
  return s == Stored::d24 ? "D24" : s == Stored::d32f ? "D32F" : "reversed D32F";
}

struct Triangles {
  std::vector<glm::vec3> corners;
  std::vector<uint32_t> indices;

  size_t count() const { return indices.size() / 3; }
  glm::dvec3 corner(size_t triangle, size_t k) const { return glm::dvec3(corners[indices[3 * triangle + k]]); }
  glm::dvec3 normal(size_t i) const { return glm::cross(corner(i, 1) - corner(i, 0), corner(i, 2) - corner(i, 0)); }
  void quad(glm::vec3 center, glm::vec3 u, glm::vec3 v) {
    const auto first = static_cast<uint32_t>(corners.size());
    corners.insert(corners.end(), {center - u - v, center + u - v, center + u + v, center - u + v});
    for (const uint32_t k : {0u, 1u, 2u, 0u, 2u, 3u}) indices.push_back(first + k);
  }
  void box(glm::vec3 center, glm::vec3 half) {
    const glm::vec3 x(half.x, 0, 0), y(0, half.y, 0), z(0, 0, half.z);
    for (const float s : {-1.0f, 1.0f})
      quad(center + s * x, y, z), quad(center + s * y, z, x), quad(center + s * z, x, y);
  }
};

// Returns whether a ray hits any triangle beyond `least`, in double.
bool meets(const Triangles& all, glm::dvec3 origin, glm::dvec3 d, double least) {
  for (size_t i = 0; i < all.count(); ++i) {
    const glm::dvec3 p0 = all.corner(i, 0), e1 = all.corner(i, 1) - p0, e2 = all.corner(i, 2) - p0, s = origin - p0;
    const glm::dvec3 a = glm::cross(d, e2), b = glm::cross(s, e1);
    const double scale = 1.0 / glm::dot(e1, a), u = glm::dot(s, a) * scale, v = glm::dot(d, b) * scale;
    if (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && glm::dot(e2, b) * scale > least) return true;
  }
  return false;
}

// Draws triangles as a rasterizer does: the nearest depth in each pixel's middle, rounded to the format, after moving
// corners by up to half of 1/256 of a pixel.
class Drawn {
 public:
  static constexpr uint32_t width = 96, height = 72;
  static constexpr double subpixel = 0x1p-9;

  Drawn(const Triangles& triangles, Stored stored, glm::dvec3 eye, glm::dvec3 target, double near, uint32_t corner)
      : triangles_(triangles),
        reversed_(stored == Stored::reversed),
        moved_(corner & 1 ? subpixel : -subpixel, corner & 2 ? subpixel : -subpixel) {
    request.view = perspective(eye, target, 0.8, double{width} / height, near);
    if (!reversed_) {
      request.view.clip_from_local = glm::perspectiveRH_NO(0.8, double{width} / height, near, 1e6 * near) *
                                     glm::lookAt(eye, target, glm::dvec3(0, 1, 0));
      request.view.local_from_clip = glm::inverse(request.view.clip_from_local);
      request.view.reversed_depth = request.view.zero_to_one_depth = false;
    }
    request.width = width, request.height = height;
    request.shadow_lights = 1;
    request.depth = {texels_.data(), width * 4, stored == Stored::d24 ? DepthFormat::d24s8 : DepthFormat::d32f};
    rays_.emplace(request.view, width, height);
  }

  // Returns the view whose pixel centres see the drawn points.
  TraceView moved_view() const {
    TraceView view = request.view;
    for (int c = 0; c < 4; ++c) {
      glm::dvec4& column = view.clip_from_local[c];
      column.x -= 2.0 * moved_.x / width * column.w, column.y -= 2.0 * moved_.y / height * column.w;
    }
    view.local_from_clip = glm::inverse(view.clip_from_local);
    return view;
  }

  // Draws; `seen` is the triangle in each pixel, or none.
  void draw(const std::vector<size_t>& seen) {
    for (uint32_t y = 0; y < height; ++y)
      for (uint32_t x = 0; x < width; ++x) {
        const size_t i = size_t{y} * width + x;
        const bool drawn = seen[i] < triangles_.count();
        store(i, drawn ? window(on_plane(x + moved_.x, y + moved_.y, seen[i])) : (reversed_ ? 0.0 : 1.0));
      }
  }

  // Returns the uncertainty of a pixel's depth along its ray: a step of the format, rounding of floats, and the effect
  // of the corners' grid on a slope.
  double step(uint32_t x, uint32_t y, size_t triangle) const {
    const double depth = read_depth(request.depth, x, y).depth, d = rays_->distance(x, y, depth);
    const auto f = static_cast<float>(depth);
    double code =
        request.depth.format == DepthFormat::d24s8 ? 1.0 / 16777215.0 : double{std::nextafter(f, 2.0f)} - double{f};
    if (!reversed_) code = std::max(code, 0x1p-24);
    const double flat = rays_->distance(x, y, window(on_plane(x, y, triangle)));
    const double moved = rays_->distance(x, y, window(on_plane(x + moved_.x, y + moved_.y, triangle)));
    return std::abs(rays_->distance(x, y, depth + (reversed_ ? code : -code)) - d) + 0x1p-21 * d +
           std::abs(moved - flat);
  }

  Ray ray(uint32_t x, uint32_t y) const { return rays_->ray(x, y); }

  MaskRequest request;
  // Exact, on what a pixel's middle shows.
  glm::dvec3 on_plane(double x, double y, size_t triangle) const {
    const glm::dvec2 ndc((x + 0.5) / width * 2.0 - 1.0, (y + 0.5) / height * 2.0 - 1.0);
    const auto at = [&](double z) {
      const glm::dvec4 h = request.view.local_from_clip * glm::dvec4(ndc, z, 1.0);
      return glm::dvec3(h) / h.w;
    };
    const glm::dvec3 a = at(reversed_ ? 1.0 : -1.0), b = at(reversed_ ? 0.5 : 0.0), p0 = triangles_.corner(triangle, 0);
    const glm::dvec3 n = glm::cross(triangles_.corner(triangle, 1) - p0, triangles_.corner(triangle, 2) - p0);
    return a + (b - a) * (glm::dot(p0 - a, n) / glm::dot(b - a, n));
  }

 private:
  double window(glm::dvec3 p) const {
    const glm::dvec4 clip = request.view.clip_from_local * glm::dvec4(p, 1.0);
    // From -1..1 it passes through a float on the way.
    return reversed_ ? clip.z / clip.w : 0.5 * static_cast<double>(static_cast<float>(clip.z / clip.w)) + 0.5;
  }
  void store(size_t i, double depth) {
    const auto f = static_cast<float>(depth);
    const auto packed = static_cast<uint32_t>(std::lround(depth * 16777215.0)) << 8;
    if (request.depth.format == DepthFormat::d24s8)
      std::memcpy(&texels_[4 * i], &packed, 4);
    else
      std::memcpy(&texels_[4 * i], &f, 4);
  }

  const Triangles& triangles_;
  bool reversed_;
  glm::dvec2 moved_;
  std::vector<std::byte> texels_ = std::vector<std::byte>(size_t{4} * width * height);
  std::optional<ViewRays> rays_;
};

class ShadowBias : public testing::Test {
 protected:
  void set(const Triangles& triangles, glm::vec3 light) {
    TestScene scene;
    scene.add(triangles.corners, std::vector<glm::vec2>(triangles.corners.size()), triangles.indices, plain_material(),
              glm::dmat4(1.0));
    scene.lights({directional_light(light, 1.0f)});
    tracer.set_scene(scene.commit());
  }
  // Draws what the rays see, and traces the mask.
  void trace(Drawn& drawn) {
    const PrimaryImage image = tracer.trace_primary(drawn.moved_view(), Drawn::width, Drawn::height);
    std::vector<size_t> seen;
    for (const glm::uvec2 id : image.ids) seen.push_back(id.y == 0 ? SIZE_MAX : id.y - 1);
    drawn.draw(seen);
    tracer.trace_masks(drawn.request, masks);
    seen_ = seen;
    const PrimaryImage middle = tracer.trace_primary(drawn.request.view, Drawn::width, Drawn::height);
    at_edge_.clear();
    for (size_t i = 0; i < middle.ids.size(); ++i) at_edge_.push_back(middle.ids[i] != image.ids[i]);
  }
  // The pixel's middle shows another triangle than is drawn there.
  bool at_edge(uint32_t x, uint32_t y) const { return at_edge_[size_t{y} * Drawn::width + x]; }
  // All four neighbours show the same plane: its slope is known.
  bool is_inside(uint32_t x, uint32_t y) const {
    if (x == 0 || y == 0 || x + 1 == Drawn::width || y + 1 == Drawn::height) return false;
    const size_t quad = triangle(x, y) / 2;
    return triangle(x - 1, y) / 2 == quad && triangle(x + 1, y) / 2 == quad && triangle(x, y - 1) / 2 == quad &&
           triangle(x, y + 1) / 2 == quad;
  }
  // Three pixels in a row and in a column show the pixel's quad: its tilt is known.
  bool is_three_wide(uint32_t x, uint32_t y) const {
    const size_t quad = triangle(x, y) / 2;
    const auto same = [&](int i, int j) {
      const int column = static_cast<int>(x) + i, row = static_cast<int>(y) + j;
      return column >= 0 && row >= 0 && column < static_cast<int>(Drawn::width) && row < static_cast<int>(Drawn::height) &&
             triangle(static_cast<uint32_t>(column), static_cast<uint32_t>(row)) / 2 == quad;
    };
    return ((same(-1, 0) && same(-2, 0)) || (same(1, 0) && same(2, 0))) &&
           ((same(0, -1) && same(0, -2)) || (same(0, 1) && same(0, 2)));
  }
  bool shows(uint32_t x, uint32_t y) const { return seen_[size_t{y} * Drawn::width + x] != SIZE_MAX; }
  bool dark(uint32_t x, uint32_t y) const { return masks.lit[size_t{y} * Drawn::width + x] == 0; }
  size_t triangle(uint32_t x, uint32_t y) const { return seen_[size_t{y} * Drawn::width + x]; }

  template <typename Visit>
  void for_each_pixel(const Visit& visit) const {
    for (uint32_t y = 0; y < Drawn::height; ++y)
      for (uint32_t x = 0; x < Drawn::width; ++x)
        if (shows(x, y)) visit(x, y);
  }

  Tracer tracer{{2, ""}};
  OcclusionMasks masks;

 private:
  std::vector<size_t> seen_;
  std::vector<bool> at_edge_;
};

// Hills of slopes below `slope`.
Triangles terrain(double h, uint32_t cells, double slope) {
  Triangles t;
  const double size = 8.0 * h;
  const auto height = [&](double x, double z) {
    const double f = 1.7 / h;  // two waves, each of half the slope in each direction
    return slope / 4.0 / f * (std::sin(f * x + 0.4 * f * z) + std::sin(0.6 * f * x - f * z + 1.0));
  };
  for (uint32_t j = 0; j <= cells; ++j)
    for (uint32_t i = 0; i <= cells; ++i) {
      const double x = (i * 1.0 / cells - 0.5) * size, z = (j * 1.0 / cells - 0.8) * size;
      t.corners.emplace_back(x, height(x, z), z);
    }
  for (uint32_t j = 0; j < cells; ++j)
    for (uint32_t i = 0; i < cells; ++i) {
      const uint32_t a = j * (cells + 1) + i, b = a + cells + 1;
      for (const uint32_t k : {a, b, a + 1, a + 1, b, b + 1}) t.indices.push_back(k);
    }
  return t;
}

// Nearest and farthest ways to place the near plane: where it always is, and where the scene lets it be.
std::array<double, 2> near_planes(double h) {
  return {std::min(0.1, 0.2 * h), 0.01 * h};
}

// Every light of these is above the plane or above every slope of the hills: all is lit.
TEST_F(ShadowBias, planes_and_hills_without_shadows_have_none) {
  size_t pixels = 0, wrong = 0;
  uint32_t corner = 0;
  for (const double h : distances)
    for (const bool flat : {true, false}) {
      const double slope = flat ? 0.0 : 0.35;
      const Triangles ground = terrain(h, flat ? 1 : 40, slope);
      for (const glm::vec3& light : {glm::vec3(0.8f, -0.4f, 0.3f), glm::vec3(0.3f, -0.4f, 0.8f)}) {
        set(ground, light);
        for (const Stored format : formats)
          for (const double near : near_planes(h))
            for (const glm::dvec3& target : {glm::dvec3(0, 0, -0.4 * h), glm::dvec3(0.2 * h, 0.2 * h, -4.0 * h)}) {
              Drawn drawn(ground, format, {0.1 * h, h, 0.3 * h}, target, near, ++corner);
              trace(drawn);
              size_t here = 0;
              for_each_pixel([&](uint32_t x, uint32_t y) { ++pixels, here += dark(x, y); });
              EXPECT_EQ(here, 0u) << (flat ? "plane " : "hills ") << h << " m, " << name(format) << ", near " << near
                                  << ", toward " << target.z;
              wrong += here;
            }
      }
    }
  EXPECT_GT(pixels, 1000000u);  // none of them: at most 1e-6
  EXPECT_EQ(wrong, 0u);
}

// A box and a wall without thickness that stand on a floor, and a plate just above it. The light comes from behind
// them, from aside or from above.
Triangles obstacles(double h, double gap) {
  const auto s = static_cast<float>(h);
  Triangles t;
  t.quad({0, 0, -s}, {4 * s, 0, 0}, {0, 0, 4 * s});
  t.box({-0.3f * s, 0.1f * s, -0.2f * s}, {0.1f * s, 0.1f * s, 0.1f * s});
  t.quad({0.2f * s, 0.1f * s, -0.2f * s}, {0.15f * s, 0, 0.03f * s}, {0, 0.1f * s, 0});
  t.quad({0.0f, static_cast<float>(gap), 0.3f * s}, {0.1f * s, 0, 0}, {0, 0, 0.1f * s});
  return t;
}

// A pixel's mask must equal exact rays from some point of its view ray within seven steps of the depth in front of the
// surface, or one and a half for reversed depth, without allowance for rounding of floats. So no light leaks farther
// under a plate or behind a wall, and no shadow is displaced by more.
TEST_F(ShadowBias, contact_shadows_leak_seven_steps_at_most) {
  size_t pixels = 0, shadowed = 0, wrong = 0;
  uint32_t corner = 0;
  for (const double h : distances)
    for (const glm::vec3& light :
         {glm::vec3(0.2f, -0.5f, 0.8f), glm::vec3(-0.7f, -0.6f, 0.1f), glm::vec3(0.1f, -1, 0.05f)}) {
      const Triangles scene = obstacles(h, 0.001 * h);
      set(scene, light);
      const glm::dvec3 to_light = -glm::normalize(glm::dvec3(light));
      for (const Stored format : formats)
        for (const double near : near_planes(h)) {
          const double most = format == Stored::reversed ? 1.5 : 7.0;
          Drawn drawn(scene, format, {0.05 * h, 0.35 * h, 0.9 * h}, {0, 0.05 * h, -0.1 * h}, near, ++corner);
          trace(drawn);
          for_each_pixel([&](uint32_t x, uint32_t y) {
            const size_t shown = triangle(x, y);
            const glm::dvec3 p = drawn.on_plane(x, y, shown), toward(drawn.ray(x, y).direction);
            const glm::dvec3 n = scene.normal(shown);
            const bool faces = (glm::dot(n, to_light) > 0.0) != (glm::dot(n, toward) > 0.0);
            if (at_edge(x, y) || (dark(x, y) && !(faces && is_inside(x, y)))) return;
            const double step = drawn.step(x, y, shown);
            bool explained = false, any_dark = false;
            for (double steps = -most; steps <= most; steps += 0.5) {
              const bool is_dark = meets(scene, p - toward * (steps * step), to_light, 1e-9 * h);
              explained |= is_dark == dark(x, y), any_dark |= is_dark;
            }
            ++pixels, shadowed += any_dark;
            if (!explained) ++wrong;
          });
          EXPECT_EQ(wrong, 0u) << h << " m, " << name(format) << ", near " << near << ", light " << light.x;
        }
    }
  EXPECT_GT(shadowed * 20, pixels);
  EXPECT_GT(pixels, 100000u);
}

// Two pages without thickness that meet at a spine, `angle` apart, with the spine toward the eye or away from it.
Triangles book(double h, double angle, double turned, bool toward_eye) {
  Triangles t;
  const double half_size = 0.2 * h;
  const glm::dvec3 spine(-std::sin(turned), std::cos(turned), 0.0), across(spine.y, -spine.x, 0.0);
  const glm::dvec3 out(0.0, 0.0, toward_eye ? 1.0 : -1.0);
  for (const double side : {-1.0, 1.0}) {
    const glm::dvec3 page = side * std::sin(0.5 * angle) * across - std::cos(0.5 * angle) * out;
    t.quad(glm::vec3(half_size * page + glm::dvec3(0.0, 0.3 * h, 0.0)), glm::vec3(half_size * page),
           glm::vec3(half_size * spine));
  }
  return t;
}

// Beside a fold the nearer neighbour may be on the other face. Where a page shows three pixels in a row and in a
// column, the mask must equal exact rays, which pass the pixel's own page where it faces away from the light.
TEST_F(ShadowBias, folds_show_what_exact_rays_say) {
  size_t pixels = 0, shadowed = 0, wrong = 0, narrow = 0, narrow_wrong = 0;
  uint32_t corner = 0;
  for (const bool toward_eye : {true, false})
    for (const double h : {1.0, 30.0})
      for (const double angle : {1.0, 1.57, 2.5})
        for (const double turned : {0.05, 0.4, 1.5}) {
          const Triangles pages = book(h, angle, turned, toward_eye);
          for (const glm::dvec3& light :
               {glm::dvec3(0.3, 0.8, 0.5), glm::dvec3(-0.8, 0.2, 0.3), glm::dvec3(0.6, -0.1, 0.1), glm::dvec3(0.2, 0.3, -0.8)}) {
            const glm::dvec3 to_light = glm::normalize(light);
            set(pages, glm::vec3(-to_light));
            for (const Stored format : formats) {
              Drawn drawn(pages, format, {0.05 * h, 0.35 * h, 0.9 * h}, {0, 0.2 * h, -0.1 * h}, near_planes(h)[0], ++corner);
              trace(drawn);
              for_each_pixel([&](uint32_t x, uint32_t y) {
                const size_t shown = triangle(x, y);
                const glm::dvec3 p = drawn.on_plane(x, y, shown), toward(drawn.ray(x, y).direction);
                const glm::dvec3 n = glm::normalize(pages.normal(shown));
                const double facing = glm::dot(n, to_light) * (glm::dot(n, toward) > 0.0 ? -1.0 : 1.0);
                if (at_edge(x, y) || std::abs(facing) < 0.05) return;
                const double step = drawn.step(x, y, shown), most = format == Stored::reversed ? 1.5 : 7.0;
                const auto is_dark = [&](double steps) {
                  const double off = std::max(steps * step, 1e-7 * h);
                  return meets(pages, p - toward * (facing > 0.0 ? off : -off), to_light, 1e-9 * h);
                };
                const bool expected = is_dark(0.0);
                if (is_dark(most) != expected || is_dark(0.5 * most) != expected) return;
                const bool differs = dark(x, y) != expected;
                if (!is_three_wide(x, y)) {
                  ++narrow, narrow_wrong += differs;
                  return;
                }
                ++pixels, shadowed += expected, wrong += differs;
              });
            }
          }
        }
  std::printf("%zu of %zu wrong, %zu of %zu where a page is narrower\n", wrong, pixels, narrow_wrong, narrow);
  // These are so near to the spine that both pages are in the pixel, within the precision of depth.
  EXPECT_LE(wrong, 8u);
  EXPECT_GT(pixels, 900000u);
  EXPECT_GT(shadowed, 50000u);
}

}  // namespace
}  // namespace sideray::rt::occlusion_bias_test
