#include "plan.h"

#include <algorithm>
#include <memory>

#include "failure.h"
#include "session.h"
#include "used_config.h"

namespace sideray::cli {
namespace {

using Json = nlohmann::ordered_json;

struct Release {
  void operator()(sideray_plan* plan) const { sideray_plan_release(plan); }
};
using Plan = std::unique_ptr<sideray_plan, Release>;

// Files, and ways of running: a plan writes nothing and runs nothing.
bool is_foreign(const std::string& name) {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list{"o", "stats", "check", "repeat", "jobs", "shard", "resume", "warm-up", "compare"};
    for (const Option& option : comparison_options()) list.push_back(option.name);
    return list;
  }();
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::vector<Option> table() {
  std::vector<Option> t;
  for (const Option& option : render_table())
    if (!is_foreign(option.name)) t.push_back(option);
  t.push_back({"json", Option::Kind::flag, "", {}, {}, "", true, false, "print JSON"});
  return t;
}

RenderOptions resolve(const std::string& scene, Given given) {
  check_given(plan_table(), given);
  if (scene.empty()) wrong_usage("plan: no scene; give a .gltf or .glb file or a built-in name (sideray make --list)");
  given.erase("json");
  given["o"] = given.contains("frames") ? "plan.#.exr" : "plan.exr";  // never written
  RenderOptions options = resolve_render(scene, given);
  options.options.continues = options.frames.has_value();  // all frames but the first
  return options;
}

std::vector<sideray_plan_pass> passes_of(const sideray_plan& plan) {
  std::vector<sideray_plan_pass> passes;
  for (size_t i = 0; i < sideray_plan_pass_count(&plan); ++i) passes.push_back(sideray_plan_pass_at(&plan, i));
  return passes;
}

std::vector<sideray_plan_texture> textures_of(const sideray_plan& plan) {
  std::vector<sideray_plan_texture> textures;
  for (size_t i = 0; i < sideray_plan_texture_count(&plan); ++i) textures.push_back(sideray_plan_texture_at(&plan, i));
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
  return sum({w.rays_primary, w.rays_reflection, w.rays_shadow, w.rays_ao});
}

uint64_t bytes_of(const sideray_plan_work& w) {
  return sum({w.bytes_readback, w.bytes_upload, w.bytes_cache});
}

Json plan_json(const sideray_plan& plan, const RenderOptions& options, const RenderRun& run) {
  Json json = {{"schema", 1}, {"config", used_config(options, run)}};
  json["passes"] = Json::array();
  for (const sideray_plan_pass& pass : passes_of(plan))
    json["passes"].push_back({{"name", stage_name(pass.stage)}, {"runs", pass.runs != 0}, {"reason", pass.reason}});
  json["textures"] = Json::array();
  for (const sideray_plan_texture& t : textures_of(plan))
    json["textures"].push_back({{"name", t.name},
                                {"format", t.format},
                                {"width", t.width},
                                {"height", t.height},
                                {"layers", t.layers},
                                {"bytes", t.bytes}});
  json["predicted"] = Json::object();
  const sideray_plan_work work = sideray_plan_most_work(&plan);
  const auto add = [&](const char* name, uint64_t most) {
    if (most != SIDERAY_UNBOUNDED) json["predicted"][name] = most;
  };
  add("rays", rays_of(work));
  add("fragments", work.fragments);
  add("bytes", bytes_of(work));
  return json;
}

std::string at_most(uint64_t most) {
  return most == SIDERAY_UNBOUNDED ? "unbounded" : fmt::format("{}", most);
}

void print_passes(const sideray_plan& plan, bool running) {
  fmt::print("{}\n", running ? "runs" : "left out");
  for (const sideray_plan_pass& pass : passes_of(plan))
    if ((pass.runs != 0) == running) fmt::print("  {:<13} {}\n", stage_name(pass.stage), pass.reason);
}

void print_text(const sideray_plan& plan) {
  print_passes(plan, true);
  print_passes(plan, false);
  fmt::print("textures\n");
  for (const sideray_plan_texture& t : textures_of(plan))
    fmt::print("  {:<24} {:<18} {:>5}x{}x{} {:>12} bytes\n", t.name, t.format, t.width, t.height, t.layers, t.bytes);
  const sideray_plan_work w = sideray_plan_most_work(&plan);
  fmt::print("a frame, at most\n");
  fmt::print("  rays      {} (primary {}, reflection {}, shadow {}, ao {})\n", at_most(rays_of(w)),
             at_most(w.rays_primary), at_most(w.rays_reflection), at_most(w.rays_shadow), at_most(w.rays_ao));
  fmt::print("  fragments {}\n", at_most(w.fragments));
  fmt::print("  bytes     {} (readback {}, upload {}, cache {})\n", at_most(bytes_of(w)), w.bytes_readback,
             w.bytes_upload, w.bytes_cache);
}

}  // namespace

const std::vector<Option>& plan_table() {
  static const std::vector<Option> options = table();
  return options;
}

int plan(const std::string& scene, const Given& given) {
  const RenderOptions options = resolve(scene, given);
  Session session(options);
  const Session::Planned planned = session.plan(options);
  const Plan owner(planned.plan);
  if (given.contains("json"))
    fmt::print("{}\n", plan_json(*owner, options, planned.run).dump(2));
  else
    print_text(*owner);
  return exit_ok;
}

}  // namespace sideray::cli
