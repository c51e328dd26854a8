#include "choice.h"

#include <set>

#include "failure.h"
#include "sweep_scene.h"
#include "used_config.h"

namespace sideray::cli {
namespace {

// Empty where the given options leave it no room.
std::optional<RenderOptions> resolved(const RenderOptions& options, const lab::Configuration& configuration) {
  Given given = options.given;
  given.insert(configuration.begin(), configuration.end());
  try {
    RenderOptions result = resolve_render(options.scene, given);
    result.options.continues = options.options.continues;
    return result;
  } catch (const UsageError&) {
    return {};
  }
}

// Those that come to the same are drawn once: layers beyond what a ray meets, options without a use.
std::vector<Considered> distinct_candidates(Session& session, const RenderOptions& options) {
  std::vector<Considered> list;
  std::set<std::string> known;
  for (const lab::Configuration& configuration :
       lab::candidate_configurations(sweep_scene(session, options), options.given)) {
    std::optional<RenderOptions> candidate = resolved(options, configuration);
    if (!candidate) continue;
    const std::string used = used_config(*candidate, session.plan(*candidate).run).dump();
    if (known.insert(used).second) list.push_back({configuration, std::move(*candidate), {}});
  }
  if (list.empty()) list.push_back({{}, options, {}});
  return list;
}

std::string bounds_text(const lab::CostBounds& bounds) {
  std::string text;
  if (bounds.most_ms) text += fmt::format("--max-ms {}", *bounds.most_ms);
  if (bounds.most_error) text += fmt::format("{}--max-error {}", text.empty() ? "" : " and ", *bounds.most_error);
  return text;
}

[[noreturn]] void fail_to_hold(const std::vector<Considered>& considered, size_t nearest,
                               const lab::CostBounds& bounds) {
  throw Error(SIDERAY_UNSUPPORTED,
              fmt::format("{}: none of {} configurations holds it; the nearest is {}: raise the bound, or leave more "
                          "options open",
                          bounds_text(bounds), considered.size(), describe(considered[nearest])));
}

double predicted_ms(Session& session, Calibration& calibration, const RenderOptions& options) {
  const Session::Planned planned = session.plan(options);
  return predict(calibration.probe(options), options, sideray_plan_most_work(planned.plan.get())).ms();
}

}  // namespace

Choice choose(Session& session, Calibration& calibration, const RenderOptions& options) {
  Choice choice;
  choice.considered = distinct_candidates(session, options);
  std::vector<lab::Candidate> costs;
  for (const Considered& c : choice.considered) {
    const Calibration::Glance glance = calibration.glance(c.options);
    costs.push_back({glance.error, glance.ms * c.options.options.samples, {}});
  }
  lab::Pick pick = lab::next_pick(costs, options.bounds);
  for (; pick.step == lab::PickStep::time; pick = lab::next_pick(costs, options.bounds))
    costs[pick.candidate].ms = predicted_ms(session, calibration, choice.considered[pick.candidate].options);
  for (size_t i = 0; i < costs.size(); ++i) choice.considered[i].cost = costs[i];
  choice.picked = pick.candidate;
  if (pick.step == lab::PickStep::failed) fail_to_hold(choice.considered, pick.candidate, options.bounds);
  return choice;
}

RenderOptions with_choice(Session& session, const RenderOptions& options) {
  if (!options.bounds.any()) return options;
  Calibration calibration(session, options);
  const Choice choice = choose(session, calibration, options);
  print_note(fmt::format("{}: chose {}", bounds_text(options.bounds), describe(choice.chosen())));
  session.move_to(options);
  return choice.chosen().options;
}

std::string describe(const Considered& considered) {
  const lab::Candidate& cost = considered.cost;
  std::string text = lab::describe(considered.configuration);
  if (cost.ms) text += fmt::format(", predicted {:.1f} ms", *cost.ms);
  if (cost.error) text += fmt::format(", error {:.4f}", *cost.error);
  return text;
}

}  // namespace sideray::cli
