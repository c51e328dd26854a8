#include <fmt/format.h>
#include <fmt/ranges.h>

#include "scenes/base/files.h"
#include "scenes/builtin/builtin.h"

namespace sideray::scenes {
namespace {

// `scene` is a name followed by "?K=V&K=V". No readable file has such a name.
Content generate_named(const std::string& scene) {
  const size_t mark = scene.find('?');
  Settings settings;
  for (size_t at = mark; at != std::string::npos;) {
    const size_t end = scene.find('&', at + 1);
    const std::string setting = scene.substr(at + 1, end == std::string::npos ? end : end - at - 1);
    const size_t equals = setting.find('=');
    if (equals == 0 || equals == std::string::npos)
      throw UnknownScene(SIDERAY_INVALID_ARGUMENT,
                         fmt::format("scene {}: \"{}\" is not K=V; write for example {}?{}", printable(scene),
                                     printable(setting), scene.substr(0, mark), "count=8&seed=2"));
    const std::string key = setting.substr(0, equals);
    if (!settings.emplace(key, setting.substr(equals + 1)).second)
      throw UnknownScene(SIDERAY_INVALID_ARGUMENT,
                         fmt::format("scene {}: {} is given twice; remove one", printable(scene), printable(key)));
    at = end;
  }
  try {
    return generate(scene.substr(0, mark), settings);
  } catch (const Error& error) {
    throw UnknownScene(error.status, error.what());
  }
}

}  // namespace

Content load(const std::string& scene, const LoadOptions& options) {
  if (is_builtin(scene.substr(0, scene.find('?')))) {
    Content content = generate_named(scene);
    check_animation(content, options.animation);
    check_variant(content, options.variant);
    pose(content, options.time_s);
    return content;
  }
  if (may_be_file(scene)) return load_file(scene, options);
  std::vector<std::string> names;
  for (const Builtin& builtin : builtins()) names.push_back(builtin.name);
  throw UnknownScene(
      SIDERAY_INVALID_ARGUMENT,
      fmt::format("no scene {}: it is neither a .gltf or .glb file nor a built-in scene; choose a file or one of {}",
                  printable(scene), fmt::join(names, ", ")));
}

}  // namespace sideray::scenes
