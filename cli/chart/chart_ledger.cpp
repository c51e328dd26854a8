#include "cli/chart/chart_ledger.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include "cli/base/outputs.h"
#include "cli/base/progress.h"
#include "cli/chart/ledger_pictures.h"
#include "lab/chart/ledger.h"
#include "lab/page/page_pictures.h"
#include "scenes/base/json_text.h"

namespace sideray::cli {
namespace {

using lab::Json;
using scenes::Image;

struct Drawn {
  std::vector<Shortcut> what;
  std::vector<lab::LedgerPicture> pictures;
};

void draw_all(LedgerPictures& pictures, Progress& progress, Drawn& drawn) {
  for (const Shortcut& shortcut : drawn.what) {
    progress.next("ledger: " + shortcut.name);
    drawn.pictures.push_back({shortcut.name, pictures.draw(shortcut)});
  }
}

Json metrics_of(const Image& image, const Image& reference, const lab::Display& display) {
  return lab::to_json(lab::compare(image, reference, display).metrics);
}

Json options_json(const lab::Configuration& configuration) {
  Json json = Json::object();
  for (const auto& [name, text] : configuration) json[name] = text;
  return json;
}

Json named_reasons(const std::vector<Unsplit>& list) {
  Json json = Json::array();
  for (const Unsplit& entry : list) json.push_back({{"name", entry.name}, {"reason", entry.reason}});
  return json;
}

// Adds the picture that a term needed, and its error against the reference; terms are effects and steps of the chain.
Json with_picture(Json term, const char* kind, const Shortcut& shortcut, const Json& error) {
  term["kind"] = kind;
  term["what"] = shortcut.what;
  term["options"] = options_json(shortcut.off);
  if (shortcut.is_exact) term["exact_points"] = true;
  if (shortcut.is_random) term["pictures"] = LedgerPictures::random_pictures;
  term["image"] = LedgerPictures::file_of(shortcut.name);
  term["error"] = error;
  return term;
}

Json terms_json(const lab::Ledger& ledger, const Drawn& without, const Drawn& chain, const Image& reference,
                const lab::Display& display) {
  Json terms = Json::array();
  const auto add = [&](const Drawn& drawn, std::span<const lab::LedgerTerm> of_drawn, const char* kind) {
    for (size_t i = 0; i < of_drawn.size(); ++i)
      terms.push_back(with_picture(lab::to_json(of_drawn[i]), kind, drawn.what[i],
                                   metrics_of(drawn.pictures[i].image, reference, display)));
  };
  add(without, ledger.effects, "effect");
  terms.push_back(lab::to_json(ledger.interaction));
  terms.back()["kind"] = "interaction";
  terms.back()["what"] = "what switching all off at once does beyond the sum of switching each off alone";
  add(chain, std::span(ledger.residuals).first(chain.what.size()), "residual");
  terms.push_back(lab::to_json(ledger.residuals.back()));
  terms.back()["kind"] = "residual";
  terms.back()["what"] = "the same in pixels whose centre shows another opaque triangle to the reference";
  return terms;
}

Json reference_json(const lab::ChartReference& reference) {
  Json json = {{"image", reference.image}, {"light_samples", reference.light_samples}};
  if (reference.bounces != 1) json["bounces"] = lab::bounces_json(reference.bounces);
  if (reference.bounces != 1) json["caustics"] = reference.caustics;
  // The variance of the mean of two halves is a quarter of that of their difference.
  if (reference.self_error) json["noise_relmse"] = *reference.self_error / 4;
  return json;
}

void add_maps(const lab::Ledger& ledger, Json& page) {
  const double largest = lab::largest_shown(ledger);
  const std::vector<const lab::LedgerTerm*> parts = lab::parts(ledger);
  const lab::PageScale scale = lab::page_scale(ledger.width, ledger.height, 2 * (parts.size() + 1));
  const auto map = [&](const lab::LedgerTerm& term) {
    return lab::page_map(lab::signed_colours(term, largest), ledger.width, ledger.height, scale);
  };
  page["largest"] = largest;
  page["total"]["map"] = map(ledger.total);
  for (size_t i = 0; i < parts.size(); ++i) page["terms"][i]["map"] = map(*parts[i]);
}

}  // namespace

void prepare_ledger(const ChartFolder& folder) {
  for (const char* name : {"ledger.json", "ledger.exr"}) require_writable(folder.path(name));
}

void remove_ledger(const ChartFolder& folder) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  for (const char* name : {"ledger.json", "ledger.exr"}) fs::remove(folder.path(name), ignored);
  for (const fs::directory_entry& entry : fs::directory_iterator(folder.path("images"), ignored))
    if (entry.path().filename().string().starts_with("ledger-")) fs::remove(entry.path(), ignored);
}

