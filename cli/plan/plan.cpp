#include "cli/plan/plan.h"

#include <nlohmann/json.hpp>

#include "cli/base/failure.h"
#include "cli/plan/plan_report.h"
#include "scenes/base/json_text.h"

namespace sideray::cli {
namespace {

// Leaves out files, ways of running and checks of the result, since a plan draws nothing.
Table table() {
  static const sideray_option json = flag_row("json", "prints JSON");
  Table t = picture_table([](const sideray_option& option) { return option.cost != SIDERAY_COST_NONE; },
                          [](const OwnOption& own) { return own.in_plan; });
  t.push_back(&json);
  return t;
}

RenderOptions resolve(const std::string& scene, Given given) {
  check_given(plan_table(), given);
  if (scene.empty()) wrong_usage("plan: no scene; give a .gltf or .glb file or a built-in name (sideray make --list)");
  given.erase("json");
  given["o"] = given.contains("frames") ? "plan.#.exr" : "plan.exr";  // never written
  // How far light is followed in the reference of predicted errors; only references read these options.
  Given of_truth;
  for (const char* name : {"bounces", "caustics"})
    if (auto option = given.extract(name)) of_truth.insert(std::move(option));
  RenderOptions options = resolve_render(scene, given);
  if (!of_truth.empty() && options.is_exact()) {
    given.merge(of_truth);
    options = resolve_render(scene, given);
  } else {
    options.given.merge(of_truth);
  }
  options.continues = options.frames.has_value();  // for all frames but the first
  return options;
}

// Returns nothing where predictions are impossible, and prints why: for references, and on a machine that draws
// nothing. With bounds, which need predictions, it throws.
std::optional<Calibration> calibration_of(Session& session, const RenderOptions& options) {
  if (options.bounds.any()) return Calibration(session, options);
  if (!is_predictable(options)) {
    print_note("plan: a reference is not predicted; its bounds are printed");
    return {};
  }
  try {
    return Calibration(session, options);
  } catch (const Error& error) {
    print_warning(fmt::format("plan: nothing is predicted, bounds are printed: {}", error.what()));
    return {};
  }
}

}  // namespace

const Table& plan_table() {
  static const Table options = table();
  return options;
}

int plan(const std::string& scene, const Given& given) {
  const RenderOptions asked = resolve(scene, given);
  Session session(asked);
  std::optional<Calibration> calibration = calibration_of(session, asked);
  std::optional<Choice> choice;
  if (asked.bounds.any()) choice = choose(session, *calibration, asked);
  const RenderOptions& options = choice ? choice->chosen().options : asked;
  const Session::Planned planned = session.plan(options);
  std::optional<lab::FrameCost> predicted;
  if (calibration)
    predicted = predict(calibration->probe(options), options, *sideray_plan_most_work(planned.plan.get()));
  const PlanReport report{options, planned, predicted, choice};
  if (given.contains("json"))
    fmt::print("{}\n", scenes::json_text(plan_json(report), 2));
  else
    print_plan(report);
  return exit_ok;
}

}  // namespace sideray::cli
