#include "cli/options/render_options.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "cli/base/failure.h"
#include "cli/base/outputs.h"

namespace sideray::cli {
namespace {

std::string text(const Given& given, const char* name) {
  return text_of(render_table(), given, name);
}

// Returns "--layers", "--oit peel" for "layers", "oit peel".
std::string as_given(const std::string& option) {
  const size_t space = option.find(' ');
  return space == std::string::npos ? dashed(option) : dashed(option.substr(0, space), option.substr(space + 1));
}

// Adds dashes to the library's messages, which begin with an option, and have others in single quotes.
std::string with_dashes(const std::string& message) {
  const size_t colon = message.find(':');
  std::string result = as_given(message.substr(0, colon));
  for (size_t i = std::min(colon, message.size()); i < message.size(); ++i) {
    const size_t end = message[i] == '\'' ? message.find('\'', i + 1) : std::string::npos;
    const std::string quoted = end == std::string::npos ? "" : message.substr(i + 1, end - i - 1);
    if (quoted.empty() || !sideray_option_find(quoted.substr(0, quoted.find(' ')).c_str())) {
      result += message[i];
      continue;
    }
    result += as_given(quoted);
    i = end;
  }
  return result;
}

// Runs code that sets or checks options by name, and turns its errors into wrong usage.
template <typename Work>
void by_name(const Work& work) {
  try {
    work();
  } catch (const Error& error) {
    throw UsageError(with_dashes(error.what()));
  }
}

void set_named(const Given& given, Options& named) {
  for (const auto& option : given)
    if (sideray_option_find(option.first.c_str())) by_name([&] { named.set(option.first, option.second); });
  by_name([&] { named.require_consistent(); });
}

std::array<double, 3> point(const char* name, const std::string& given) {
  const std::vector<std::string> parts = split(given, ',');
  if (parts.size() != 3) wrong_usage("--{}: \"{}\" is not a point; write X,Y,Z", name, given);
  std::array<double, 3> p{};
  for (size_t i = 0; i < 3; ++i) p[i] = number(name, parts[i], -1e15, 1e15);
  return p;
}

// Reads focal lengths and principal point, in pixels from the picture's top left corner.
Projection projection_of(const std::string& given, double width, double height) {
  const char* const name = "intrinsics";
  const std::vector<std::string> parts = split(given, ',');
  if (parts.size() != 4) wrong_usage("--{}: \"{}\"; write FX,FY,CX,CY in pixels", name, given);
  const double fx = number(name, parts[0], 1e-6, 1e9), fy = number(name, parts[1], 1e-6, 1e9);
  const double cx = number(name, parts[2], -1e9, 1e9), cy = number(name, parts[3], -1e9, 1e9);
  const double yfov = 2.0 * std::atan(0.5 * height / fy), shift_x = cx / width - 0.5, shift_y = cy / height - 0.5;
  if (yfov <= 1e-4 || yfov >= 3.13)
    wrong_usage("--{}: FY {} is no lens of a picture {} pixels high; give it in pixels", name, parts[1], height);
  if (fx < 1e-3 * fy || fx > 1e3 * fy)
    wrong_usage("--{}: FX {} and FY {} differ more than 1000 times; give both in pixels", name, fx, fy);
  if (std::abs(shift_x) > 100.0 || std::abs(shift_y) > 100.0)
    wrong_usage("--{}: the principal point {},{} is more than 100 pictures away; give it in pixels", name, cx, cy);
  return {static_cast<float>(yfov), static_cast<float>(fx / fy), static_cast<float>(shift_x), static_cast<float>(shift_y)};
}

void set_projection(const Given& given, RenderOptions& result) {
  if (!given.contains("intrinsics")) return;
  if (given.contains("fov")) wrong_usage("--intrinsics: contradicts --fov; give one of them");
  result.projection = projection_of(given.at("intrinsics"), result.width(), result.height());
}

void set_camera(const Given& given, RenderOptions& result) {
  result.camera = text(given, "camera");
  const bool eye = given.contains("eye"), target = given.contains("target");
  if (eye != target) wrong_usage("--{}: stands alone; give --eye and --target together", eye ? "eye" : "target");
  if (given.contains("fov") && !eye) wrong_usage("--fov: needs a free camera; give --eye and --target too");
  if (!eye) return;
  if (given.contains("camera")) wrong_usage("--eye: contradicts --camera; give one of them");
  FreeCamera camera{point("eye", given.at("eye")), point("target", given.at("target"))};
  if (camera.eye == camera.target) wrong_usage("--target: is the eye itself; give another point");
  if (given.contains("fov")) camera.fov_deg = static_cast<float>(number_of(render_table(), given, "fov"));
  result.free_camera = camera;
}

void set_environment(const Given& given, RenderOptions& result) {
  result.environment = text(given, "env");
  if (result.environment != "sky" && result.environment != "none")
    require_extension("--env", result.environment, {".exr", ".hdr"});
  result.environment_scale = static_cast<float>(number_of(render_table(), given, "env-scale"));
  result.environment_rotation_deg = static_cast<float>(number_of(render_table(), given, "env-rotate"));
}

void set_outputs(const Given& given, RenderOptions& result) {
  result.output = text(given, "o");
  if (result.output.empty()) wrong_usage("render: no output; give -o IMAGE");
  result.exr = require_extension("-o", result.output, {".exr", ".png"}) == ".exr";
  if (result.frames) check_frame_pattern(result.output);
  result.stats = text(given, "stats");
  if (result.stats == "-") wrong_usage("--stats -: standard output is not a file; give a file name");
  result.truth = text(given, "truth");
  if (!result.truth.empty()) {
    require_extension("--truth", result.truth, {".json"});
    if (result.frames) check_frame_pattern(result.truth, "--truth");
  }
  result.reference = text(given, "compare");
}

void check_files(const RenderOptions& result) {
  // Built-in names and words are not paths.
  const bool is_file = result.scene.ends_with(".gltf") || result.scene.ends_with(".glb");
  const bool is_picture = result.environment != "sky" && result.environment != "none";
  require_distinct({{"-o", result.output}, {"--stats", result.stats}, {"--truth", result.truth}},
                   {{"--compare", result.reference},
                    {"--env", is_picture ? result.environment : ""},
                    {"SCENE", is_file ? result.scene : ""}});
}

void set_aovs(const Given& given, RenderOptions& result) {
  if (!given.contains("aov")) return;
  if (!result.exr) wrong_usage("--aov: needs an .exr output; a .png holds colours only");
  const sideray_render_options& o = result.named.render();
  const bool is_reference = o.reference != nullptr;
  const uint32_t layers = result.translucency() == SIDERAY_TRANSLUCENCY_HYBRID ? o.translucency->layers : 0;
  const std::string shadows = sideray_options_get(result.named.get(), "shadows");
  const bool inexact = !is_reference && shadows == "inexact";
  const bool masks = inexact || (!is_reference && shadows == "exact");
  result.aovs = parse_aovs(given.at("aov"), {layers, masks, inexact, is_reference});
}

void set_bounds(const Given& given, RenderOptions& result) {
  if (given.contains("max-ms")) result.bounds.most_ms = number_of(render_table(), given, "max-ms");
  if (given.contains("max-error")) result.bounds.most_error = number_of(render_table(), given, "max-error");
  if (!result.bounds.any()) return;
  const char* bound = result.bounds.most_ms ? "max-ms" : "max-error";
  if (given.contains("quality"))
    wrong_usage("--quality: contradicts --{}, which chooses among all values; leave one of them out", bound);
  if (result.named.render().reference)
    wrong_usage("--reference: contradicts --{}, which it decides itself; leave one of them out", bound);
  if (result.is_exact())
    wrong_usage("--{}: --translucency reference leaves nothing to choose; leave one of them out", bound);
  if (given.contains("budget"))
    wrong_usage("--budget: contradicts --{}, which times whole frames; leave one of them out", bound);
  // Bounds are on errors against light of one bounce, which has neither ambient occlusion nor such reflections.
  for (const char* name : {"ambient", "reflections"})
    if (result.named[name] == "auto") result.named.set(name, "off");
}

// Turns temporal averaging on for sequences if the option is not set and has an effect.
void set_taa(RenderOptions& result) {
  if (!result.frames)
    result.named.set("taa", "off");
  else if (!result.named.is_set("taa") && result.named.applies("taa"))
    result.named.set("taa", "on");
}

// Returns --gl, or the value of an environment variable if it is auto, for a whole job.
std::string chosen_gl(const Given& given) {
  const std::string gl = text(given, "gl");
  const char* variable = std::getenv("SIDERAY_GL");
  return gl == "auto" && variable && *variable ? variable : gl;
}

std::string pinned_isa() {
  const char* isa = std::getenv("SIDERAY_ISA");
  const std::string name = isa ? isa : "";
  if (!name.empty() && name != "sse4.2" && name != "avx2" && name != "avx512")
    wrong_usage("SIDERAY_ISA: unknown value \"{}\"; one of sse4.2, avx2, avx512", name);
  return name;
}

}  // namespace

sideray_render_options RenderOptions::picture() const {
  sideray_render_options o = named.render();
  o.continues = continues;
  o.seed += seed_offset;
  o.exposure = display.exposure_ev;
  o.repeats = repeats;
  o.aovs = aovs.bits;
  o.diagnostics = &diagnostics;
  return o;
}

void RenderOptions::resize(uint32_t width, uint32_t height) {
  named.set("size", fmt::format("{}x{}", width, height));
}

Given beside_reference(const Given& given) {
  Options named = Options::create().value();
  named.set("reference", "true");
  Given kept;
  for (const auto& [name, value] : given) {
    if (!sideray_option_find(name.c_str())) continue;
    Options trial = named;
    trial.set(name, value);
    if (sideray_options_check(trial.get(), nullptr) != SIDERAY_OK) continue;
    named = trial;
    kept[name] = value;
  }
  return kept;
}

RenderOptions resolve_render(const std::string& scene, const Given& given) {
  check_given(render_table(), given);
  if (scene.empty())
    wrong_usage("render: no scene; give a .gltf or .glb file or a built-in name (sideray make --list)");
  RenderOptions result;
  result.given = given;
  result.scene = scene;
  set_named(given, result.named);
  result.animation = text(given, "animation");
  result.variant = text(given, "variant");
  result.default_light = text(given, "default-light") == "on";
  result.time_s = number_of(render_table(), given, "time");
  result.frames = frame_range(given);
  result.resume = given.contains("resume");
  set_camera(given, result);
  set_projection(given, result);
  result.gl = chosen_gl(given);
  result.device = text(given, "device");
  result.isa = pinned_isa();
  if (given.contains("threads")) result.threads = whole_number_of(render_table(), given, "threads");
  set_bounds(given, result);
  set_taa(result);
  set_environment(given, result);
  result.display.exposure_ev = static_cast<float>(number_of(render_table(), given, "exposure"));
  result.display.tonemap = scenes::tonemap_named(text(given, "tonemap"));
  set_outputs(given, result);
  check_files(result);
  set_aovs(given, result);
  return result;
}

}  // namespace sideray::cli
