// What the window is started with: SCENE, then options as `sideray render` has them, which `sideray view` has checked. Any thread.
#pragma once

#include <map>
#include <sideray/sideray.hpp>
#include <span>
#include <string>

namespace sideray::viewer {

using Given = std::map<std::string, std::string>;  // option name without dashes -> text; flags hold "true"

struct Arguments {
  std::string scene;
  Given given;

  // The text given, else `otherwise`.
  std::string text(const std::string& name, const std::string& otherwise = "") const;
  double number(const std::string& name, double otherwise) const;
};

// Throws Error for what is neither a scene nor an option.
Arguments read_arguments(std::span<char*> words);

// "1.5,2,-3" as three numbers. Throws Error.
std::array<double, 3> point_of(const std::string& name, const std::string& text);
// "1280x720".
std::array<uint32_t, 2> size_of(const std::string& text);

}  // namespace sideray::viewer
