#include "cli/view/view.h"

#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <filesystem>

#include "cli/base/failure.h"
#include "cli/options/render_options.h"
#include "cli/session/session.h"

namespace sideray::cli {
namespace {

bool is_one_of(const char* name, std::initializer_list<const char*> names) {
  return std::any_of(names.begin(), names.end(), [&](const char* other) { return std::strcmp(name, other) == 0; });
}

// Leaves out options that the window decides itself.
bool keep_library(const sideray_option& row) {
  return !is_one_of(row.name, {"samples", "taa", "deadline", "reference"});
}

bool keep_own(const OwnOption& own) {
  return is_one_of(own.row.name, {"camera", "eye", "target", "fov", "time", "animation", "variant", "env", "env-scale",
                                  "env-rotate", "default-light", "gl", "device", "threads", "exposure", "tonemap"});
}

// Refuses what `render` would refuse, before there is a window.
void check_as_render(const std::string& scene, Given given) {
  given["o"] = "view.png";
  SceneChecks().check(resolve_render(scene, given));
}

std::filesystem::path window_program() {
  std::error_code error;
  return std::filesystem::read_symlink("/proc/self/exe", error).parent_path() / "sideray-view";
}

}  // namespace

const Table& view_table() {
  static const Table table = picture_table(keep_library, keep_own);
  return table;
}

int view(const std::string& scene, const Given& given) {
  check_given(view_table(), given);
  const std::string program = window_program().string();
  if (::access(program.c_str(), X_OK) != 0)
    wrong_usage("view: the window was not built; install libglfw3-dev and libimgui-dev and build again, or the package "
                "sideray-view");
  if (scene.empty()) wrong_usage("view: no scene; give a .gltf or .glb file or a built-in name (sideray make --list)");
  check_as_render(scene, given);
  std::vector<std::string> words{program, scene};
  for (const auto& [name, value] : given) {
    words.push_back("--" + name);
    const sideray_option* row = find(view_table(), name);
    if (row->type != SIDERAY_OPTION_FLAG) words.push_back(value);
  }
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  ::execv(program.c_str(), arguments.data());
  wrong_usage("view: {} cannot be run: {}; build or install it again", program, std::strerror(errno));
}

}  // namespace sideray::cli
