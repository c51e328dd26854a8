#include "cli/chart/chart_folder.h"

#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "cli/base/failure.h"
#include "cli/base/outputs.h"
#include "cli/base/program.h"
#include "scenes/base/files.h"
#include "scenes/base/json_text.h"
#include "scenes/images/images.h"

namespace sideray::cli {
namespace {

namespace fs = std::filesystem;
using lab::Json;

// Identifies a scene: a built-in one by the program; a file by size and time too, since it may change.
Json scene_stamp(const RenderOptions& options) {
  Json stamp = {{"program", program_build()}, {"scene", options.scene}, {"isa", options.isa}};
  std::error_code error;
  for (const std::string& file : {options.scene, options.environment}) {
    const auto bytes = fs::file_size(file, error);
    if (error) continue;
    const auto modified = fs::last_write_time(file, error).time_since_epoch();
    stamp["files"][file] = {bytes, std::chrono::duration_cast<std::chrono::nanoseconds>(modified).count()};
  }
  return stamp;
}

Json options_of(const RenderOptions& options) {
  Json json = Json::object();
  for (const auto& [name, text] : options.given)
    if (name != "o") json[name] = text;
  return json;
}

std::optional<std::string> text_of_file(const std::string& path) {
  constexpr uint64_t most_bytes = uint64_t{16} << 20;
  if (!fs::is_regular_file(path)) return {};
  const std::vector<uint8_t> bytes = scenes::read_file(path, most_bytes);
  return std::string(bytes.begin(), bytes.end());
}

// Returns whether the file holds a picture. One that a full disk or a killed run has cut off is drawn again.
bool is_picture(const std::string& path) {
  try {
    return fs::is_regular_file(path) && scenes::read_image(path).width > 0;
  } catch (const Error&) {
    return false;
  }
}

}  // namespace

ChartFolder::ChartFolder(const ChartOptions& options, const std::optional<Json>& made_from)
    : folder_(options.folder), frames_(options.frames) {
  const RenderOptions reference = resolve_reference(options, path(reference_output()));
  scene_ = made_from ? *made_from : scene_stamp(reference);
  reference_ = {{"made_from", scene_}, {"options", options_of(reference)}};
}

void ChartFolder::prepare() const {
  for (const char* part : {"", "images", "rows"}) make_folder(path(part));
  for (const char* name : {"results.json", "results.csv", "index.html"}) require_writable(path(name));
}

void ChartFolder::remove_rows_from(size_t row) const {
  std::error_code ignored;
  for (; fs::remove(path(row_file(row)), ignored); ++row) fs::remove(path(image(row)), ignored);
}

std::string ChartFolder::path(const std::string& name) const {
  return (fs::path(folder_) / name).string();
}

std::string ChartFolder::row_file(size_t row) {
  return fmt::format("rows/{:04}.json", row);
}
std::string ChartFolder::image(size_t row) {
  return fmt::format("images/{:04}.exr", row);
}
std::string ChartFolder::row_output(size_t row) const {
  return frames_ ? fmt::format("images/{:04}.####.exr", row) : image(row);
}
std::string ChartFolder::reference_image() const {
  return frames_ ? frame_path(reference_output(), frames_->last) : reference_output();
}
std::string ChartFolder::reference_output() const {
  return frames_ ? "images/reference.####.exr" : "images/reference.exr";
}
std::string ChartFolder::motion_output() {
  return "images/motion.####.exr";
}

Json ChartFolder::made_with(const RenderOptions& row) const {
  return {{"made_from", scene_}, {"options", options_of(row)}, {"reference", reference_["options"]}};
}

std::optional<lab::ChartRow> ChartFolder::restore_row(size_t row, const Json& made_with) const {
  const std::optional<std::string> text = text_of_file(path(row_file(row)));
  if (!text || !is_picture(path(image(row)))) return {};
  return lab::parse_row(*text, made_with);
}

void ChartFolder::save_row(size_t row, const lab::ChartRow& content) const {
  write_text(path(row_file(row)), scenes::json_text(lab::to_json(content), 1) + "\n");
}

std::optional<lab::ChartReference> ChartFolder::restore_reference() const {
  const std::optional<std::string> text = text_of_file(path(reference_file));
  if (!text || (!frames_ && !is_picture(path(reference_image())))) return {};
  const Json json = Json::parse(*text, nullptr, false);
  if (!json.is_object() || json.value("made_with", Json()) != reference_) return {};
  lab::ChartReference reference{reference_image(), json.value("light_samples", 0u), {}};
  reference.bounces = json.value("bounces", 1u);
  reference.caustics = json.value("caustics", false);
  if (json.contains("self_error")) reference.self_error = json["self_error"].get<double>();
  if (frames_) reference.self_errors = json.value("self_errors", std::vector<double>());
  return reference;
}

void ChartFolder::save_reference(const lab::ChartReference& reference) const {
  Json json = {{"schema", 1}, {"made_with", reference_}, {"light_samples", reference.light_samples}};
  json["bounces"] = reference.bounces;
  json["caustics"] = reference.caustics;
  if (reference.self_error) json["self_error"] = *reference.self_error;
  if (frames_) json["self_errors"] = reference.self_errors;
  write_text(path(reference_file), scenes::json_text(json, 1) + "\n");
}

}  // namespace sideray::cli
