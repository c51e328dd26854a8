#include "cli/commands.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <sideray/sideray.hpp>
#include <utility>
#include <vector>

#include "cli/base/failure.h"
#include "cli/base/outputs.h"
#include "cli/bench/bench.h"
#include "cli/chart/chart.h"
#include "cli/chart/chart_options.h"
#include "cli/gather/gather.h"
#include "cli/golden/golden.h"
#include "cli/options/comparison.h"
#include "cli/plan/plan.h"
#include "cli/render/render.h"
#include "cli/run/run.h"
#include "cli/stress/stress.h"
#include "cli/view/view.h"
#include "scenes/builtin/builtin.h"

namespace sideray::cli {
namespace {

struct RenderArguments {
  std::string scene;
  Given given;
};

struct BenchArguments {
  std::string scene;
  Given given;
};

struct ChartArguments {
  std::string scene;
  Given given;
};

struct StressArguments {
  std::vector<std::string> names;
  Given given;
};

struct PlanArguments {
  std::string scene;
  Given given;
};

struct CompareArguments {
  std::string test, reference;
  Given given;
};

struct InfoArguments {
  std::string scene;
  bool json = false;
};

struct MakeArguments {
  std::string name, output;
  std::vector<std::string> settings;
  bool list = false;
};

int run_render(const RenderArguments& arguments) {
  const auto jobs = arguments.given.find("jobs");
  if (jobs == arguments.given.end()) return render(resolve_render(arguments.scene, arguments.given));
  Given defaults = arguments.given;
  defaults.erase("jobs");
  if (!arguments.scene.empty()) defaults["scene"] = arguments.scene;
  return render_jobs(jobs->second, defaults);
}

int run_compare(const CompareArguments& arguments) {
  const ComparisonOptions options = resolve_comparison(arguments.given);
  require_distinct({{"--map", options.map}}, {{"TEST", arguments.test}, {"REFERENCE", arguments.reference}});
  if (!options.map.empty()) require_writable(options.map);
  return run_comparison(arguments.test, arguments.reference, options, {});
}

scenes::Content load(const std::string& scene) {
  try {
    return scenes::load(scene);
  } catch (const scenes::UnknownScene& error) {
    throw UsageError(error.what());
  }
}

int run_info(const InfoArguments& arguments) {
  const scenes::Content content = load(arguments.scene);
  const std::string text = arguments.json ? scenes::info_json(content) : scenes::info_text(content);
  fmt::print("{}{}", text, text.ends_with('\n') ? "" : "\n");
  return exit_ok;
}

void list_built_ins() {
  for (const scenes::Builtin& scene : scenes::builtins()) {
    fmt::print("{:<10} {}\n", scene.name, scene.description);
    for (const scenes::Parameter& p : scene.parameters)
      fmt::print("  {:<10} {} [{}]\n", p.name, p.meaning, p.default_value);
  }
}

scenes::Settings parse_settings(const std::vector<std::string>& assignments) {
  scenes::Settings settings;
  for (const std::string& assignment : assignments) {
    const size_t equals = assignment.find('=');
    if (equals == 0 || equals == std::string::npos)
      wrong_usage("--set: \"{}\" is not K=V; write for example --set count=8", assignment);
    if (!settings.emplace(assignment.substr(0, equals), assignment.substr(equals + 1)).second)
      wrong_usage("--set: {} is given twice; remove one", assignment.substr(0, equals));
  }
  return settings;
}

scenes::Content generate(const MakeArguments& arguments) {
  try {
    return scenes::generate(arguments.name, parse_settings(arguments.settings));
  } catch (const Error& error) {
    throw UsageError(error.what());
  }
}

int run_make(const MakeArguments& arguments) {
  if (arguments.list) {
    list_built_ins();
    return exit_ok;
  }
  if (arguments.name.empty()) wrong_usage("make: no scene; give a name from sideray make --list");
  if (arguments.output.empty()) wrong_usage("make: no output; give -o FILE.glb");
  require_extension("-o", arguments.output, {".glb"});
  const scenes::Content content = generate(arguments);
  require_writable(arguments.output);
  scenes::write_glb(arguments.output, content);
  return exit_ok;
}

struct FreeDevices {
  void operator()(sideray_device_list* list) const { sideray_devices_free(list); }
};
using DeviceList = std::unique_ptr<sideray_device_list, FreeDevices>;

DeviceList devices() {
  sideray_device_list* list = nullptr;
  check([&](sideray_error* error) { return sideray_devices(&list, error); });
  return DeviceList(list);
}

// Returns the table of every command that has one, in the order of the help.
std::vector<std::pair<const char*, const Table*>> tables() {
  return {{"render", &render_table()}, {"bench", &bench_table()},   {"chart", &chart_table()},
          {"stress", &stress_table()}, {"plan", &plan_table()},     {"view", &view_table()}, {"compare", &comparison_table()},
          {"golden record", &golden_record_table()}, {"golden check", &golden_check_table()}};
}

nlohmann::ordered_json described(const sideray_option& row) {
  constexpr const char* costs[] = {"none", "picture", "trade"};
  const bool is_number = row.type == SIDERAY_OPTION_INTEGER || row.type == SIDERAY_OPTION_NUMBER ||
                         row.type == SIDERAY_OPTION_SIZE;
  nlohmann::ordered_json entry = {{"name", row.name},      {"values", values_of(row)},     {"help", row.help},
                                  {"group", row.group},    {"default", row.default_value}, {"applies", row.applies},
                                  {"exact", row.exact_value}, {"cost", costs[row.cost]},
                                  {"advanced", row.advanced != 0}, {"diagnostic", row.diagnostic != 0}};
  if (is_number) entry["range"] = {row.minimum, row.maximum};
  return entry;
}

int run_options(bool as_json) {
  nlohmann::ordered_json all;
  for (const auto& [command, table] : tables()) {
    nlohmann::ordered_json& list = all[command] = nlohmann::ordered_json::array();
    if (!as_json) fmt::print("sideray {}\n", command);
    for (const sideray_option* row : *table)
      if (as_json)
        list.push_back(described(*row));
      else
        fmt::print("  {:<36} {}\n", dashed(row->name, values_of(*row)), row->help);
  }
  if (as_json) fmt::print("{}\n", all.dump(2));
  return exit_ok;
}

int run_devices(bool as_json) {
  const DeviceList found = devices();
  const size_t count = sideray_device_count(found.get());
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (size_t i = 0; i < count; ++i) {
    const sideray_device_info& d = *sideray_device_at(found.get(), i);
    if (!as_json) {
      fmt::print("{}\n  {}: {}\n", d.id, d.usable ? "usable" : "cannot be used",
                 d.usable ? fmt::format("{}, OpenGL {}", d.renderer, d.version) : std::string(d.reason));
      continue;
    }
    nlohmann::ordered_json entry = {{"id", d.id}, {"gl", d.gl}};
    if (d.renderer && *d.renderer) entry["renderer"] = d.renderer;
    if (d.version && *d.version) entry["version"] = d.version;
    entry["usable"] = d.usable != 0;
    entry["reason"] = d.reason ? d.reason : "";
    list.push_back(std::move(entry));
  }
  // Rays alone are always listed, since they need no device.
  list.push_back({{"id", "none"}, {"gl", "none"}, {"renderer", "rays alone"}, {"usable", true}, {"reason", ""}});
  fmt::print("{}\n", as_json ? list.dump(2) : std::string("none\n  usable: rays alone draw by --gl none"));
  return exit_ok;
}

}  // namespace

// Each command's Run owns its arguments: they are filled while the program parses, after these functions returned.

Command add_render(CLI::App& program) {
  auto arguments = std::make_shared<RenderArguments>();
  CLI::App* app = program.add_subcommand("render", "draws one frame to .exr or .png");
  app->add_option("SCENE", arguments->scene, "a .gltf or .glb file, or a built-in scene");
  add_options(*app, render_table(), arguments->given);
  return {app, [arguments] { return run_render(*arguments); }};
}

Command add_bench(CLI::App& program) {
  auto arguments = std::make_shared<BenchArguments>();
  CLI::App* app = program.add_subcommand("bench", "times the stages of a picture");
  app->add_option("SCENE", arguments->scene, "a .gltf or .glb file, or a built-in scene");
  add_options(*app, bench_table(), arguments->given);
  return {app, [arguments] { return bench(arguments->scene, arguments->given); }};
}

Command add_chart(CLI::App& program) {
  auto arguments = std::make_shared<ChartArguments>();
  CLI::App* app = program.add_subcommand("chart", "measures speed against error over many configurations");
  app->add_option("SCENE", arguments->scene, "a .gltf or .glb file, or a built-in scene");
  add_options(*app, chart_table(), arguments->given);
  return {app, [arguments] { return chart(arguments->scene, arguments->given); }};
}

Command add_stress(CLI::App& program) {
  auto arguments = std::make_shared<StressArguments>();
  CLI::App* app = program.add_subcommand("stress", "sweeps to where methods fail, against closed forms");
  app->add_option("NAME", arguments->names, "the cases to run; without a name all of them (--list)");
  add_options(*app, stress_table(), arguments->given);
  return {app, [arguments] { return stress(arguments->names, arguments->given); }};
}

Command add_plan(CLI::App& program) {
  auto arguments = std::make_shared<PlanArguments>();
  CLI::App* app = program.add_subcommand("plan", "says what a frame does, what it leaves out, and why");
  app->add_option("SCENE", arguments->scene, "a .gltf or .glb file, or a built-in scene");
  add_options(*app, plan_table(), arguments->given);
  return {app, [arguments] { return plan(arguments->scene, arguments->given); }};
}

Command add_view(CLI::App& program) {
  struct Arguments {
    std::string scene;
    Given given;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* app = program.add_subcommand("view", "shows a scene in a window, and how ways of drawing it differ");
  app->add_option("SCENE", arguments->scene, "a .gltf or .glb file, or a built-in scene");
  add_options(*app, view_table(), arguments->given);
  return {app, [arguments] { return view(arguments->scene, arguments->given); }};
}

Command add_run(CLI::App& program) {
  auto arguments = std::make_shared<RunArguments>();
  CLI::App* app = program.add_subcommand("run", "gives an unmodified OpenGL program ray-traced glass, water and mirrors");
  app->add_option("--rules", arguments->rules, "what textures and meshes are taken for (docs/run.md)")->type_name("FILE");
  app->add_option("--report", arguments->report, "writes what was met and what it was taken for")->type_name("PAGE.html");
  app->add_option("--capture", arguments->capture, "writes the scene of a frame with rays")->type_name("FILE.glb");
  app->add_option("--pictures", arguments->pictures, "writes frames without and with rays into a folder")->type_name("DIR");
  app->add_flag("--late", arguments->late, "waits for no rays: shows those of an earlier frame");
  app->add_flag("--off", arguments->off, "looks on alone: the program's own picture");
  app->add_option("PROGRAM", arguments->words, "behind --, with its arguments");
  return {app, [arguments] { return run_program(*arguments); }};
}

Command add_compare(CLI::App& program) {
  auto arguments = std::make_shared<CompareArguments>();
  CLI::App* app = program.add_subcommand("compare", "prints metrics between two images");
  app->add_option("TEST", arguments->test, ".png, .exr or .hdr")->required();
  app->add_option("REFERENCE", arguments->reference, "what it should be")->required();
  add_options(*app, comparison_table(), arguments->given);
  return {app, [arguments] { return run_compare(*arguments); }};
}

Command add_info(CLI::App& program) {
  auto arguments = std::make_shared<InfoArguments>();
  CLI::App* app = program.add_subcommand("info", "says what is in a scene, and what is defaulted");
  app->add_option("SCENE", arguments->scene, "a .gltf or .glb file, or a built-in scene")->required();
  app->add_flag("--json", arguments->json, "prints JSON");
  return {app, [arguments] { return run_info(*arguments); }};
}

Command add_make(CLI::App& program) {
  auto arguments = std::make_shared<MakeArguments>();
  CLI::App* app = program.add_subcommand("make", "writes a built-in scene as glTF");
  app->add_option("NAME", arguments->name, "the scene");
  app->add_option("-o", arguments->output, "the file to write")->type_name("FILE.glb");
  app->add_option("--set", arguments->settings, "a parameter; may be repeated")
      ->type_name("K=V")
      ->allow_extra_args(false);
  app->add_flag("--list", arguments->list, "the scenes and their parameters");
  return {app, [arguments] { return run_make(*arguments); }};
}

Command add_status(CLI::App& program) {
  struct Arguments {
    std::string folder;
    bool json = false;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* app = program.add_subcommand("status", "says what is done and missing of a run with --shard auto");
  app->add_option("DIR", arguments->folder, "the folder of the run")->required();
  app->add_flag("--json", arguments->json, "prints JSON");
  return {app, [arguments] { return status(arguments->folder, arguments->json); }};
}

Command add_gather(CLI::App& program) {
  auto folder = std::make_shared<std::string>();
  CLI::App* app = program.add_subcommand("gather", "checks and puts together a run with --shard auto");
  app->add_option("DIR", *folder, "the folder of the run")->required();
  return {app, [folder] { return gather(*folder); }};
}

Command add_golden(CLI::App& program) {
  struct Arguments {
    std::string folder;
    Given given;
    std::vector<std::string> names;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* app = program.add_subcommand("golden", "keeps reference pictures of jobs, and says what changed since");
  app->require_subcommand(1);
  const auto add = [&](const char* name, const char* help) {
    CLI::App* command = app->add_subcommand(name, help);
    command->add_option("DIR", arguments->folder, "the folder of the references")->required();
    return command;
  };
  CLI::App* record = add("record", "draws every job and keeps its pictures as references");
  add_options(*record, golden_record_table(), arguments->given);
  CLI::App* check = add("check", "draws again, and says what differs; exit code 3 where something does");
  add_options(*check, golden_check_table(), arguments->given);
  CLI::App* approve = add("approve", "makes pictures of the last check the references");
  approve->add_option("NAME", arguments->names, "the pictures; without a name all that differed");
  return {app, [arguments, record, check] {
            if (record->parsed()) return golden_record(arguments->folder, arguments->given);
            if (check->parsed()) return golden_check(arguments->folder, arguments->given);
            return golden_approve(arguments->folder, arguments->names);
          }};
}

Command add_devices(CLI::App& program) {
  auto json = std::make_shared<bool>(false);
  CLI::App* app = program.add_subcommand("devices", "lists OpenGL devices that can be used, and says why others cannot");
  app->add_flag("--json", *json, "prints JSON");
  return {app, [json] { return run_devices(*json); }};
}

Command add_option_list(CLI::App& program) {
  auto json = std::make_shared<bool>(false);
  CLI::App* app = program.add_subcommand("options", "lists the options of every command, with ranges and defaults");
  app->add_flag("--json", *json, "prints JSON");
  return {app, [json] { return run_options(*json); }};
}

}  // namespace sideray::cli
