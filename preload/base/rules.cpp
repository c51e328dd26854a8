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
  throw std::runtime_error(where + ": " + what + "; a line is KIND texture|mesh HASH or KIND guessed, with [reflectance=0..1] [ior=1..4] "
                           "[shade=0..1] behind it, KIND one of glass, water, mirror, sky, opaque, ignore, or it is sun light 0..7");
}

// Describes an option of a rule, and its range.
struct Option {
  const char* name;
  float Rule::*value;
  float least, most;
};
constexpr std::array<Option, 3> options = {{{"reflectance", &Rule::reflectance, 0, 1}, {"ior", &Rule::ior, 1, 4}, {"shade", &Rule::shade, 0, 1}}};

void set_option(Rule& rule, const std::string& word, const std::string& where) {
  const size_t equals = word.find('=');
  for (const Option& option : options) {
    if (word.substr(0, equals) != option.name || equals == std::string::npos) continue;
    const char* text = word.c_str() + equals + 1;
    char* end = nullptr;
    const float value = std::strtof(text, &end);
    if (*end != 0 || end == text || !(value >= option.least && value <= option.most)) refuse(where, "\"" + word + "\" is out of range");
    rule.*option.value = value;
    return;
  }
  refuse(where, "\"" + word + "\" is not known");
}

uint64_t hash_of(const std::string& text, const std::string& where) {
  char* end = nullptr;
  const uint64_t hash = std::strtoull(text.c_str(), &end, 16);
  if (*end != 0 || text.size() != 16) refuse(where, "\"" + text + "\" is no hash of sixteen digits");
  return hash;
}

// Throws where an option would have no effect, since that is a mistake.
void check(const Rule& rule, const std::string& where) {
  if (rule.ior != 1 && rule.kind != Kind::glass && rule.kind != Kind::water) refuse(where, "ior is of glass and water alone");
  if (rule.shade >= 0 && rule.kind != Kind::opaque) refuse(where, "shade is of opaque alone");
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

Rules::Rules() {
  guess_.kind = Kind::glass;
  guess_.reflectance = usual_reflectance(Kind::glass);
}

void Rules::add(const std::string& line, const std::string& where) {
  std::istringstream words(line);
  std::string kind, of, name, option;
  if (!(words >> kind)) return;
  words >> of;
  if (of != "guessed") words >> name;
  if (kind == "sun" && of == "light") return add_sun(name, where);
  Rule rule;
  rule.kind = kind_of(kind);
  if (rule.kind == Kind::unknown) refuse(where, "\"" + kind + "\" is no kind");
  rule.reflectance = usual_reflectance(rule.kind);
  while (words >> option) set_option(rule, option, where);
  check(rule, where);
  if (of == "guessed")
    guess_ = rule;
  else if (of == "texture" || of == "mesh")
    (of == "texture" ? textures_ : meshes_)[hash_of(name, where)] = rule;
  else
    refuse(where, "it does not say of what");
}

void Rules::add_sun(const std::string& number, const std::string& where) {
  if (number.size() != 1 || number[0] < '0' || number[0] > '7') refuse(where, "it does not say which light");
  sun_ = number[0] - '0';
}

Rule Rules::find(uint64_t texture, uint64_t mesh) const {
  if (const auto found = meshes_.find(mesh); found != meshes_.end()) return found->second;
  if (const auto found = textures_.find(texture); found != textures_.end()) return found->second;
  return {};
}

}  // namespace sideray::run
