// Makes small scenes and pictures for the stress cases. Only the main thread may call it.
#pragma once

#include <array>
#include <glm/glm.hpp>
#include <span>

#include "lab/stress/stress.h"
#include "scenes/images/images.h"

namespace sideray::lab {

// Describes one planar surface by its corners, in its own space.
struct Pane {
  std::array<glm::dvec3, 4> corners;
  glm::dmat4 world_from_pane = glm::dmat4(1.0);
};

// Returns a square perpendicular to the view at z = -depth, larger than the view of a camera at the origin.
Pane pane_across(double depth);

// Adds panes as unlit translucent surfaces of different colours, with ids 1, 2, ... in the given order.
Scene scene_of_panes(const std::vector<Pane>& panes);

// Adds a mesh of triangles, given by three indices each.
sideray_mesh add_triangles(Scene& scene, std::span<const glm::vec3> positions, std::span<const uint32_t> indices);

// Sets a light straight down as the only light.
void set_light_from_above(Scene& scene);

// Adds a rectangle of the material as one instance.
sideray_instance add_quad(Scene& scene, const Pane& pane, const sideray_material_desc& material, uint32_t surface_id,
                          sideray_wind wind = 0);

// Returns a camera at the origin of `world_from_camera` that looks along its -z.
sideray_camera camera_at(const glm::dmat4& world_from_camera, double fov_deg, double near);

// Returns the options of one stress picture: its size, one untimed frame with counters, no shadows, no filters, every
// ray traced.
RenderOptions picture_options(const StressStage& stage, sideray_shadows shadows = SIDERAY_SHADOWS_OFF,
                              sideray_translucency translucency = SIDERAY_TRANSLUCENCY_HYBRID);

// Returns the options of a sequence's frame: the program's defaults, except for size and times.
RenderOptions sequence_options(const StressStage& stage, sideray_ambient ambient = SIDERAY_AMBIENT_AO);

// Sets the options for the frame with this number.
void set_frame(RenderOptions& options, uint32_t frame, bool continues);

// Gives access to a picture's planes by name, top row first.
class Planes {
 public:
  explicit Planes(const Picture& picture) : picture_(picture) {}
  const float* floats(const std::string& name) const;
  const uint32_t* whole(const std::string& name) const;
  size_t pixels() const { return size_t{picture_.width()} * picture_.height(); }

 private:
  const void* find(const std::string& name) const;
  const Picture& picture_;
};

// Returns the picture's colours in linear light.
scenes::Image image_of(const Picture& picture);

// Returns the mean FLIP of a picture.
double flip(const scenes::Image& test, const scenes::Image& reference);

FailureMap map_of(const StressStage& stage);

// Returns `values`, or `quick_values` in a quick run.
std::vector<double> swept(const StressStage& stage, std::vector<double> values, std::vector<double> quick_values);

std::vector<StressRow> layer_gap_case(StressStage& stage);
std::vector<StressRow> coplanar_case(StressStage& stage);
std::vector<StressRow> layer_count_case(StressStage& stage);
std::vector<StressRow> instance_scale_case(StressStage& stage);
std::vector<StressRow> world_offset_case(StressStage& stage);
std::vector<StressRow> match_gap_case(StressStage& stage);
std::vector<StressRow> match_distance_case(StressStage& stage);
std::vector<StressRow> match_incidence_case(StressStage& stage);
std::vector<StressRow> match_near_case(StressStage& stage);
std::vector<StressRow> wind_gap_case(StressStage& stage);
std::vector<StressRow> contact_case(StressStage& stage);
std::vector<StressRow> self_shadow_case(StressStage& stage);
std::vector<StressRow> leaves_case(StressStage& stage);
std::vector<StressRow> settling_case(StressStage& stage);
std::vector<StressRow> depth_format_case(StressStage& stage);
std::vector<StressRow> ray_layers_case(StressStage& stage);
std::vector<StressRow> broken_triangles_case(StressStage& stage);
std::vector<StressRow> late_glass_case(StressStage& stage);
std::vector<StressRow> budget_case(StressStage& stage);
std::vector<StressRow> bounce_case(StressStage& stage);

}  // namespace sideray::lab
