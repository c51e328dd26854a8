// Holds the window's arguments: SCENE, then options of `sideray render`, which `sideray view` has checked. Any thread.
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

  // Returns the value of the option, else `otherwise`.
  std::string text(const std::string& name, const std::string& otherwise = "") const;
  double number(const std::string& name, double otherwise) const;
};

// Reads the arguments. Throws Error for a word that is neither a scene nor an option.
Arguments read_arguments(std::span<char*> words);

// Reads three numbers such as "1.5,2,-3". Throws Error.
std::array<double, 3> point_of(const std::string& name, const std::string& text);
// Reads a size such as "1280x720". Throws Error.
std::array<uint32_t, 2> size_of(const std::string& text);

}  // namespace sideray::viewer
