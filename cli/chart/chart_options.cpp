#include "cli/chart/chart_options.h"

#include <algorithm>

#include "cli/base/failure.h"
#include "cli/options/comparison.h"
#include "cli/options/configuration_files.h"
#include "cli/options/own_options.h"
#include "lab/metrics/temporal.h"

namespace sideray::cli {
namespace {

using Names = std::vector<std::string>;

bool contains(const Names& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

// Returns whether an option says how light travels. Given for the whole chart, the reference takes it; rows may differ.
bool is_transport(const std::string& name) {
  return name == "reflections" || name == "refraction" || name == "bounces";
}

// Returns whether an option has no place in a chart, which names its own files and makes its own reference.
bool is_foreign(const std::string& name) {
  const OwnOption* own = find_own(name);
  return own ? !own->in_chart : name == "reference";
}

Table table() {
  static const sideray_option rows[] = {
      text_row("o", "DIR", "", "the folder to write"),
      text_row("sweep", "translucency|shadows|all|FILE.json", "translucency",
               "a list that fits the scene, or a file with an array of {option: value}"),
      text_row("repeat", "N", "", "how many rounds time every configuration once [5; of a sequence 1]"),
      text_row("metric", "NAME", "flip", "the error that the Pareto flags go by"),
      flag_row("ledger", "splits the error over the shortcuts that are taken"),
      flag_row("resume", "keeps what an earlier run measured"),
      text_row("shard", "I/N|auto[/N]", "", "only the configurations whose index modulo N is I; auto: as the scheduler says")};
  Table t;
  for (const sideray_option& row : rows) t.push_back(&row);
  for (const sideray_option* option : render_table())
    if (!is_foreign(option->name)) t.push_back(option);
  return t;
}

// Returns whether only the reference takes an option. Pictures with other positions in the pixel differ at edges, so
// `samples` is for all, except in a sequence, whose rows average as many positions over time.
bool is_of_reference(const ChartOptions& options, const std::string& name) {
  return options.frames && name == "samples";
}

// Returns whether the reference and all rows share an option, so that their pictures can be compared.
bool is_common(const ChartOptions& options, const std::string& name) {
  const OwnOption* own = find_own(name);
  return (own && own->in_chart) || name == "size" || (name == "samples" && !options.frames);
}

// Returns the options for the whole chart that `keep` accepts.
template <typename Keep>
Given chosen(const ChartOptions& options, const Keep& keep) {
  Given given;
  for (const auto& [name, text] : options.given)
    if (keep(name)) given[name] = text;
  return given;
}

bool is_render_option(const std::string& name) {
  return find(render_table(), name) != nullptr;
}

// Returns the library's options by name, without checking contradictions.
Options named_options(const Given& given, const std::string& name) {
  Options named = Options::create().value();
  for (const auto& [option, text] : given)
    if (sideray_option_find(option.c_str())) {
      try {
        named.set(option, text);
      } catch (const Error& error) {
        wrong_usage("{}: --{}", name, error.what());
      }
    }
  return named;
}

// Returns another seed, the same one for equal seeds.
std::string seed_beside(const std::string& seed) {
  constexpr uint32_t golden_ratio = 0x9e3779b9u;
  return std::to_string(whole_number("seed", seed, 0, UINT32_MAX) ^ golden_ratio);
}

std::optional<lab::Sweep> built_in_sweep(const std::string& name) {
  if (name == "translucency") return lab::Sweep::translucency;
  if (name == "shadows") return lab::Sweep::shadows;
  if (name == "all") return lab::Sweep::all;
  return std::nullopt;
}

RenderOptions resolved(const ChartOptions& options, Given given, const std::string& image) {
  given["o"] = image;
  return resolve_render(options.scene, given);
}

// Reads the frames without --shard and --warm-up: the former has another meaning here, the latter none.
void set_frames(const Given& given, ChartOptions& options) {
  Given range;
  for (const char* name : {"frames", "fps", "time"})
    if (given.contains(name)) range[name] = given.at(name);
  options.frames = frame_range(range);
  if (options.frames && options.frames->count() < 2)
    wrong_usage("--frames: {} is a single picture; give at least two frames, or --time", given.at("frames"));
}

void set_metric(const std::string& name, ChartOptions& options) {
  const Names& temporal = lab::temporal_names();
  if (!contains(temporal, name)) {
    options.metric = resolve_comparison({{"metric", name}}).bound.metric;
    return;
  }
  if (!options.frames) wrong_usage("--metric {}: shows in a sequence alone; give --frames A-B too", name);
  options.metric = name;
}

}  // namespace

const Table& chart_table() {
  static const Table options = table();
  return options;
}

ChartOptions resolve_chart(const std::string& scene, const Given& given) {
  check_given(chart_table(), given);
  if (scene.empty()) wrong_usage("chart: no scene; give a .gltf or .glb file or a built-in name (sideray make --list)");
  ChartOptions options;
  options.given = given;
  options.scene = scene;
  const auto text = [&](const char* name) { return text_of(chart_table(), given, name); };
  options.folder = text("o");
  if (options.folder.empty()) wrong_usage("chart: no output; give -o DIR");
  options.sweep = text("sweep");
  options.built_in = built_in_sweep(options.sweep);
  set_frames(given, options);
  const std::string repeats = text("repeat");
  options.repeats = repeats.empty() ? (options.frames ? 1 : 5) : whole_number("repeat", repeats, 1, 10000);
  options.resume = given.contains("resume");
  options.ledger = given.contains("ledger");
  if (given.contains("shard")) options.shard = parse_shard(given.at("shard"));
  if (options.shard.is_recorded()) options.resume = true;  // tasks may be restarted
  if (options.ledger && options.shard.is_recorded())
    wrong_usage("--ledger: is the work of one machine; give it with --resume and without --shard once all rows are there");
  if (options.frames && options.ledger)
    wrong_usage("--ledger: splits the error of a single picture; leave --frames out");
  set_metric(text("metric"), options);
  const std::string image = options.frames ? "reference.#.exr" : "reference.exr";  // never written
  const RenderOptions picture = resolve_reference(options, image);
  if (options.metric == "ssim" && (picture.width() < 11 || picture.height() < 11))
    wrong_usage("--metric ssim: needs 11x11 pixels; raise --size or choose another metric");
  return options;
}

RenderOptions resolve_row(const ChartOptions& options, const lab::Configuration& configuration, const std::string& name,
                          const std::string& image) {
  for (const auto& [option, text] : configuration) {
    if (is_common(options, option) || option == "repeat")
      wrong_usage("{}: --{} is the same for the whole chart; give it on the command line", name, option);
    if (option != "reference" && is_foreign(option))
      wrong_usage("{}: --{} has no place in a chart; remove it", name, option);
  }
  Given given = given_of(configuration, name);
  given.merge(chosen(options, [&](const std::string& option) {
    return is_render_option(option) && !is_foreign(option) && !is_of_reference(options, option);
  }));
  // A reference of one bounce has no ambient occlusion, and its opaque surfaces reflect only the environment: options
  // that approximate bounced light would count as an error.
  const bool bounces = options.given.contains("bounces") && options.given.at("bounces") != "1";
  for (const char* option : {"ambient", "reflections"})
    if (!bounces && (!given.contains(option) || given.at(option) == "auto")) given[option] = "off";
  // These options may be meant for the reference or other rows: keeps them only in rows that read them.
  const Options named = named_options(given, name);
  for (const char* option : {"light-samples", "bounces", "caustics", "check"})
    if (!named.reads(option) && !configuration.contains(option)) given.erase(option);
  // An exact row needs random numbers of its own: with the reference's it would have the same noise, and no error.
  const bool is_exact = named["translucency"] == "reference";
  if (is_exact && !configuration.contains("seed")) given["seed"] = seed_beside(named["seed"]);
  try {
    return resolved(options, std::move(given), image);
  } catch (const UsageError& error) {
    wrong_usage("{}: {}", name, error.what());
  }
}

RenderOptions resolve_reference(const ChartOptions& options, const std::string& image) {
  Given given = chosen(options, [&](const std::string& option) {
    return is_common(options, option) || is_of_reference(options, option) || is_transport(option) ||
           option == "light-samples" || option == "seed";
  });
  given["reference"] = "true";
  // The reference averages as many positions as temporal anti-aliasing cycles through.
  if (options.frames) given.emplace("samples", std::to_string(lab::SettleMeter::period));
  return resolved(options, std::move(given), image);
}

RenderOptions resolve_motion(const ChartOptions& options, const std::string& image) {
  Given given = chosen(options, [&](const std::string& option) { return is_common(options, option); });
  for (const char* name : {"translucency", "shadows", "ambient", "reflections", "taa", "denoise"}) given[name] = "off";
  given["aov"] = "Z,id.surface,motion";
  return resolved(options, std::move(given), image);
}

}  // namespace sideray::cli
