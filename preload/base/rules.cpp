#include "preload/base/rules.h"

#include <array>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace sideray::run {
namespace {

constexpr std::array<const char*, 7> names = {"unknown", "opaque", "glass", "water", "mirror", "sky", "ignore"};

Kind kind_of(const std::string& name) {
  for (size_t i = 1; i < names.size(); ++i)
    if (name == names[i]) return static_cast<Kind>(i);
  return Kind::unknown;
}

[[noreturn]] void refuse(const std::string& where, const std::string& what) {
  throw std::runtime_error(where + ": " + what + "; a line is KIND texture|mesh HASH [reflectance=0..1], KIND one of glass, "
                           "water, mirror, sky, opaque, ignore");
}

float reflectance_of(const std::string& word, const std::string& where) {
  const std::string key = "reflectance=";
  if (!word.starts_with(key)) refuse(where, "\"" + word + "\" is not known");
  char* end = nullptr;
  const float value = std::strtof(word.c_str() + key.size(), &end);
  if (*end != 0 || end == word.c_str() + key.size() || !(value >= 0 && value <= 1)) refuse(where, "\"" + word + "\" is not within 0 to 1");
  return value;
}

}  // namespace

const char* kind_name(Kind kind) {
  return names[static_cast<size_t>(kind)];
}

float usual_reflectance(Kind kind) {
  return kind == Kind::mirror ? 0.3f : kind == Kind::water ? 0.02f : kind == Kind::glass ? 0.04f : 0.0f;
}

Rules Rules::read(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error(path + ": the rules file cannot be read; name one that is there");
  Rules rules;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number)
    rules.add(line.substr(0, line.find('#')), path + " line " + std::to_string(number));
  return rules;
}

void Rules::add(const std::string& line, const std::string& where) {
  std::istringstream words(line);
  std::string kind, of, hash, option;
  if (!(words >> kind)) return;
  Rule rule;
  rule.kind = kind_of(kind);
  if (rule.kind == Kind::unknown) refuse(where, "\"" + kind + "\" is no kind");
  if (!(words >> of >> hash) || (of != "texture" && of != "mesh")) refuse(where, "it does not say of what");
  char* end = nullptr;
  const uint64_t value = std::strtoull(hash.c_str(), &end, 16);
  if (*end != 0 || hash.size() != 16) refuse(where, "\"" + hash + "\" is no hash of sixteen digits");
  rule.reflectance = usual_reflectance(rule.kind);
  while (words >> option) rule.reflectance = reflectance_of(option, where);
  (of == "texture" ? textures_ : meshes_)[value] = rule;
}

Rule Rules::find(uint64_t texture, uint64_t mesh) const {
  if (const auto found = meshes_.find(mesh); found != meshes_.end()) return found->second;
  if (const auto found = textures_.find(texture); found != textures_.end()) return found->second;
  return {};
}

}  // namespace sideray::run
