// Draws a glTF file without a display: readme_example SCENE.glb
#include <cstdio>
#include <sideray/sideray.hpp>

#include "scenes/content.h"

int main(int argc, char** argv) try {
  auto content = sideray::scenes::load(argc > 1 ? argv[1] : "panes");
  auto scene = sideray::Scene::create().value();
  sideray::scenes::fill(scene, content, std::vector<bool>(content.objects.size(), true));
  auto renderer = sideray::Renderer::create().value();
  auto picture = renderer.render(scene, content.cameras.at(0).camera, sideray_render_defaults()).value();

  std::printf("%u x %u pixels in %zu channels\n", picture.width(), picture.height(), picture.channel_count());
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