Json ledger(const ChartOptions& options, const ChartFolder& folder, Session& session,
            const lab::ChartReference& of_chart) {
  LedgerPictures pictures(options, folder, session);
  const Shortcuts shortcuts = pictures.find_shortcuts();
  Progress progress(shortcuts.taken.size() + shortcuts.chain.size() + 3);
  progress.next("ledger: reference");
  const lab::ChartReference described = pictures.draw_reference(of_chart);
  const Image reference = scenes::read_image(folder.path(described.image));
  progress.next("ledger: picture");
  const Image picture = pictures.draw({"picture", "", {}, false, false});
  Drawn without{shortcuts.taken, {}}, chain{shortcuts.chain, {}};
  draw_all(pictures, progress, without);
  draw_all(pictures, progress, chain);
  progress.next("ledger: surfaces");
  const std::vector<uint8_t> differing = pictures.differing_pixels();
  const auto references = std::count_if(chain.what.begin(), chain.what.end(), is_reference);
  const lab::Ledger split = lab::make_ledger(picture, without.pictures, chain.pictures, reference, differing,
                                             static_cast<size_t>(references));
  const lab::Display& display = pictures.base().display;
  Json json = {{"schema", 1},
               {"scene", options.scene},
               {"options", options_json(lab::Configuration(options.given.begin(), options.given.end()))},
               {"reference", reference_json(described)},
               {"image", LedgerPictures::file_of("picture")},
               {"layers", "ledger.exr"},
               {"nonfinite", split.nonfinite},
               {"error", metrics_of(picture, reference, display)},
               {"total", lab::to_json(split.total)},
               {"terms", terms_json(split, without, chain, reference, display)},
               {"inseparable", named_reasons(shortcuts.inseparable)},
               {"absent", named_reasons(shortcuts.absent)}};
  json["differing_pixels"] = std::count(differing.begin(), differing.end(), uint8_t{1});
  scenes::write_exr(folder.path("ledger.exr"), lab::layers_of(split));
  write_text(folder.path("ledger.json"), scenes::json_text(json, 2) + "\n");
  add_maps(split, json);
  return json;
}

void print_ledger(const Json& ledger) {
  const double whole = ledger["total"]["relmse"].get<double>();
  const auto percent = [](bool known, double part) { return known ? fmt::format("{:.1f}", 100.0 * part) : "-"; };
  const auto flip = [](const Json& error) {
    return error.contains("flip") ? fmt::format("{:.4f}", error["flip"].get<double>()) : std::string("-");
  };
  const auto line = [&](const Json& term, const std::string& name, const std::string& left) {
    const double relmse = term["relmse"].get<double>();
    fmt::print("{:<18} {:>8} {:>9} {:>11.3g} {:>9.3g} {:>9}  {}\n", name,
               percent(term.contains("share"), term.value("share", 0.0)), percent(whole > 0, relmse / whole), relmse,
               term["mean_absolute"].get<double>(), left, term.value("what", ""));
  };
  fmt::print("\nledger: the error of {}\n{:<18} {:>8} {:>9} {:>11} {:>9} {:>9}\n", ledger["image"].get<std::string>(),
             "", "share %", "relmse %", "relmse", "mean |e|", "flip left");
  for (const Json& term : ledger["terms"]) {
    const bool is_residual = term["kind"] == "residual";
    line(term, (is_residual ? "residual." : "") + term["name"].get<std::string>(),
         term.contains("error") ? flip(term["error"]) : "");
  }
  line(ledger["total"], "total", flip(ledger["error"]));
  if (ledger["reference"].contains("noise_relmse"))
    fmt::print("the reference's own noise: relmse about {:.2g}\n", ledger["reference"]["noise_relmse"].get<double>());
  fmt::print("pixels whose centre shows another opaque triangle to the reference: {}\n",
             ledger["differing_pixels"].get<uint64_t>());
  for (const char* group : {"inseparable", "absent"})
    for (const Json& entry : ledger[group])
      fmt::print("{}: {}: {}\n", std::string(group) == "absent" ? "not taken" : "cannot be switched off",
                 entry["name"].get<std::string>(), entry["reason"].get<std::string>());
}

}  // namespace sideray::cli
