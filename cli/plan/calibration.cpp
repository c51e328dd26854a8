#include "cli/plan/calibration.h"

#include <unistd.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <thread>

#include "cli/options/own_options.h"
#include "cli/session/picture_files.h"
#include "lab/metrics/metrics.h"
#include "scenes/base/files.h"
#include "scenes/base/json_text.h"

namespace sideray::cli {
namespace {

using nlohmann::json;

// Milliseconds to spend on timing one frame size, and limits of its repetitions.
constexpr double timing_ms = 400;
constexpr uint32_t fewest_repeats = 5, most_repeats = 25;
// Milliseconds to spend on the whole frame, with at least one repetition.
constexpr double whole_timing_ms = 1000;
constexpr uint32_t reference_light_samples = 16;
// Milliseconds to spend on a look, and its most repetitions.
constexpr double look_ms = 150;
constexpr uint32_t most_look_repeats = 5;

std::string text_of(const char* text) {
  return text ? text : "";
}

// Identifies the program. Built-in scenes belong to it, so that another build may draw another scene.
json program_stamp() {
  int major = 0, minor = 0, patch = 0;
  sideray_version(&major, &minor, &patch);
  json stamp = {{"version", fmt::format("{}.{}.{}", major, minor, patch)}};
  std::error_code error;
  const std::filesystem::path file = std::filesystem::read_symlink("/proc/self/exe", error);
  const auto bytes = std::filesystem::file_size(file, error);
  const auto modified = std::filesystem::last_write_time(file, error).time_since_epoch();
  if (!error) stamp["file"] = {bytes, std::chrono::duration_cast<std::chrono::nanoseconds>(modified).count()};
  return stamp;
}

json machine_stamp(const sideray_device_info& device) {
  char host[256] = "";
  gethostname(host, sizeof(host) - 1);
  return {{"program", program_stamp()},
          {"host", host},
          {"cores", std::thread::hardware_concurrency()},
          {"gl_threads", text_of(std::getenv("LP_NUM_THREADS"))},
          {"renderer", text_of(device.renderer)},
          {"version", text_of(device.version)}};
}

json scene_stamp(const scenes::Content& content, const RenderOptions& options) {
  json stamp = {{"name", options.scene}, {"files", content.hash}};
  constexpr uint64_t most_bytes = uint64_t{1} << 30;
  if (options.environment != "sky" && options.environment != "none")
    stamp["environment"] = scenes::hash_of(scenes::read_file(options.environment, most_bytes));
  return stamp;
}

// Lists every given option that a frame's cost depends on; bounds only choose among frames.
json options_stamp(const RenderOptions& options) {
  json stamp = {{"time", options.time_s}};
  for (const auto& [name, text] : options.given)
    if (is_in_config(name) && !name.starts_with("max-")) stamp[name] = text;
  if (options.frames) stamp["frame"] = options.frames->first;
  return stamp;
}

lab::FrameSize whole_size(const RenderOptions& options) {
  return {options.width(), options.height()};
}

lab::FrameCost cost_of(const RenderRun& run) {
  const sideray_render_stats& s = run.stats;
  lab::FrameCost cost;
  cost.pixels = s.pixels_total;
  cost.work = {s.rays_primary,   s.rays_reflection, s.rays_shadow, s.rays_ao, s.layers_matched + s.layers_missed,
               s.bytes_readback, s.bytes_upload,    s.bytes_cache,   s.rays_bounce};
  for (const sideray_stage_time& time : run.stages) {
    // Loading and building happen once, so that they are no part of a frame.
    const bool once = time.stage == SIDERAY_STAGE_LOAD || time.stage == SIDERAY_STAGE_BUILD;
    if (!once && time.stage < cost.stage_ms.size() && std::isfinite(time.median)) cost.stage_ms[time.stage] = time.median;
  }
  return cost;
}

// Returns options for a reference with the same light transport; omits options that a reference decides itself.
RenderOptions reference_options(const RenderOptions& options) {
  Given given = beside_reference(options.given);
  for (const OwnOption& own : own_options())
    if (const auto at = options.given.find(own.row.name); own.in_chart && own.in_config && at != options.given.end())
      given.insert(*at);
  given.erase("fps");
  given["o"] = "reference.exr";
  given["reference"] = "true";
  given["time"] = fmt::format("{}", options.time_s);
  given["light-samples"] = std::to_string(reference_light_samples);
  return resolve_render(options.scene, given);
}

// Returns options that draw the first frame of a sequence as a single picture.
RenderOptions first_frame(RenderOptions options) {
  if (!options.frames) return options;
  options.time_s = options.frames->time_s(options.frames->first);
  options.continues = false;
  options.named.set("taa", "off");
  options.frames.reset();
  return options;
}

}  // namespace

Calibration::Calibration(Session& session, const RenderOptions& options)
    : session_(session),
      cache_(lab::calibration_folder()),
      machine_(machine_stamp(session.device(options))),
      scene_(scene_stamp(session.content(), options)),
      exact_(reference_options(first_frame(options))) {}

json Calibration::key(const char* what, const RenderOptions& options) const {
  const sideray_camera& c = session_.camera();
  return {{"what", what},
          {"machine", machine_},
          {"isa", options.isa},
          {"scene", scene_},
          {"camera", {c.world_from_camera, c.orthographic, c.yfov, c.half_height, c.z_near, c.z_far, c.fx_per_fy, c.shift_x, c.shift_y}},
          {"size", {options.width(), options.height()}},
          {"options", options_stamp(options)}};
}

Session::Drawn Calibration::draw(const RenderOptions& options, lab::FrameSize size, uint32_t repeats) {
  RenderOptions reduced = options;
  reduced.resize(size.width, size.height);
  for (const char* once : {"samples", "check"}) reduced.named.set(once, "");
  reduced.repeats = repeats;
  if (options.frames) {
    RenderOptions first = first_frame(reduced);
    first.named.set("taa", reduced.named["taa"]);
    first.repeats = 0;
    session_.move_to(first);
    (void)session_.draw(first);
    reduced.continues = options.frames->last > options.frames->first;
    reduced.time_s = options.frames->time_s(std::min(options.frames->first + 1, options.frames->last));
  }
  session_.move_to(reduced);
  return session_.draw(reduced);
}

lab::FrameCost Calibration::measure(const RenderOptions& options, lab::FrameSize size, uint32_t repeats) {
  return cost_of(draw(options, size, repeats).run);
}

lab::Probe Calibration::probe(const RenderOptions& options) {
  const json name = key("probe", options);
  if (const auto known = probes_.find(scenes::json_text(name)); known != probes_.end()) return known->second;
  std::optional<lab::Probe> probe;
  if (const std::optional<json> kept = cache_.find(name)) probe = lab::parse_probe(*kept);
  if (!probe) {
    probe = draw_probe(options);
    cache_.keep(name, lab::to_json(*probe));
  }
  return probes_[scenes::json_text(name)] = *probe;
}

double Calibration::drawn_ms(const RenderOptions& options, double foretold_ms) {
  const lab::FrameSize whole = whole_size(options);
  if (lab::probe_sizes(whole).large.pixels() == whole.pixels()) return foretold_ms;
  const uint32_t positions = options.named.render().samples;
  const json name = key("frame", options);
  if (const std::optional<json> kept = cache_.find(name); kept && kept->contains("ms") && (*kept)["ms"].is_number())
    return positions * (*kept)["ms"].get<double>();
  // A timed picture is also drawn once before, and once more for its stages.
  const double fitting = positions * whole_timing_ms / (2 * std::max(foretold_ms, 0.1));
  const double ms = measure(options, whole, static_cast<uint32_t>(std::clamp<double>(fitting, 1, fewest_repeats))).ms();
  cache_.keep(name, {{"ms", ms}});
  return positions * ms;
}

lab::Probe Calibration::draw_probe(const RenderOptions& options) {
  const auto repeats = [](double frame_ms) {
    const double fitting = timing_ms / (2 * std::max(frame_ms, 0.1));  // each is timed as a whole and by stages
    return static_cast<uint32_t>(std::clamp<double>(fitting, fewest_repeats, most_repeats));
  };
  const lab::ProbeSizes sizes = lab::probe_sizes(whole_size(options));
  // The first picture of its kind compiles programs, builds acceleration structures and finds cold memory.
  const double first_ms = measure(options, sizes.small, 1).ms();
  const double growth = static_cast<double>(sizes.large.pixels()) / static_cast<double>(sizes.small.pixels());
  const lab::FrameCost small = measure(options, sizes.small, repeats(first_ms));
  return {small, measure(options, sizes.large, repeats(first_ms * growth))};
}

const scenes::Image& Calibration::reference() {
  if (reference_) return *reference_;
  const json name = key("reference", exact_);
  reference_ = cache_.find_picture(name);
  if (reference_) return *reference_;
  const Session::Drawn drawn = draw(exact_, lab::probe_sizes(whole_size(exact_)).small, 0);
  reference_ = image_of(drawn.picture, drawn.light_names, exact_);
  cache_.keep_picture(name, *reference_);
  return *reference_;
}

lab::Look Calibration::look(const RenderOptions& options) {
  const RenderOptions single = first_frame(options);
  json name = key("look", single);
  name["reference"] = options_stamp(exact_);
  if (const std::optional<json> kept = cache_.find(name); kept && kept->contains("ms") && (*kept)["ms"].is_number()) {
    lab::Look look{(*kept)["ms"].get<double>(), {}};
    if (kept->contains("error") && (*kept)["error"].is_number()) look.error = (*kept)["error"].get<double>();
    return look;
  }
  const scenes::Image& exact = reference();
  const lab::FrameSize size = lab::probe_sizes(whole_size(single)).small;
  // The first picture of its kind compiles programs, builds acceleration structures and finds cold memory.
  const Session::Drawn drawn = draw(single, size, 0);
  const scenes::Image image = image_of(drawn.picture, drawn.light_names, single);
  const lab::Look look{draw_ms(single, size), lab::compare(image, exact, single.display).metrics.flip};
  json kept = {{"ms", look.ms}};
  if (look.error) kept["error"] = *look.error;
  cache_.keep(name, kept);
  return look;
}

// Returns the least time of as many frames as fit `look_ms`, with readback, which takes the same time for all options.
double Calibration::draw_ms(const RenderOptions& options, lab::FrameSize size) {
  double least = std::numeric_limits<double>::infinity(), sum = 0;
  for (uint32_t n = 0; n < most_look_repeats && sum < look_ms; ++n) {
    const auto start = std::chrono::steady_clock::now();
    (void)draw(options, size, 0);
    const double ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    least = std::min(least, ms);
    sum += ms;
  }
  return least;
}

bool is_predictable(const RenderOptions& options) {
  return !options.is_exact();
}

lab::FrameCost predict(const lab::Probe& probe, const RenderOptions& options, const sideray_plan_work& most) {
  return lab::predict(probe, whole_size(options).pixels(), most, options.named.render().samples);
}

}  // namespace sideray::cli
