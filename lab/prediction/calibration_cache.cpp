#include "lab/prediction/calibration_cache.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <vector>

#include "scenes/base/files.h"
#include "scenes/base/json_text.h"

namespace sideray::lab {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int schema = 1;
constexpr uint64_t most_entry_bytes = uint64_t{1} << 20, most_picture_bytes = uint64_t{64} << 20;
constexpr size_t most_files = 2000;

std::span<const uint8_t> bytes_of(const std::string& text) {
  return {reinterpret_cast<const uint8_t*>(text.data()), text.size()};
}

std::string variable(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

}  // namespace

std::string CalibrationCache::path(const json& key, const char* extension) const {
  const uint64_t hash = scenes::hash_of(bytes_of(scenes::json_text(key)));
  return (fs::path(folder_) / fmt::format("{:016x}{}", hash, extension)).string();
}

std::optional<json> CalibrationCache::find(const json& key) const {
  if (folder_.empty()) return {};
  try {
    const std::string file = path(key, ".json");
    if (!fs::is_regular_file(file)) return {};
    const json entry = json::parse(scenes::read_file(file, most_entry_bytes), nullptr, false);
    if (!entry.is_object() || entry.value("schema", json()) != schema || entry.value("key", json()) != key) return {};
    return entry.at("value");
  } catch (const std::exception&) {
    return {};
  }
}

void CalibrationCache::keep(const json& key, const json& value) const {
  if (folder_.empty()) return;
  try {
    fs::create_directories(folder_);
    make_room();
    const json entry = {{"schema", schema}, {"key", key}, {"value", value}};
    scenes::write_file(path(key, ".json"), bytes_of(scenes::json_text(entry, 1) + "\n"));
  } catch (const std::exception&) {
    return;  // it is measured again next time
  }
}

// The entry holds a hash of the picture's file, so that a truncated or exchanged file counts as absent.
std::optional<scenes::Image> CalibrationCache::find_picture(const json& key) const {
  const std::optional<json> hash = find(key);
  if (!hash) return {};
  try {
    const std::string file = path(key, ".exr");
    if (scenes::hash_of(scenes::read_file(file, most_picture_bytes)) != hash->get<uint64_t>()) return {};
    return scenes::read_image(file);
  } catch (const std::exception&) {
    return {};
  }
}

void CalibrationCache::keep_picture(const json& key, scenes::Image picture) const {
  if (folder_.empty()) return;
  std::erase_if(picture.planes,
                [](const scenes::Plane& plane) { return plane.name != "R" && plane.name != "G" && plane.name != "B"; });
  for (scenes::Plane& plane : picture.planes) plane.type = scenes::Plane::Type::single;
  try {
    fs::create_directories(folder_);
    const std::string file = path(key, ".exr");
    scenes::write_exr(file, picture);
    keep(key, scenes::hash_of(scenes::read_file(file, most_picture_bytes)));
  } catch (const std::exception&) {
    return;
  }
}

void CalibrationCache::make_room() const {
  std::vector<fs::directory_entry> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_))
    if (entry.path().extension() == ".json" || entry.path().extension() == ".exr") files.push_back(entry);
  if (files.size() < most_files) return;
  std::sort(files.begin(), files.end(),
            [](const auto& a, const auto& b) { return a.last_write_time() < b.last_write_time(); });
  std::error_code ignored;
  for (size_t i = 0; i < files.size() / 2; ++i) fs::remove(files[i], ignored);
}

std::string calibration_folder() {
  if (variable("SIDERAY_CACHE") == "off") return "";
  const std::string cache = variable("XDG_CACHE_HOME"), home = variable("HOME");
  if (fs::path(cache).is_absolute()) return (fs::path(cache) / "sideray").string();
  return home.empty() ? "" : (fs::path(home) / ".cache" / "sideray").string();
}

}  // namespace sideray::lab
