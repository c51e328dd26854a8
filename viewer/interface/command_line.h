// Writes the window's view as arguments of the program `sideray`. Any thread.
#pragma once

#include <string>
#include <vector>

#include "viewer/base/arguments.h"
#include "viewer/drawing/view.h"
#include "viewer/scene/navigation.h"

namespace sideray::viewer {

// Returns SCENE, camera, size and the options of a side, for `render` and `chart`. `of_window` has the arguments with
// which the window was started.
std::vector<std::string> words_of(const View& view, Way way, const Navigation& navigation, const Arguments& of_window);
// Returns the words as a line for a shell.
std::string line_of(const std::vector<std::string>& words);

}  // namespace sideray::viewer
