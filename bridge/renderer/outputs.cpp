#include "bridge/renderer/outputs.h"

#include <fmt/format.h>
#include <half.h>

#include <bit>
#include <cmath>
#include <cstring>

#include "bridge/renderer/answer_outputs.h"
#include "bridge/renderer/truth_outputs.h"
#include "gl/scene/raster_view.h"
#include "shaders/shading/shading_cpp.h"

namespace sideray::bridge {
namespace {

// Returns the planar distance along the view axis of each pixel's window depth; +inf where nothing was drawn.
std::vector<float> planar_distances(const std::vector<float>& depth, const gl::RasterView& view, uint32_t width,
                                    uint32_t height) {
  std::vector<float> z(depth.size());
  const glm::dmat4 view_from_clip = view.view_from_local * view.local_from_clip;
  const glm::dmat4 rows = glm::transpose(view_from_clip);
  const glm::dvec4 &along_view = rows[2], &w = rows[3];
  const float background = view.reversed_depth ? 0.0f : 1.0f;
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) {
      const size_t i = size_t{y} * width + x;
      if (depth[i] == background) {
        z[i] = INFINITY;
        continue;
      }
      const double clip_z = view.zero_to_one_depth ? double{depth[i]} : 2.0 * double{depth[i]} - 1.0;
      const glm::dvec4 p((x + 0.5) / width * 2.0 - 1.0, (y + 0.5) / height * 2.0 - 1.0, clip_z, 1.0);
      z[i] = static_cast<float>(-glm::dot(along_view, p) / glm::dot(w, p));
    }
  return z;
}

void add_layers(Picture& picture, const rt::LayerCache& cache, uint32_t layers) {
  const size_t plane = size_t{cache.width} * cache.height;
  for (uint32_t k = 0; k < layers; ++k) {
    const std::string prefix = fmt::format("layer{}.", k);
    const uint16_t* halfs = cache.radiance.data() + 4 * plane * k;
    const char* const names[] = {"R", "G", "B"};
    for (size_t c = 0; c < 3; ++c)
      add_plane(picture, prefix + names[c], [&](size_t i) {
        Imath::half value;
        value.setBits(halfs[4 * i + c]);
        return cache.distance[plane * k + i] != 0.0f ? static_cast<float>(value) : 0.0f;
      });
    add_plane(picture, prefix + "distance", [&](size_t i) { return std::abs(cache.distance[plane * k + i]); });
    add_plane(picture, prefix + "surface",
              [&](size_t i) { return cache.distance[plane * k + i] != 0.0f ? cache.surface_id[plane * k + i] : 0u; });
  }
}

// Returns the suffix of a mask's channel: its index, which the caller replaces by the light's name; the last mask may
// combine all lights from number 32 on.
std::string name_of_mask(const PictureJob& job, uint32_t layer) {
  const auto single = static_cast<uint32_t>(std::popcount(job.plan.masks.shadow_lights));
  return layer < single ? fmt::format("{}", layer) : "combined";
}

void add_occlusion(const PictureJob& job, Picture& picture) {
  if (!job.plan.masks_shadows()) return;
  const rt::OcclusionMasks& masks = job.backend.masks();
  const size_t plane = size_t{masks.width} * masks.height;
  const bool shows_shadow = job.options.shows(SIDERAY_AOV_SHADOW);
  const bool shows_distance = job.options.shows(SIDERAY_AOV_HIT_DISTANCE) && !masks.hit_distance.empty();
  const std::vector<uint8_t> lit = shows_shadow ? job.backend.read_shadows(masks.lit.size()) : std::vector<uint8_t>();
  for (uint32_t k = 0; k < job.plan.shadow_masks(); ++k) {
    if (shows_shadow)
      add_plane(picture, "shadow." + name_of_mask(job, k),
                [&](size_t i) { return static_cast<float>(lit[plane * k + i]) / 255.0f; });
    if (shows_distance)
      add_plane(picture, "hitdist." + name_of_mask(job, k), [&](size_t i) { return masks.hit_distance[plane * k + i]; });
  }
}

void add_depth(const PictureJob& job, const gl::RasterView& view, Picture& picture) {
  const std::vector<float> z =
      planar_distances(job.backend.read_depth(), view, job.plan.width, job.plan.height);
  add_plane(picture, "Z", [&](size_t i) { return z[i]; });
}

// Returns unit normals turned toward the eye, as light turns them after reading a rasterizer's G-buffer.
std::vector<glm::vec3> seen_normals(const std::vector<glm::vec4>& gbuffer, const gl::RasterView& view, uint32_t width,
                                    uint32_t height) {
  std::vector<glm::vec3> normals(gbuffer.size(), glm::vec3(0.0f));
  const gl::ViewRays rays = gl::make_view_rays(view);
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) {
      const size_t i = size_t{y} * width + x;
      const glm::vec3 normal(gbuffer[i]);
      if (normal == glm::vec3(0.0f)) continue;
      const glm::vec2 at = 2.0f * (glm::vec2(x, y) + 0.5f) / glm::vec2(width, height) - 1.0f;
      const glm::vec3 ray = rays.ray + rays.ray_x * at.x + rays.ray_y * at.y;
      normals[i] = shading::sr_toward_eye(glm::normalize(normal), -glm::normalize(ray));
    }
  return normals;
}

