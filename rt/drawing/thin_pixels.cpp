#include "rt/drawing/thin_pixels.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "rt/base/view_rays.h"
#include "rt/embree/alpha_test.h"
#include "rt/embree/trace_table.h"

namespace sideray::rt {
namespace {

constexpr double steps_in_pixel = 256.0;  // drivers round window positions to these steps

struct WindowVertex {
  glm::dvec2 place;  // in pixels
  double depth, w;
};

// A part of a line, from `first` to `last` as shares of its length. clip() keeps what has distances >= 0 from a plane.
struct Part {
  double first = 0.0, last = 1.0;
  void clip(double at_start, double at_end) {
    if (at_start < 0.0 && at_end < 0.0) last = -1.0;
    if ((at_start < 0.0) == (at_end < 0.0)) return;
    const double crossing = at_start / (at_start - at_end);
    if (at_start < 0.0)
      first = std::max(first, crossing);
    else
      last = std::min(last, crossing);
  }
};

class ThinPass {
 public:
  ThinPass(const OpaqueRequest& request, const ShadingScene& scene, OpaquePixels& pixels)
      : request_(request),
        scene_(scene),
        view_(request.view, request.width, request.height),
        size_(request.width, request.height),
        pixels_(pixels) {}

  void draw(uint32_t index) {
    const model::Instance& instance = scene_.snapshot->thin[index];
    const model::Mesh& mesh = *scene_.snapshot->meshes[instance.mesh];
    take(index, instance, mesh);
    for (uint32_t primitive = 0; primitive < mesh.triangles.size(); ++primitive) {
      primitive_ = primitive;
      const glm::uvec3 corners = mesh.triangles[primitive];
      if (mesh.topology == SIDERAY_POINTS)
        draw_point(clip_place(instance, mesh.positions[corners.x]));
      else
        draw_line(clip_place(instance, mesh.positions[corners.x]), clip_place(instance, mesh.positions[corners.y]));
    }
  }

 private:
  void take(uint32_t index, const model::Instance& instance, const model::Mesh& mesh) {
    hit_ = {};
    hit_.instance = thin_instance | index;
    hit_.front = true;
    const model::Material& material = scene_.snapshot->materials[instance.material];
    cut_out_.reset();
    if (!material.discards) return;
    cut_out_ = TraceInstance{.columns = {},
                             .positions = mesh.positions.data(),
                             .triangles = mesh.triangles.data(),
                             .surface_id = instance.surface_id,
                             .sprites = 0,
                             .mirrored = false,
                             .culls = false,
                             .discards = true,
                             .mesh = &mesh,
                             .material = &material,
                             .alpha = nullptr};
  }

  glm::dvec4 clip_place(const model::Instance& instance, glm::vec3 position) const {
    return request_.view.clip_from_local * glm::dvec4(instance.local_from_object * glm::vec4(position, 1.0f), 1.0);
  }

  WindowVertex in_window(const glm::dvec4& clip) const {
    const glm::dvec3 ndc = glm::dvec3(clip) / clip.w;
    const glm::dvec2 place = (glm::dvec2(ndc) * 0.5 + 0.5) * size_;
    return {glm::round(place * steps_in_pixel) / steps_in_pixel,
            request_.view.zero_to_one_depth ? ndc.z : 0.5 * ndc.z + 0.5, clip.w};
  }

  // Return the distance of a clip-space position from a depth plane; negative outside.
  double before_near(const glm::dvec4& p) const { return request_.view.zero_to_one_depth ? p.z : p.z + p.w; }
  static double before_far(const glm::dvec4& p) { return p.w - p.z; }

  void draw_point(const glm::dvec4& clip) {
    if (!(clip.w > 0.0) || before_near(clip) < 0.0 || before_far(clip) < 0.0) return;
    const WindowVertex v = in_window(clip);
    draw_fragment(glm::floor(v.place), v.depth, 0.0);
  }

