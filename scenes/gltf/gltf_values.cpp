#include <algorithm>
#include <cmath>
#include <limits>

#include "scenes/base/files.h"
#include "scenes/gltf/gltf.h"

namespace sideray::scenes::gltf {
namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

}  // namespace

int add_buffer(File& file, std::vector<uint8_t> bytes) {
  file.model.buffers.emplace_back().data = std::move(bytes);
  return static_cast<int>(file.model.buffers.size() - 1);
}

std::string reason_of(const Error& error, const File& file) {
  std::string reason = error.what();
  const std::string before = fmt::format("cannot read {}", file.path);
  if (reason.starts_with(before)) reason.erase(0, before.size());
  reason.erase(0, reason.find_first_not_of(":, "));
  return reason.substr(0, reason.rfind("; "));
}

void warn_of_unused_images(const File& file, Content& content) {
  for (const auto& [image, message] : file.broken_images)
    content.warnings.push_back(fmt::format("image {}: it cannot be read, and nothing shown uses it; left out", image));
}

size_t checked_index(const File& file, int index, size_t count, const char* kind, const std::string& user) {
  if (index < 0 || static_cast<size_t>(index) >= count) {
    refuse("cannot read {}: {} uses {} {}, and there are {}; export it again", file.path, user, kind, index, count);
  }
  return static_cast<size_t>(index);
}

double number(const File& file, const tinygltf::Value& value, const char* key, double fallback) {
  if (!value.Has(key)) return fallback;
  const tinygltf::Value& entry = value.Get(key);
  const double result = entry.IsNumber() ? entry.GetNumberAsDouble() : not_a_number;
  if (!std::isfinite(result)) refuse("cannot read {}: {} is not a number; export it again", file.path, key);
  return result;
}

std::vector<double> numbers(const File& file, const tinygltf::Value& value, const char* key,
                            std::vector<double> fallback) {
  if (!value.Has(key)) return fallback;
  const tinygltf::Value& entry = value.Get(key);
  std::vector<double> result;
  if (entry.IsArray()) {
    for (size_t i = 0; i < entry.ArrayLen(); ++i) {
      const tinygltf::Value& element = entry.Get(static_cast<int>(i));
      result.push_back(element.IsNumber() ? element.GetNumberAsDouble() : not_a_number);
    }
  }
  const bool finite = std::all_of(result.begin(), result.end(), [](double x) { return std::isfinite(x); });
  if (result.size() != fallback.size() || !finite) {
    refuse("cannot read {}: {} is not a list of {} numbers; export it again", file.path, key, fallback.size());
  }
  return result;
}

const tinygltf::Value* extension(const tinygltf::ExtensionMap& extensions, const char* name) {
  const auto found = extensions.find(name);
  return found != extensions.end() && found->second.IsObject() ? &found->second : nullptr;
}

const tinygltf::Value* sideray_extras(const tinygltf::Value& extras) {
  if (!extras.IsObject() || !extras.Has("sideray")) return nullptr;
  const tinygltf::Value& ours = extras.Get("sideray");
  return ours.IsObject() ? &ours : nullptr;
}

}  // namespace sideray::scenes::gltf
