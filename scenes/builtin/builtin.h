// Makes scenes by code, deterministically and without files. A separate target, for the program and the tests. Any
// thread.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "scenes/content/content.h"

namespace sideray::scenes {

struct Parameter {
  std::string name, default_value, meaning;
};

struct Builtin {
  std::string name, description;
  std::vector<Parameter> parameters;
};

// Returns every built-in scene, with its parameters.
const std::vector<Builtin>& builtins();
bool is_builtin(const std::string& name);

using Settings = std::map<std::string, std::string>;

// Returns a built-in scene. Throws Error for an unknown scene or parameter, or a value out of range; the message lists
// the valid ones.
Content generate(const std::string& name, const Settings& settings);

// Loads `scene`: a .gltf or .glb path, or the name of a built-in scene, which "?K=V&K=V" may follow with parameters.
// Throws Error with one clear line.
Content load(const std::string& scene, const LoadOptions& options = {});

}  // namespace sideray::scenes
