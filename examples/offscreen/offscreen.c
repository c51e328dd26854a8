/* Draws a glTF file without a display and writes linear radiance: offscreen SCENE.glb OUT.pfm [WIDTH HEIGHT]. C99;
 * needs only Sideray's installed headers and libraries. */
#include <sideray/scenes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static sideray_error error;

static void require(sideray_status status) {
  if (status == SIDERAY_OK) return;
  fprintf(stderr, "offscreen: %s\n", error.message);
  exit(1);
}

static const float* channel(const sideray_picture* picture, const char* name) {
  for (size_t i = 0; i < sideray_picture_channel_count(picture); ++i) {
    const sideray_channel* plane = sideray_picture_channel(picture, i);
    if (strcmp(plane->name, name) == 0) return plane->values;
  }
  return NULL;
}

/* Writes PFM: little endian, bottom row first. */
static int write_pfm(const char* path, const sideray_picture* picture) {
  const float* planes[3] = {channel(picture, "R"), channel(picture, "G"), channel(picture, "B")};
  uint32_t width, height;
  sideray_picture_size(picture, &width, &height);
  FILE* file = fopen(path, "wb");
  if (!file) return 0;
  fprintf(file, "PF\n%u %u\n-1.0\n", width, height);
  for (uint32_t y = height; y-- > 0;)
    for (uint32_t x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c) fwrite(&planes[c][(size_t)y * width + x], sizeof(float), 1, file);
  const int written = !ferror(file);
  return fclose(file) == 0 && written;
}

int main(int argc, char** argv) {
  if (argc != 3 && argc != 5) {
    fprintf(stderr, "usage: offscreen SCENE.glb OUT.pfm [WIDTH HEIGHT]\n");
    return 2;
  }
  sideray_render_options options = sideray_render_defaults();
  options.repeats = 1; /* for the counters below */
  if (argc == 5) {
    options.width = (uint32_t)atoi(argv[3]);
    options.height = (uint32_t)atoi(argv[4]);
  }
  sideray_content* content = NULL;
  sideray_scene* scene = NULL;
  sideray_renderer* renderer = NULL;
  sideray_picture* picture = NULL;
  sideray_camera camera = sideray_camera_defaults();
  const sideray_renderer_desc desc = sideray_renderer_defaults();
  require(sideray_content_load(argv[1], NULL, &content, &error));
  for (size_t i = 0; i < sideray_content_warning_count(content); ++i)
    fprintf(stderr, "offscreen: %s\n", sideray_content_warning(content, i));
  require(sideray_content_camera(content, 0, (float)options.width / (float)options.height, &camera, &error));
  require(sideray_scene_create(&scene, &error));
  require(sideray_content_fill(content, NULL, scene, &error));
  require(sideray_renderer_create(&desc, &renderer, &error));
  require(sideray_renderer_render(renderer, scene, &camera, &options, &picture, &error));

  sideray_render_stats stats = {0};
  stats.size = sizeof(stats);
  require(sideray_picture_stats(picture, &stats, &error));
  printf("%llu triangles, %llu rays, %llu pixels masked\n", (unsigned long long)stats.triangles,
         (unsigned long long)(stats.rays_primary + stats.rays_reflection + stats.rays_shadow + stats.rays_ao),
         (unsigned long long)stats.pixels_masked);
  const int written = write_pfm(argv[2], picture);
  if (!written) fprintf(stderr, "offscreen: cannot write %s\n", argv[2]);
  sideray_picture_release(picture);
  sideray_renderer_destroy(renderer);
  sideray_scene_release(scene);
  sideray_content_release(content);
  return written ? 0 : 1;
}
