#include "viewer/base/arguments.h"

#include <charconv>

#include "scenes/base/files.h"

namespace sideray::viewer {
namespace {

double number_in(const std::string& name, std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size())
    scenes::refuse("--{}: \"{}\" is not a number; start the window by sideray view, which checks options", name, text);
  return value;
}

bool is_flag(const std::string& name) {
  const sideray_option* option = sideray_option_find(name.c_str());
  return option && option->type == SIDERAY_OPTION_FLAG;
}

}  // namespace

std::string Arguments::text(const std::string& name, const std::string& otherwise) const {
  const auto at = given.find(name);
  return at == given.end() ? otherwise : at->second;
}

double Arguments::number(const std::string& name, double otherwise) const {
  const auto at = given.find(name);
  return at == given.end() ? otherwise : number_in(name, at->second);
}

Arguments read_arguments(std::span<char*> words) {
  Arguments arguments;
  for (size_t i = 0; i < words.size(); ++i) {
    const std::string word = words[i];
    if (!word.starts_with("--")) {
      if (!arguments.scene.empty()) scenes::refuse("{}: is a second scene; give one", word);
      arguments.scene = word;
      continue;
    }
    const std::string name = word.substr(2);
    if (is_flag(name))
      arguments.given[name] = "true";
    else if (i + 1 < words.size())
      arguments.given[name] = words[++i];
    else
      scenes::refuse("{}: has no value; give one", word);
  }
  if (arguments.scene.empty()) scenes::refuse("view: no scene; start the window by sideray view SCENE");
  return arguments;
}

std::array<double, 3> point_of(const std::string& name, const std::string& text) {
  std::array<double, 3> point{};
  std::string_view rest = text;
  for (double& coordinate : point) {
    const size_t comma = std::min(rest.find(','), rest.size());
    coordinate = number_in(name, rest.substr(0, comma));
    rest.remove_prefix(std::min(comma + 1, rest.size()));
  }
  return point;
}

std::array<uint32_t, 2> size_of(const std::string& text) {
  const size_t cross = std::min(text.find('x'), text.size());
  return {static_cast<uint32_t>(number_in("size", std::string_view(text).substr(0, cross))),
          static_cast<uint32_t>(number_in("size", std::string_view(text).substr(std::min(cross + 1, text.size()))))};
}

}  // namespace sideray::viewer
