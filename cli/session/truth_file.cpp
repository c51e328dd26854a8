#include "cli/session/truth_file.h"

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "cli/base/outputs.h"
#include "cli/session/scene_objects.h"
#include "scenes/base/json_text.h"

namespace sideray::cli {
namespace {

using TruthJson = nlohmann::ordered_json;

constexpr int opaque_category = 1, translucent_category = 2;

// Returns a pinhole's matrix in pixels from the top left corner, row by row, and the camera's position.
TruthJson camera_json(const sideray_camera& camera, uint32_t width, uint32_t height) {
  TruthJson json = TruthJson::object();
  json["world_from_camera"] = camera.world_from_camera;
  const double half = camera.orthographic ? double{camera.half_height} : std::tan(0.5 * double{camera.yfov});
  const double focal_y = 0.5 * height / half;
  const double focal_x = camera.fx_per_fy == 0.0f ? focal_y : focal_y * double{camera.fx_per_fy};
  const double middle_x = width * (0.5 + double{camera.shift_x}), middle_y = height * (0.5 + double{camera.shift_y});
  json[camera.orthographic ? "pixels_per_unit" : "K"] =
      camera.orthographic ? TruthJson(focal_y)
                          : TruthJson({focal_x, 0.0, middle_x, 0.0, focal_y, middle_y, 0.0, 0.0, 1.0});
  return json;
}

TruthJson image_json(const Session& session, const RenderOptions& options, uint32_t frame) {
  return {{"id", frame},
          {"file_name", std::filesystem::path(options.output).filename().string()},
          {"width", options.width()},
          {"height", options.height()},
          {"camera", camera_json(session.camera(), options.width(), options.height())}};
}

TruthJson box_json(const sideray_object_mask& mask) {
  return {mask.x, mask.y, mask.width, mask.height};
}

TruthJson mask_json(const sideray_object_mask& mask, const RenderOptions& options) {
  return {{"size", {options.height(), options.width()}},
          {"counts", std::vector<uint32_t>(mask.runs, mask.runs + mask.run_count)}};
}

TruthJson annotation_json(const SceneObject& node, const sideray_object_truth& truth, const RenderOptions& options,
                            uint32_t frame, size_t id) {
  return {{"id", id},
          {"image_id", frame},
          {"category_id", node.translucent ? translucent_category : opaque_category},
          {"name", node.name},
          {"surfaces", node.surfaces},
          {"iscrowd", 0},
          {"area", truth.visible.pixels},
          {"bbox", box_json(truth.visible)},
          {"segmentation", mask_json(truth.visible, options)},
          {"amodal_area", truth.amodal.pixels},
          {"amodal_bbox", box_json(truth.amodal)},
          {"amodal_segmentation", mask_json(truth.amodal, options)},
          {"coverage", truth.coverage},
          {"visible_fraction", truth.visible_fraction}};
}

// Writes an annotation on each line, for people and line tools.
std::string truth_text(const TruthJson& image, const std::vector<TruthJson>& annotations) {
  const TruthJson categories = {{{"id", opaque_category}, {"name", "opaque"}},
                                  {{"id", translucent_category}, {"name", "translucent"}}};
  std::string text = "{\"images\": [" + scenes::json_text(image) + "],\n\"categories\": " +
                     scenes::json_text(categories) + ",\n\"annotations\": [";
  for (size_t i = 0; i < annotations.size(); ++i) text += (i == 0 ? "\n" : ",\n") + scenes::json_text(annotations[i]);
  return text + "\n]}\n";
}

}  // namespace

void write_truth(Session& session, const RenderOptions& options, uint32_t frame) {
  if (options.truth.empty()) return;
  const std::vector<SceneObject> nodes = scene_objects(session.content());
  std::vector<uint32_t> surfaces, objects;
  for (size_t i = 0; i < nodes.size(); ++i)
    for (const uint32_t surface : nodes[i].surfaces) {
      surfaces.push_back(surface);
      objects.push_back(static_cast<uint32_t>(i + 1));
    }
  const ObjectTruths truths = session.object_truths(options, surfaces, objects);
  std::vector<TruthJson> annotations;
  for (size_t i = 0; i < truths.size(); ++i)
    if (truths[i].amodal.pixels > 0 || truths[i].coverage > 0.0)
      annotations.push_back(
          annotation_json(nodes[truths[i].object - 1], truths[i], options, frame, annotations.size() + 1));
  write_text(options.truth, truth_text(image_json(session, options, frame), annotations));
}

bool has_truth(const RenderOptions& options) {
  std::error_code ignored;
  return options.truth.empty() || std::filesystem::is_regular_file(options.truth, ignored);
}

}  // namespace sideray::cli
