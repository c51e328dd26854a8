// Draws a glTF file without a display: readme_example SCENE.glb
#include <cstdio>
#include <sideray/scenes.hpp>

int main(int argc, char** argv) try {
  auto content = sideray::Content::load(argc > 1 ? argv[1] : "scene.glb").value();
  auto scene = sideray::Scene::create().value();
  content.fill(scene);
  auto renderer = sideray::Renderer::create().value();
  auto picture = renderer.render(scene, content.camera(), sideray_render_defaults()).value();

  std::printf("%u x %u pixels in %zu channels\n", picture.width(), picture.height(), picture.channel_count());
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
