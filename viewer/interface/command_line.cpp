#include "viewer/interface/command_line.h"

#include <fmt/format.h>

#include <algorithm>

namespace sideray::viewer {
namespace {

std::string point(const glm::dvec3& p) {
  return fmt::format("{},{},{}", p.x, p.y, p.z);
}

void add_camera(std::vector<std::string>& words, const View& view, const Navigation& navigation) {
  if (navigation.is_free()) {
    words.insert(words.end(), {"--eye", point(navigation.eye()), "--target", point(navigation.target()), "--fov",
                               fmt::format("{}", static_cast<float>(navigation.fov_deg()))});
  } else if (navigation.file_camera() && !view.scene->content().cameras.empty()) {
    words.insert(words.end(), {"--camera", fmt::format("{}", *navigation.file_camera())});
  }
}

void add_options(std::vector<std::string>& words, Way way, const Options& base) {
  const Options options = options_of(way, base);
  for (size_t i = 0; i < sideray_option_count(); ++i) {
    const sideray_option& row = *sideray_option_at(i);
    const std::string name = row.name, value = options[name];
    if (!options.is_set(name) || (is_decided_by_window(name) && name != "reference")) continue;
    if (row.diagnostic)
      words.insert(words.end(), {"--diagnose", name + "=" + value});
    else if (row.type == SIDERAY_OPTION_FLAG)
      words.push_back("--" + name);
    else
      words.insert(words.end(), {"--" + name, value});
  }
}

bool is_plain(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) || std::string_view("-_=+.,/:@%").find(c) != std::string_view::npos;
}

}  // namespace

std::vector<std::string> words_of(const View& view, Way way, const Navigation& navigation, const Arguments& of_window) {
  const SceneSource& source = view.scene->source();
  std::vector<std::string> words{source.scene};
  add_camera(words, view, navigation);
  words.insert(words.end(), {"--size", fmt::format("{}x{}", view.width, view.height)});
  if (view.time_s > 0) words.insert(words.end(), {"--time", fmt::format("{}", view.time_s)});
  if (source.surroundings.name != "sky") words.insert(words.end(), {"--env", source.surroundings.name});
  if (!source.animation.empty()) words.insert(words.end(), {"--animation", source.animation});
  if (!source.variant.empty()) words.insert(words.end(), {"--variant", source.variant});
  for (const char* name : {"env-scale", "env-rotate", "default-light", "gl", "device", "threads"})
    if (const std::string text = of_window.text(name); !text.empty()) words.insert(words.end(), {std::string("--") + name, text});
  add_options(words, way, view.options);
  return words;
}

std::string line_of(const std::vector<std::string>& words) {
  std::string line = "sideray";
  for (const std::string& word : words) {
    line += ' ';
    if (!word.empty() && std::all_of(word.begin(), word.end(), is_plain)) {
      line += word;
      continue;
    }
    line += '\'';
    for (char c : word) line += c == '\'' ? std::string("'\\''") : std::string(1, c);
    line += '\'';
  }
  return line;
}

}  // namespace sideray::viewer
