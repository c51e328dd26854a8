#include "cli/plan/plan_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "cli/session/stats.h"
#include "cli/session/used_config.h"

namespace sideray::cli {
namespace {

using Json = nlohmann::ordered_json;

std::vector<sideray_plan_pass> passes_of(const sideray_plan& plan) {
  std::vector<sideray_plan_pass> passes;
  for (size_t i = 0; i < sideray_plan_pass_count(&plan); ++i) passes.push_back(*sideray_plan_pass_at(&plan, i));
  return passes;
}

std::vector<sideray_plan_texture> textures_of(const sideray_plan& plan) {
  std::vector<sideray_plan_texture> textures;
  for (size_t i = 0; i < sideray_plan_texture_count(&plan); ++i) textures.push_back(*sideray_plan_texture_at(&plan, i));
  return textures;
}

uint64_t sum(std::initializer_list<uint64_t> terms) {
  uint64_t total = 0;
  for (const uint64_t term : terms) {
    if (term == SIDERAY_UNBOUNDED) return SIDERAY_UNBOUNDED;
    total += term;
  }
  return total;
}

uint64_t rays_of(const sideray_plan_work& w) {
  return sum({w.rays_primary, w.rays_reflection, w.rays_shadow, w.rays_ao, w.rays_bounce});
}

uint64_t bytes_of(const sideray_plan_work& w) {
  return sum({w.bytes_readback, w.bytes_upload, w.bytes_cache});
}

Json bounds_json(const sideray_plan_work& most) {
  Json json = Json::object();
  const auto add = [&](const char* name, uint64_t count) {
    if (count != SIDERAY_UNBOUNDED) json[name] = count;
  };
  add("rays", rays_of(most));
  add("fragments", most.fragments);
  add("bytes", bytes_of(most));
  return json;
}

// Returns the predicted part. Without a prediction, only values whose upper bound is 0 are known.
Json predicted_json(const PlanReport& report, const Json& bounds) {
  Json json = Json::object();
  if (!report.predicted) {
    for (const auto& [name, most] : bounds.items())
      if (most == 0) json[name] = 0;
    return json;
  }
  const lab::FrameCost& cost = *report.predicted;
  json = bounds_json(cost.work);
  json["ms"] = cost.ms();
  if (report.choice && report.choice->chosen().error()) json["error"] = *report.choice->chosen().error();
  for (const sideray_plan_pass& pass : passes_of(*report.planned.plan))
    json["stages_ms"][pass.name] = cost.stage_ms[pass.stage];
  json["stages_ms"]["total_frame"] = cost.ms();
  return json;
}

Json candidates_json(const Choice& choice) {
  Json list = Json::array();
  for (size_t i = 0; i < choice.considered.size(); ++i) {
    const Considered& c = choice.considered[i];
    Json entry = {{"config", Json(c.configuration)}};
    if (const std::optional<double> ms = choice.foretold_ms(c)) entry["ms"] = *ms;
    if (c.cost.drawn_ms) entry["measured_ms"] = *c.cost.drawn_ms;
    if (const std::optional<double> error = c.error()) entry["error"] = *error;
    entry["picked"] = i == choice.picked;
    list.push_back(entry);
  }
  return list;
}

std::string at_most(uint64_t most) {
  return most == SIDERAY_UNBOUNDED ? "unbounded" : fmt::format("{}", most);
}

void print_passes(const sideray_plan& plan, bool running) {
  fmt::print("{}\n", running ? "runs" : "left out");
  for (const sideray_plan_pass& pass : passes_of(plan))
    if ((pass.runs != 0) == running) fmt::print("  {:<13} {}\n", pass.name, pass.reason);
}

void print_work(const sideray_plan_work& w) {
  fmt::print("  rays      {} (primary {}, reflection {}, shadow {}, ao {}, bounce {})\n", at_most(rays_of(w)),
             at_most(w.rays_primary), at_most(w.rays_reflection), at_most(w.rays_shadow), at_most(w.rays_ao),
             at_most(w.rays_bounce));
  fmt::print("  fragments {}\n", at_most(w.fragments));
  fmt::print("  bytes     {} (readback {}, upload {}, cache {})\n", at_most(bytes_of(w)), at_most(w.bytes_readback),
             at_most(w.bytes_upload), at_most(w.bytes_cache));
}

void print_predicted(const sideray_plan& plan, const lab::FrameCost& cost) {
  fmt::print("a frame, predicted\n");
  print_work(cost.work);
  std::vector<std::string> stages;
  for (const sideray_plan_pass& pass : passes_of(plan))
    if (cost.stage_ms[pass.stage] > 0) stages.push_back(fmt::format("{} {:.2f}", pass.name, cost.stage_ms[pass.stage]));
  fmt::print("  ms        {:.2f} (alone: {})\n", cost.ms(), fmt::join(stages, ", "));
}

std::string number(std::optional<double> value, int digits) {
  return value ? fmt::format("{:.{}f}", *value, digits) : "-";
}

void print_choice(const Choice& choice) {
  fmt::print("configurations\n  {:>9} {:>9} {:>9}\n", "ms", "measured", "error");
  for (size_t i = 0; i < choice.considered.size(); ++i) {
    const Considered& c = choice.considered[i];
    fmt::print("{} {:>9} {:>9} {:>9}  {}\n", i == choice.picked ? "*" : " ", number(choice.foretold_ms(c), 2),
               number(c.cost.drawn_ms, 2), number(c.error(), 5), lab::describe(c.configuration));
  }
  if (choice.correction.count > 0)
    fmt::print("  {} of them missed the bound when drawn whole: times are {:.3f} of what reduced frames say\n",
               choice.correction.count, choice.correction.scale);
}

}  // namespace

Json plan_json(const PlanReport& report) {
  const sideray_plan& plan = *report.planned.plan;
  Json json = {{"schema", 1}, {"config", used_config(report.options, report.planned.run)}};
  json["passes"] = Json::array();
  for (const sideray_plan_pass& pass : passes_of(plan))
    json["passes"].push_back({{"name", pass.name}, {"runs", pass.runs != 0}, {"reason", pass.reason}});
  json["textures"] = Json::array();
  for (const sideray_plan_texture& t : textures_of(plan))
    json["textures"].push_back({{"name", t.name},
                                {"format", t.format},
                                {"width", t.width},
                                {"height", t.height},
                                {"layers", t.layers},
                                {"bytes", t.bytes}});
  const Json bounds = bounds_json(*sideray_plan_most_work(&plan));
  json["predicted"] = predicted_json(report, bounds);
  json["bounds"] = bounds;
  if (report.choice) json["choice"] = choice_json(summary(*report.choice));
  if (report.choice) json["candidates"] = candidates_json(*report.choice);
  return json;
}

void print_plan(const PlanReport& report) {
  const sideray_plan& plan = *report.planned.plan;
  if (report.options.named.reads("quality")) fmt::print("quality {}\n", report.options.named["quality"]);
  if (report.choice) print_choice(*report.choice);
  print_passes(plan, true);
  print_passes(plan, false);
  fmt::print("textures\n");
  for (const sideray_plan_texture& t : textures_of(plan))
    fmt::print("  {:<24} {:<18} {:>5}x{}x{} {:>12} bytes\n", t.name, t.format, t.width, t.height, t.layers, t.bytes);
  if (report.predicted) print_predicted(plan, *report.predicted);
  fmt::print("a frame, at most\n");
  print_work(*sideray_plan_most_work(&plan));
}

}  // namespace sideray::cli
