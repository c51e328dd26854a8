#include "cli/chart/ledger_pictures.h"

#include <algorithm>

#include <fmt/format.h>

namespace sideray::cli {
namespace {

using scenes::Image;
using scenes::Plane;

constexpr float largest_half = 65504.0f;

// Adds R, G, B and A of a picture to the sums, which start as a copy of the first.
void add_colour(const Picture& picture, std::vector<Plane>& sums) {
  const size_t pixels = size_t{picture.width()} * picture.height();
  const bool is_first = sums.empty();
  for (size_t i = 0; i < picture.channel_count(); ++i) {
    const sideray_channel channel = picture.channel(i);
    const std::string name = channel.name;
    if (name.size() != 1) continue;
    const auto* values = static_cast<const float*>(channel.values);
    if (is_first) {
      sums.push_back({name, Plane::Type::half, {values, values + pixels}, {}});
      continue;
    }
    const auto sum = std::find_if(sums.begin(), sums.end(), [&](const Plane& plane) { return plane.name == name; });
    for (size_t k = 0; k < pixels; ++k) sum->values[k] += values[k];
  }
}

const uint32_t* whole_channel(const Picture& picture, const std::string& name) {
  for (size_t i = 0; i < picture.channel_count(); ++i)
    if (const sideray_channel channel = picture.channel(i); name == channel.name)
      return static_cast<const uint32_t*>(channel.values);
  throw Error(SIDERAY_INTERNAL, fmt::format("ledger: the picture has no channel {}", name));
}

}  // namespace

LedgerPictures::LedgerPictures(const ChartOptions& options, const ChartFolder& folder, Session& session)
    : options_(options), folder_(folder), session_(session), base_(resolve({}, "picture")) {}

std::string LedgerPictures::file_of(const std::string& name) {
  return "images/ledger-" + name + ".exr";
}

RenderOptions LedgerPictures::resolve(const lab::Configuration& configuration, const std::string& name) const {
  return resolve_row(options_, configuration, "ledger without " + name, folder_.path(file_of(name)));
}

Shortcuts LedgerPictures::find_shortcuts() {
  Shortcuts shortcuts = shortcuts_of(base_, session_.facts(base_));
  add_match(shortcuts);
  add_bounces(shortcuts);
  return shortcuts;
}

void LedgerPictures::add_bounces(Shortcuts& shortcuts) const {
  if (base_.is_exact() || reference_options().named["bounces"] == "1") return;
  for (Shortcut& step : shortcuts.chain)
    if (step.off.contains("translucency") && step.off.at("translucency") == "reference") step.off["bounces"] = "1";
  shortcuts.chain.push_back(
      {"bounces", "light that no method here computes: the reference of one bounce against that of all asked for",
       {{"reference", "true"}, {"bounces", "1"}}, false, false});
}

void LedgerPictures::add_match(Shortcuts& shortcuts) {
  const sideray_translucency_options& t = *base_.named.render().translucency;
  const bool has_layers = std::any_of(shortcuts.chain.begin(), shortcuts.chain.end(),
                                      [](const Shortcut& step) { return step.name == "cache"; });
  if (!base_.is_hybrid() || t.layers == 0 || t.match != SIDERAY_MATCH_ID || !has_layers) return;
  RenderOptions checked = base_;
  checked.named.set("check", "true");
  checked.repeats = 1;
  const sideray_render_stats stats = session_.draw(checked).run.stats;
  const uint64_t wrong = stats.layers_misassigned + stats.layers_duplicated;
  if (wrong == 0)
    shortcuts.absent.push_back(
        {"match",
         fmt::format("none of {} fragments with a layer has a wrong one (--diagnose check)", stats.layers_matched)});
  else
    shortcuts.inseparable.push_back(
        {"match", fmt::format("{} of {} fragments have a wrong layer (--diagnose check), and there is no better matcher "
                              "to switch to; part of residual.cache",
                              wrong, stats.layers_matched)});
}

Image LedgerPictures::write(const std::string& name, const std::vector<Plane>& colour, uint32_t pictures) const {
  Image image{base_.width(), base_.height(), colour, true};
  for (Plane& plane : image.planes)
    for (float& v : plane.values) v = std::clamp(v / static_cast<float>(pictures), -largest_half, largest_half);
  const std::string path = folder_.path(file_of(name));
  scenes::write_exr(path, image);
  return scenes::read_image(path);
}

Image LedgerPictures::draw(const Shortcut& other) {
  RenderOptions options = is_reference(other) ? reference_options(other) : resolve(other.off, other.name);
  const uint32_t pictures = other.is_random ? random_pictures : 1;
  // All of them together have as many samples as one reference.
  const uint32_t light_samples = options.named.render().translucency->light_samples;
  if (pictures > 1) options.named.set("light-samples", std::to_string(std::max(light_samples / pictures, 1u)));
  options.diagnostics.exact_points = other.is_exact;
  std::vector<Plane> sums;
  for (uint32_t i = 0; i < pictures; ++i) {
    constexpr uint32_t apart = 1000003;  // far from the seeds of the picture and of the reference
    if (pictures > 1) options.seed_offset = apart * (i + 1);
    add_colour(session_.draw(options).picture, sums);
  }
  return write(other.name, sums, pictures);
}

RenderOptions LedgerPictures::reference_options() const {
  Given given = resolve_reference(options_, folder_.path(file_of("reference"))).given;
  // The reference has the picture's light transport where it can, and no shadows if the picture has none.
  const bool mirrors = base_.named.applies("reflections") && session_.plan(base_).run.reflections.value_or(false);
  if (mirrors) given["reflections"] = "on";
  if (base_.named.applies("refraction")) given["refraction"] = base_.named["refraction"];
  if (base_.named["shadows"] == "off") given["shadows"] = "off";
  return resolve_render(options_.scene, given);
}

RenderOptions LedgerPictures::reference_options(const Shortcut& other) const {
  Given given = reference_options().given;
  for (const auto& [name, text] : other.off) given[name] = text;
  return resolve_render(options_.scene, given);
}

lab::ChartReference LedgerPictures::draw_reference(const lab::ChartReference& of_chart) {
  const RenderOptions options = reference_options();
  if (options.given == resolve_reference(options_, options.output).given) return of_chart;
  const Session::Drawn drawn = session_.draw(options);
  std::vector<Plane> colour;
  add_colour(drawn.picture, colour);
  write("reference", colour, 1);
  lab::ChartReference reference{file_of("reference"), drawn.run.stats.reference_light_samples, {}};
  reference.bounces = drawn.run.stats.reference_bounces;
  reference.caustics = drawn.run.stats.reference_caustics != 0;
  if (drawn.run.stats.reference_self_error >= 0) reference.self_error = drawn.run.stats.reference_self_error;
  return reference;
}

std::vector<uint8_t> LedgerPictures::differing_pixels() {
  RenderOptions seen = base_, exact = reference_options();
  exact.named.set("light-samples", "1");
  for (RenderOptions* options : {&exact, &seen}) {
    options->named.set("samples", "1");
    options->aovs.bits = SIDERAY_AOV_ID;
  }
  const Session::Drawn rasterized = session_.draw(seen), traced = session_.draw(exact);
  std::vector<uint8_t> differs(size_t{base_.width()} * base_.height());
  for (const char* name : {"id.surface", "id.primitive"}) {
    const uint32_t *a = whole_channel(rasterized.picture, name), *b = whole_channel(traced.picture, name);
    for (size_t i = 0; i < differs.size(); ++i) differs[i] |= static_cast<uint8_t>(a[i] != b[i]);
  }
  return differs;
}

}  // namespace sideray::cli
