#include "cli/plan/choice.h"

#include <map>
#include <set>

#include "cli/base/failure.h"
#include "cli/base/progress.h"
#include "cli/plan/sweep_scene.h"
#include "cli/session/used_config.h"
#include "scenes/base/json_text.h"

namespace sideray::cli {
namespace {

// Returns nothing where the given options contradict the configuration.
std::optional<RenderOptions> resolved(const RenderOptions& options, const lab::Configuration& configuration) {
  Given given = options.given;
  given.insert(configuration.begin(), configuration.end());
  try {
    RenderOptions result = resolve_render(options.scene, given);
    result.continues = options.continues;
    return result;
  } catch (const UsageError&) {
    return {};
  }
}

// Numbers texts; equal texts have equal numbers.
class Numbers {
 public:
  size_t of(const std::string& text) { return numbers_.emplace(text, numbers_.size()).first->second; }

 private:
  std::map<std::string, size_t> numbers_;
};

// Returns the candidates without duplicates, such as more layers than a ray hits, or options without effect.
std::vector<Considered> distinct_candidates(Session& session, const RenderOptions& options) {
  std::vector<Considered> list;
  std::set<std::string> known;
  Numbers drawings, shadows, kinds;
  for (const lab::CandidateConfiguration& c :
       lab::candidate_configurations(sweep_scene(session, options), options.given)) {
    std::optional<RenderOptions> candidate = resolved(options, c.configuration);
    if (!candidate) continue;
    const std::string used = scenes::json_text(used_config(*candidate, session.plan(*candidate).run));
    if (!known.insert(used).second) continue;
    const std::string kind = fmt::format("{} {}", static_cast<int>(candidate->translucency()),
                                         sideray_options_get(candidate->named.get(), "shadows"));
    list.push_back({c.configuration,
                    std::move(*candidate),
                    {drawings.of(c.drawing), shadows.of(c.shadows), kinds.of(kind), {}, {}, {}}});
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

[[noreturn]] void fail_to_hold(const Choice& choice, const lab::CostBounds& bounds) {
  throw Error(SIDERAY_UNSUPPORTED,
              fmt::format("{}: none of {} configurations holds it, the nearest is {}; raise the bound, or leave more "
                          "options open",
                          bounds_text(bounds), choice.considered.size(), describe(choice, choice.chosen())));
}

std::string times(size_t count) {
  return count == 1 ? "once" : count == 2 ? "twice" : fmt::format("{} times", count);
}

double predicted_ms(Session& session, Calibration& calibration, const RenderOptions& options) {
  const Session::Planned planned = session.plan(options);
  return predict(calibration.probe(options), options, *sideray_plan_most_work(planned.plan.get())).ms();
}

}  // namespace

Choice choose(Session& session, Calibration& calibration, const RenderOptions& options) {
  Choice choice;
  choice.considered = distinct_candidates(session, options);
  std::vector<lab::Candidate> costs;
  for (const Considered& c : choice.considered) costs.push_back(c.cost);
  lab::Pick pick = lab::next_pick(costs, options.bounds);
  Progress progress(costs.size());
  for (; pick.step != lab::PickStep::picked && pick.step != lab::PickStep::failed;
       pick = lab::next_pick(costs, options.bounds)) {
    const RenderOptions& candidate = choice.considered[pick.candidate].options;
    lab::Candidate& cost = costs[pick.candidate];
    progress.next(lab::describe(choice.considered[pick.candidate].configuration));
    if (pick.step == lab::PickStep::look)
      cost.look = calibration.look(candidate);
    else if (pick.step == lab::PickStep::time)
      cost.ms = predicted_ms(session, calibration, candidate);
    else
      cost.drawn_ms = calibration.drawn_ms(candidate, *cost.ms);
  }
  for (size_t i = 0; i < costs.size(); ++i) choice.considered[i].cost = costs[i];
  choice.picked = pick.candidate;
  choice.correction = lab::correction(costs, options.bounds);
  if (pick.step == lab::PickStep::failed) fail_to_hold(choice, options.bounds);
  return choice;
}

RenderOptions with_choice(Session& session, const RenderOptions& options) {
  if (!options.bounds.any()) return options;
  Calibration calibration(session, options);
  const Choice choice = choose(session, calibration, options);
  const size_t corrections = choice.correction.count;
  print_note(fmt::format("{}: chose {}{}", bounds_text(options.bounds), describe(choice, choice.chosen()),
                         corrections ? fmt::format("; chosen anew {}", times(corrections)) : ""));
  session.move_to(options);
  RenderOptions chosen = choice.chosen().options;
  chosen.choice = summary(choice);
  return chosen;
}

ChoiceSummary summary(const Choice& choice) {
  const Considered& chosen = choice.chosen();
  return {choice.foretold_ms(chosen), chosen.cost.drawn_ms, chosen.error(), choice.correction.count,
          choice.correction.scale};
}

std::optional<double> Choice::foretold_ms(const Considered& c) const {
  if (!c.cost.ms) return {};
  return *c.cost.ms * correction.scale;
}

std::string describe(const Choice& choice, const Considered& considered) {
  std::string text = lab::describe(considered.configuration);
  const std::optional<double> ms = choice.foretold_ms(considered);
  if (ms) text += fmt::format(", predicted {:.1f} ms", *ms);
  if (considered.cost.drawn_ms) text += fmt::format(", measured {:.1f} ms", *considered.cost.drawn_ms);
  if (const std::optional<double> error = considered.error()) text += fmt::format(", error {:.4f}", *error);
  return text;
}

}  // namespace sideray::cli
