// Tests the start of shadow rays, by depth format and offset method, on a floor whose depth is rounded like a depth
// buffer's. Either nothing shadows the floor, or a plane just above shadows all of it. Rays go through
// sideray_tracer_trace_rays.
#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <glm/glm.hpp>

#include "lab/stress/stress_scene.h"

namespace sideray::lab {
namespace {

enum class Format { d24, d32f, reversed };
struct NamedFormat {
  const char* name;
  Format format;
};
constexpr std::array<NamedFormat, 3> formats{
    {{"D24", Format::d24}, {"D32F", Format::d32f}, {"reversed D32F", Format::reversed}}};

enum class Offset { none, short_start, long_start, ulps, bound };
struct Method {
  const char* variant;
  Offset offset;
};
constexpr std::array<Method, 5> methods{{{"no offset", Offset::none},
                                         {"t_near 0.001", Offset::short_start},
                                         {"t_near 0.1", Offset::long_start},
                                         {"256 ulps along the normal", Offset::ulps},
                                         {"half a depth step + 2^-21 z toward the eye", Offset::bound}}};

// Rounds planar distances as a depth buffer does.
struct DepthBuffer {
  Format format;
  double near, far;

  double window(double z) const {
    return format == Format::reversed ? near / z : far / (far - near) * (1.0 - near / z);
  }
  double distance(double window) const {
    return format == Format::reversed ? near / window : near / (1.0 - window * (far - near) / far);
  }
  double stored(double z) const {
    constexpr double codes = 16777215.0;
    const double w = window(z);
    return format == Format::d24 ? std::round(w * codes) / codes : double{static_cast<float>(w)};
  }
  // Returns the distance that one step of the stored value covers.
  double step(double w) const {
    const auto f = static_cast<float>(w);
    const double code = format == Format::d24 ? 0x1p-24 : double{std::nextafter(f, 2.0f)} - double{f};
    const double next = format == Format::reversed ? w - code : w + code;
    return std::abs(distance(next) - distance(w));
  }
};

// Moves an origin as in Ray Tracing Gems, chapter 6: by a fixed number of integer steps of the float, for origins at
// ray hits.
double moved_by_ulps(double coordinate) {
  const auto f = static_cast<float>(coordinate);
  if (std::abs(f) < 1.0f / 32.0f) return double{f + 1.0f / 65536.0f};
  return double{std::bit_cast<float>(std::bit_cast<int32_t>(f) + (f < 0.0f ? -256 : 256))};
}

sideray_ray shadow_ray(glm::dvec3 eye, glm::dvec3 d, double cosine, const DepthBuffer& depth, Offset offset) {
  const double w = depth.stored(-eye.y / d.y * cosine), z = depth.distance(w);
  const double pulled = offset == Offset::bound ? 0.5 * depth.step(w) + 0x1p-21 * z : 0.0;
  glm::dvec3 origin = eye + (z - pulled) / cosine * d;
  if (offset == Offset::ulps) origin.y = moved_by_ulps(origin.y);
  const glm::vec3 to_sun = glm::normalize(glm::vec3(-0.3f, 0.8f, -0.2f));
  sideray_ray ray{};
  for (int c = 0; c < 3; ++c) ray.origin[c] = origin[c], ray.direction[c] = to_sun[c];
  ray.t_near = offset == Offset::short_start ? 0.001f : offset == Offset::long_start ? 0.1f : 0.0f;
  ray.t_far = std::numeric_limits<float>::max();
  return ray;
}

// Returns shadow rays from the surfaces seen at `height` above the floor, looking 30 degrees down.
std::vector<sideray_ray> shadow_rays(const StressStage& stage, double height, const DepthBuffer& depth, Offset offset) {
  const double angle = glm::radians(30.0), half = std::tan(glm::radians(22.5));
  const glm::dvec3 ahead(0, -std::sin(angle), -std::cos(angle)), up(0, std::cos(angle), -std::sin(angle));
  std::vector<sideray_ray> rays;
  for (uint32_t y = 0; y < stage.height; ++y)
    for (uint32_t x = 0; x < stage.width; ++x) {
      const double v = half * (1.0 - (y + 0.5) / stage.height * 2.0);
      const double u = half * ((x + 0.5) / stage.width * 2.0 - 1.0) * stage.width / stage.height;
      const glm::dvec3 d = glm::normalize(ahead + u * glm::dvec3(1, 0, 0) + v * up);
      rays.push_back(shadow_ray({0, height, 0}, d, glm::dot(d, ahead), depth, offset));
    }
  return rays;
}

Scene planes_at(const std::vector<double>& heights, double size) {
  Scene scene = Scene::create().value();
  uint32_t id = 1;
  for (const double y : heights)
    add_quad(scene, {{{{-size, y, size}, {size, y, size}, {size, y, -size}, {-size, y, -size}}}},
             sideray_material_defaults(), id++);
  scene.commit();
  return scene;
}

struct Floor {
  Tracer alone, covered;  // covered: the floor with a plane over it, at a hundredth of the eye's height
};

void add_rows(StressStage& stage, Floor& floor, double height, const NamedFormat& format, const Method& method,
              std::vector<StressRow>& rows) {
  const double near = 0.01 * height;
  const std::vector<sideray_ray> rays = shadow_rays(stage, height, {format.format, near, 1e5 * near}, method.offset);
  for (const bool covered : {false, true}) {
    const std::vector<sideray_hit> hits = (covered ? floor.covered : floor.alone).trace(SIDERAY_RAYS_OPAQUE, rays);
    StressRow row;
    row.name = "depth-format", row.variant = method.variant;
    row.parameters = {{"format", format.name}, {"distance", height}, {"near", near}};
    row.measure = covered ? "rays that miss an occluder at 1 % of the distance, share"
                          : "rays that hit the floor they start from, share";
    row.map = map_of(stage);
    uint64_t wrong = 0;
    for (size_t i = 0; i < rays.size(); ++i)
      if ((hits[i].surface_id == 0) == covered) row.map.wrong[i] = 1, ++wrong;
    row.value = static_cast<double>(wrong) / static_cast<double>(rays.size());
    rows.push_back(std::move(row));
  }
}

}  // namespace

std::vector<StressRow> depth_format_case(StressStage& stage) {
  std::vector<StressRow> rows;
  for (const double height : swept(stage, {0.1, 1.0, 10.0, 100.0, 1e3, 1e4}, {0.1, 1e3})) {
    const double size = 100.0 * height;
    const Scene alone = planes_at({0.0}, size), covered = planes_at({0.0, 0.01 * height}, size);
    Floor floor{Tracer::create(alone).value(), Tracer::create(covered).value()};
    for (const NamedFormat& format : formats)
      for (const Method& method : methods) add_rows(stage, floor, height, format, method, rows);
  }
  return rows;
}

}  // namespace sideray::lab
