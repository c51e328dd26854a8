// What the window shows, as words of the program `sideray`. Any thread.
#pragma once

#include <string>
#include <vector>

#include "viewer/base/arguments.h"
#include "viewer/drawing/view.h"
#include "viewer/scene/navigation.h"

namespace sideray::viewer {

// SCENE, camera, size and the options of a side: what `render` and `chart` share. `of_window` are those that the window was
// started with.
std::vector<std::string> words_of(const View& view, Way way, const Navigation& navigation, const Arguments& of_window);
// As a shell reads it.
std::string line_of(const std::vector<std::string>& words);

}  // namespace sideray::viewer
