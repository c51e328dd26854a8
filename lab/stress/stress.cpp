#include "lab/stress/stress.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>

#include "lab/stress/stress_scene.h"
#include "scenes/base/files.h"

namespace sideray::lab {

const std::vector<StressCase>& stress_cases() {
  static const std::vector<StressCase> cases{
      {"layer-gap", "four panes a relative gap apart: which layers rays find", layer_gap_case},
      {"coplanar", "panes in one plane: whether each is found once, in the order of their ids", coplanar_case},
      {"layer-count", "1 to 8 panes 0.7 apart from a distance of 2: which layers rays find", layer_count_case},
      {"instance-scale", "three panes under scaled and mirrored transforms: which layers rays find",
       instance_scale_case},
      {"world-offset", "three panes far from the world's origin: which layers rays find", world_offset_case},
      {"match-gap", "walls of glass a relative gap apart: whose layer their fragments take", match_gap_case, true},
      {"match-distance", "walls of glass 6 mm apart, near and far: whose layer their fragments take",
       match_distance_case, true},
      {"match-incidence", "walls of glass at grazing angles: whose layer their fragments take", match_incidence_case, true},
      {"match-near", "walls of glass under several near planes: whose layer their fragments take", match_near_case, true},
      {"wind-gap", "a floor that wind has moved below its rest pose: which of its pixels are in false shadow",
       wind_gap_case},
      {"contact", "a floor that takes the inexact test under an occluder: which of its pixels are lit", contact_case},
      {"self-shadow", "a plain floor near and far: which of its pixels shadow themselves", self_shadow_case},
      {"leaves", "leaf cards from several pixels to a fraction of one wide: whose shadow pixels below them show",
       leaves_case},
      {"settling", "a shadow whose occluder has jumped, and noise at rest: how long ghosts stay, what flickers",
       settling_case},
      {"depth-format", "shadow rays from stored depth, by format and offset: what they hit and what they miss",
       depth_format_case},
      {"ray-layers", "up to 64 panes 0.05 apart from a distance of 2: which surfaces rays return", ray_layers_case},
      {"broken-triangles", "a wall whose mesh has degenerate, non-finite or skinny triangles too: whether rays hit it",
       broken_triangles_case},
      {"late-glass", "a pane that moves while its layers are a frame late: whether fragments find their own colours",
       late_glass_case},
      {"budget", "lamps, occluders, glass, smoke, wind, cuts and sizes that change under a budget: how wrong pictures get, and how long",
       budget_case},
      {"bounce", "light that bounces, beside paths: a lamp, a door and a box that change, a wall of 1 cm, a camera that moves",
       bounce_case}};
  return cases;
}

bool has_meaning(const StressCase& stress_case, const StressStage& stage) {
  return !(stress_case.of_fragments && stage.by_rays);
}

std::vector<StressRow> run_case(const StressCase& stress_case, StressStage& stage) {
  return has_meaning(stress_case, stage) ? stress_case.run(stage) : std::vector<StressRow>();
}

StressStage stress_stage(Renderer& renderer, bool quick) {
  const bool by_rays = std::string_view(renderer.device().gl) == "none";
  return {renderer, quick, quick ? 48u : 96u, quick ? 27u : 54u, by_rays};
}

std::vector<const StressRow*> failing_defaults(const std::vector<StressRow>& rows) {
  std::vector<const StressRow*> failing;
  for (const StressRow& row : rows)
    if (row.is_default && !row.pass()) failing.push_back(&row);
  return failing;
}

Json stress_json(const std::vector<StressRow>& rows) {
  Json cases = Json::array();
  for (const StressRow& row : rows) {
    if (!std::isfinite(row.value) || !std::isfinite(row.bound))
      scenes::refuse("stress: {} of {} is not a number; this is a defect, please report it", row.measure, row.name);
    cases.push_back({{"name", row.name},
                     {"variant", row.variant},
                     {"parameters", row.parameters},
                     {"measure", row.measure},
                     {"value", row.value},
                     {"bound", row.bound},
                     {"pass", row.pass()}});
  }
  return {{"schema", 1}, {"cases", cases}};
}

}  // namespace sideray::lab
