// Turns pixels into rays and stored depth into distances along them, for one view. Immutable; any thread may call it.
// Computed in double: a ray goes through the pixel's centre, its origin is the eye (perspective) or lies on the near
// plane (orthographic), its direction is unit, and it ends at the near and far planes as rasterized geometry does.
#pragma once

#include <glm/glm.hpp>

#include "rt/base/ray.h"
#include "rt/base/view.h"

namespace sideray::rt {

class ViewRays {
 public:
  // Throws Failure if the matrices describe no view.
  ViewRays(const TraceView& view, uint32_t width, uint32_t height);

  // Returns the pixel's ray; it ends at the far plane.
  Ray ray(uint32_t x, uint32_t y) const;
  Cone cone(uint32_t x, uint32_t y) const;
  // Returns the footprint of all pixels for alpha, and the steps between them.
  const AlphaCone& alpha_cone() const { return alpha_cone_; }
  const PixelSteps& steps() const { return alpha_cone_.steps; }

  // Converts window depth 0..1 to the distance along the pixel's ray; infinite beyond an infinite far plane.
  double distance(uint32_t x, uint32_t y, double depth) const;
  // Returns that distance less the possible error of the stored depth: half a step of the format and 2^-21 of the
  // distance. For a cleared depth buffer it returns the far plane.
  float end_of_ray(uint32_t x, uint32_t y, double depth, DepthFormat format) const;

  // Holds the values that all distances along one pixel's ray share.
  struct Pixel {
    glm::dvec2 ndc;
    glm::vec3 origin, direction;  // those of ray()
    // In perspective: the direction's length before normalization, and what x and y add to w.
    double length = 0, w = 0;
  };
  Pixel pixel(uint32_t x, uint32_t y) const;
  double distance(const Pixel& pixel, double depth) const;
  // Returns the window depth of a distance along the pixel's ray: the inverse of distance().
  double window_depth(const Pixel& pixel, double distance) const;
  Ray ray(const Pixel& pixel) const;
  Cone cone(const Pixel& pixel) const;
  // `distance` belongs to `depth`, which may be off by `half_steps` of its format.
  float end_of_ray(const Pixel& pixel, double depth, double distance, DepthFormat format, double half_steps = 1.0) const;

  // Holds pixels in one array per component, and the depths that end their rays.
  struct Block {
    static constexpr uint32_t size = 16;
    alignas(64) double x[size], y[size], depth[size];
  };
  // Writes the pixels' rays, which end at end_of_ray(), and cones: the same bits as ray() and cone() return.
  void fill(const Block& block, DepthFormat format, Ray* rays, Cone* cones) const;
  // Returns the depth of rays that no opaque surface ends.
  double far_depth() const { return far_depth_; }

  // Return the unit directions of the picture's columns and rows.
  glm::vec3 right() const { return right_; }
  glm::vec3 up() const { return up_; }
  // Returns the depth along the view axis of the point at a distance along a pixel's ray, times a factor that is the
  // same for all pixels: only for comparisons.
  float depth(uint32_t x, uint32_t y, double distance) const;

  bool perspective() const { return perspective_; }
  glm::dvec3 eye() const { return eye_; }

  // Holds the constants of pixel() and distance() in perspective, for code that processes many pixels at a time.
  struct Perspective {
    glm::dvec2 pixel;
    glm::dvec3 center, along_x, along_y, eye;
    double sign;
    glm::dvec4 w;  // without the sign: factors of x, y and z, and a constant
    bool reversed, zero_to_one;
  };
  Perspective terms() const;

 private:
  // Holds rays in one array per component.
  struct Rows {
    alignas(64) double step[Block::size];  // of depth, as stored
    alignas(64) float direction[3][Block::size], t_near[Block::size], t_far[Block::size], spread[Block::size];
  };
  void fill_rows(const Block& block, Rows& rows) const;
  glm::dvec2 ndc(uint32_t x, uint32_t y) const;
  double ndc_depth(double depth) const;
  glm::dvec3 point(glm::dvec2 ndc, double z) const;
  bool cleared(double depth) const { return reversed_ ? depth <= 0.0 : depth >= 1.0; }

  glm::dmat4 local_from_clip_;
  bool perspective_, reversed_, zero_to_one_;
  glm::dvec2 pixel_;  // a pixel's size in normalized device coordinates
  glm::dvec3 eye_{0.0};
  double sign_ = 1.0;                                     // the sign of w in front of the eye
  glm::dvec3 along_x_{0.0}, along_y_{0.0}, center_{0.0};  // perspective: direction = center + x along_x + y along_y
  double spread_ = 0.0;  // perspective: a pixel's height where directions have length 1
  glm::dvec3 direction_{0.0};                             // orthographic: the direction of all rays
  glm::vec3 right_{0.0f}, up_{0.0f};
  AlphaCone alpha_cone_;
  double near_depth_, far_depth_;
};

// Holds a texel of a depth image: window depth 0..1, and stencil (0 if the format has none).
struct DepthTexel {
  double depth;
  uint32_t stencil;
};
DepthTexel read_depth(const DepthImage& image, uint32_t x, uint32_t y);
// Reads the depths of a row's first `count` texels.
void read_depths(const DepthImage& image, uint32_t y, uint32_t count, double* depths);
bool has_stencil(DepthFormat format);

}  // namespace sideray::rt
