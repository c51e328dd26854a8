#include <cmath>

#include "fuzz/fuzz.h"
#include "fuzz/memory_file.h"
#include "scenes/content/content.h"

// The glTF loader, binary or JSON by what the input begins with. A file is refused by one line, or gives content that
// everything behind the loader takes without a further question.
namespace {

using namespace sideray;

void use(const scenes::Content& content) {
  const sideray_camera camera =
      content.cameras.empty() ? scenes::framing_camera(content, 1.0f) : content.cameras[0].camera;
  for (const double m : camera.world_from_camera)
    if (!std::isfinite(m)) fuzz::broken("cameras are finite", std::to_string(m));
  scenes::info_json(content);
  scenes::info_text(content);
  Scene scene = Scene::create().value();
  scenes::fill(scene, content, scenes::select_ray_traced(content, "auto", camera, 64, 64));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const bool binary = size >= 4 && std::string(data, data + 4) == "glTF";
  static tests::MemoryFile glb(".glb"), gltf(".gltf");
  tests::MemoryFile& file = binary ? glb : gltf;
  file.put({data, size});
  scenes::Content content;
  try {
    content = scenes::load_file(file.path());
  } catch (const Error& error) {
    fuzz::check_message(error.what());
    return 0;
  }
  try {
    use(content);
  } catch (const Error& error) {
    fuzz::broken("what was loaded can be shown", error.what());
  }
  return 0;
}