  void draw_line(const glm::dvec4& from, const glm::dvec4& to) {
    Part part;
    constexpr double least_w = 1e-12;
    part.clip(from.w - least_w, to.w - least_w);
    part.clip(before_near(from), before_near(to));
    part.clip(before_far(from), before_far(to));
    // Ends may lie outside the picture by half its size on each side; only farther ones are clipped, which moves them.
    for (int axis = 0; axis < 2; ++axis) {
      part.clip(2.0 * from.w + from[axis], 2.0 * to.w + to[axis]);
      part.clip(2.0 * from.w - from[axis], 2.0 * to.w - to[axis]);
    }
    if (!(part.first < part.last)) return;
    const WindowVertex a = in_window(glm::mix(from, to, part.first)), b = in_window(glm::mix(from, to, part.last));
    if (a.place == b.place) return;
    const glm::dvec2 way = glm::abs(b.place - a.place);
    rasterize(a, b, part, way.x >= way.y ? 0 : 1);
  }

  // Draws one pixel in each column (each row for a steep line) whose diamond the line leaves. A line that leans by less
  // than 45 degrees is nearest to a pixel's centre, in the diamond metric, directly above or below it.
  void rasterize(const WindowVertex& a, const WindowVertex& b, const Part& part, int major) {
    const int minor = 1 - major;
    const double from = a.place[major], to = b.place[major];
    const double first = std::max(std::floor(std::min(from, to)), 0.0);
    const double last = std::min(std::floor(std::max(from, to)), size_[major] - 1.0);
    const glm::dvec2 way = b.place - a.place;
    for (double column = first; column <= last; ++column) {
      const double share = std::clamp((column + 0.5 - from) / (to - from), 0.0, 1.0);
      const glm::dvec2 nearest = a.place + share * way;
      glm::dvec2 pixel;
      pixel[major] = column;
      pixel[minor] = std::floor(nearest[minor]);
      const glm::dvec2 center = pixel + 0.5;
      const bool is_end = share == 0.0 || share == 1.0;
      if (is_end && !is_in_diamond(nearest, center)) continue;
      if (is_in_diamond(b.place, center)) continue;
      draw_on_line(a, b, part, pixel, std::clamp(glm::dot(center - a.place, way) / glm::dot(way, way), 0.0, 1.0));
    }
  }

  static bool is_in_diamond(glm::dvec2 place, glm::dvec2 center) {
    const glm::dvec2 away = glm::abs(place - center);
    return away.x + away.y < 0.5;
  }

  void draw_on_line(const WindowVertex& a, const WindowVertex& b, const Part& part, glm::dvec2 pixel, double share) {
    const double to_b = share / b.w, to_a = (1.0 - share) / a.w;
    const double along = to_b / (to_a + to_b);
    draw_fragment(pixel, glm::mix(a.depth, b.depth, share), glm::mix(part.first, part.last, along));
  }

  // `along`: for a line, the weight of its second vertex.
  void draw_fragment(glm::dvec2 place, double depth, double along) {
    if (!(place.x >= 0.0 && place.y >= 0.0 && place.x < size_.x && place.y < size_.y)) return;
    const glm::uvec2 p(place);
    const size_t texel = size_t{p.y} * pixels_.width + p.x;
    const float stored = stored_depth(request_.view, depth);
    const bool is_nearer =
        request_.view.reversed_depth ? stored > pixels_.depths[texel] : stored < pixels_.depths[texel];
    if (!is_nearer) return;
    Hit hit = hit_;
    hit.primitive = primitive_;
    hit.u = static_cast<float>(along);
    hit.distance = view_.distance(p.x, p.y, double{stored});
    if (cut_out_ && alpha_discards(*scene_.snapshot, *cut_out_, view_.ray(p.x, p.y), hit, Cone{})) return;
    pixels_.depths[texel] = stored;
    pixels_.hits[texel] = hit;
  }

  const OpaqueRequest& request_;
  const ShadingScene& scene_;
  ViewRays view_;
  glm::dvec2 size_;
  OpaquePixels& pixels_;
  Hit hit_{};  // with the instance being drawn
  uint32_t primitive_ = 0;
  std::optional<TraceInstance> cut_out_;  // set if the instance may have holes
};

}  // namespace

void draw_thin(const OpaqueRequest& request, const ShadingScene& scene, OpaquePixels& pixels) {
  const std::vector<model::Instance>& thin = scene.snapshot->thin;
  if (thin.empty()) return;
  ThinPass pass(request, scene, pixels);
  for (uint32_t i = 0; i < thin.size(); ++i) pass.draw(i);
}

}  // namespace sideray::rt