void add_gbuffer(const PictureJob& job, const gl::RasterView& view, Picture& picture) {
  const RenderOptions& o = job.options;
  rt::OpaqueMaterials g;
  if (o.shows(SIDERAY_AOV_NORMAL | SIDERAY_AOV_ALBEDO | SIDERAY_AOV_MATERIAL))
    g = job.backend.read_gbuffer();
  else
    g.ids = job.backend.read_ids();
  if (o.shows(SIDERAY_AOV_NORMAL)) {
    const auto normals = seen_normals(g.normal_roughness, view, job.plan.width, job.plan.height);
    add_vectors(picture, "N.", {"X", "Y", "Z"}, [&](size_t i) { return normals[i]; });
  }
  if (o.shows(SIDERAY_AOV_ALBEDO))
    add_vectors(picture, "albedo.", {"R", "G", "B"}, [&](size_t i) { return g.albedo_metallic[i]; });
  if (o.shows(SIDERAY_AOV_MATERIAL)) {
    add_plane(picture, "material.metallic", [&](size_t i) { return g.albedo_metallic[i].w; });
    add_plane(picture, "material.roughness", [&](size_t i) { return g.normal_roughness[i].w; });
  }
  if (o.shows(SIDERAY_AOV_ID)) {
    add_plane(picture, "id.surface", [&](size_t i) { return g.ids[i].x; });
    add_plane(picture, "id.primitive", [&](size_t i) { return g.ids[i].y; });
  }
}

void add_motion(const PictureJob& job, Picture& picture) {
  const std::vector<glm::vec2> motion = job.backend.read_motion();
  add_plane(picture, "motion.X", [&](size_t i) { return motion[i].x; });
  add_plane(picture, "motion.Y", [&](size_t i) { return -motion[i].y; });  // y points down, as the rows of pictures
}

void add_inexact_marks(const PictureJob& job, Picture& picture) {
  const std::vector<uint8_t> stencil = job.backend.read_stencil();
  const uint32_t bits = job.plan.marks_inexact ? gl::inexact_stencil_bit : 0;
  add_plane(picture, "mask.inexact", [&](size_t i) { return (stencil[i] & bits) != 0 ? 1u : 0u; });
}

void add_mask_count(const PictureJob& job, Picture& picture) {
  const std::vector<uint8_t> counts = job.backend.count_translucent(job);
  add_plane(picture, "mask.count", [&](size_t i) { return static_cast<uint32_t>(counts[i] & gl::mask_stencil_bits); });
}

}  // namespace

void add_aovs(const PictureJob& job, const gl::RasterView& view, Picture& picture) {
  const RenderOptions& o = job.options;
  if (o.shows(SIDERAY_AOV_Z)) add_depth(job, view, picture);
  if (o.shows(SIDERAY_AOV_NORMAL | SIDERAY_AOV_ALBEDO | SIDERAY_AOV_MATERIAL | SIDERAY_AOV_ID))
    add_gbuffer(job, view, picture);
  if (o.shows(SIDERAY_AOV_SHADOW | SIDERAY_AOV_HIT_DISTANCE)) add_occlusion(job, picture);
  if (o.shows(SIDERAY_AOV_MOTION)) add_motion(job, picture);
  if (o.shows(SIDERAY_AOV_INEXACT)) add_inexact_marks(job, picture);
  if (o.shows(SIDERAY_AOV_MASK)) add_mask_count(job, picture);
  if (o.shows(SIDERAY_AOV_LAYERS) && job.plan.layers_to_show() > 0)
    add_layers(picture, job.backend.read_layers(job), job.plan.layers_to_show());
  add_answers(job, picture);
  add_ground_truth(job, picture);
}

}  // namespace sideray::bridge
