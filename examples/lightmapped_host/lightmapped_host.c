/* A lightmapped Blinn-Phong engine in gamma space, whose glass is ray-traced in its own look: Sideray calls the engine
 * to shade hits (sideray_scene_set_shader). Checks that glass without reflections looks as before, and that glass
 * reflects the room as the engine would draw it. Exit code 0 if both hold.
 *   lightmapped_host [--size 320x180] [--pictures BEFORE.png AFTER.png] [--in-calls] */
#include <math.h>
#include <sideray/sideray.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine.h"
#include "look.h"

/* ---- What is new: the engine's surfaces as Sideray's scene, and its shading as Sideray's shader ---- */

struct hook {
  const struct room* room;
  bool reflects;
  bool sharp; /* no mip levels */
};

static void require_ok(sideray_status status, const sideray_error* error) {
  require(status == SIDERAY_OK, error->message);
}

static float texture_level(const struct face* face, const float footprint[4]) {
  if (face->alpha < 1.0f) return 0.0f; /* glass has none */
  const float along = hypotf(footprint[0], footprint[1]), across = hypotf(footprint[2], footprint[3]);
  return log2f(fmaxf(fmaxf(along, across) * (float)texture_size, 1.0f));
}

/* Shades hits. Several tracing threads call it at once, which is safe since the room does not change. */
static void shade(void* user, const sideray_shading_point* points, size_t count, sideray_shading_result* results) {
  const struct hook* hook = user;
  for (size_t i = 0; i < count; ++i) {
    const sideray_shading_point* p = &points[i];
    const struct face* face = &hook->room->faces[p->user];
    struct fragment f = {.face = face};
    memcpy(f.uv, p->uv0, sizeof(f.uv));
    memcpy(f.light_uv, p->uv1, sizeof(f.light_uv));
    memcpy(f.normal, p->normal, sizeof(f.normal));
    memcpy(f.to_eye, p->to_eye, sizeof(f.to_eye));
    for (int c = 0; c < 3; ++c) f.position[c] = (float)p->position[c];
    f.level = hook->sharp ? 0.0f : texture_level(face, p->uv0_footprint);
    look(hook->room, &f, results[i].radiance);
    if (!hook->reflects || p->bounce > 0) continue;
    for (int c = 0; c < 3; ++c) results[i].reflectance[c] = reflectance(face, f.normal, f.to_eye);
  }
}

static void add_face(sideray_scene* scene, const struct room* room, int number) {
  static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
  static const float light_uv[8] = {0, 0, 1, 0, 1, 1, 0, 1};
  const struct face* f = &room->faces[number];
  float positions[12], uv[8];
  for (int i = 0; i < 4; ++i) {
    const float s = light_uv[2 * i], t = light_uv[2 * i + 1];
    for (int c = 0; c < 3; ++c) positions[3 * i + c] = f->corner[c] + s * f->u[c] + t * f->v[c];
    uv[2 * i] = s * f->repeats[0], uv[2 * i + 1] = t * f->repeats[1];
  }
  sideray_mesh_desc mesh = sideray_mesh_defaults();
  mesh.vertex_count = 4, mesh.index_count = 6, mesh.indices = indices;
  mesh.positions.data = positions, mesh.uv0.data = uv, mesh.uv1.data = light_uv;
  sideray_material_desc material = sideray_material_defaults(); /* only decides which surfaces rays pass through */
  material.double_sided = 1;
  material.alpha_mode = f->alpha < 1.0f ? SIDERAY_BLEND : SIDERAY_OPAQUE;
  material.base_color[3] = f->alpha;
  sideray_instance_desc instance = {0};
  sideray_error error;
  require_ok(sideray_scene_add_mesh(scene, &mesh, &instance.mesh, NULL, &error), &error);
  require_ok(sideray_scene_add_material(scene, &material, &instance.material, &error), &error);
  for (int i = 0; i < 3; ++i) instance.world_from_object[4 * i] = 1.0;
  instance.surface_id = surface_of(number);
  instance.visibility = SIDERAY_VISIBLE_ALL;
  instance.user = (uint64_t)number;
  require_ok(sideray_scene_add_instances(scene, &instance, sizeof(instance), 1, NULL, &error), &error);
}

static sideray_scene* create_scene(struct hook* hook, sideray_shader_thread thread) {
  sideray_scene* scene = NULL;
  sideray_error error;
  require_ok(sideray_scene_create(&scene, &error), &error);
  for (int i = 0; i < face_count; ++i) add_face(scene, hook->room, i);
  sideray_shader_desc shader = sideray_shader_defaults();
  shader.shade = shade;
  shader.user = hook;
  shader.thread = thread;
  shader.radiance_space = SIDERAY_SPACE_GAMMA22;
  require_ok(sideray_scene_set_shader(scene, &shader, &error), &error);
  require_ok(sideray_scene_commit(scene, &error), &error);
  return scene;
}

/* Returns inputs that point at `layers`. */
static sideray_frame_inputs frame_inputs(const struct engine* e, sideray_layer_inputs* layers) {
  *layers = sideray_layer_inputs_defaults();
  layers->max_layers = 3;
  layers->float_ids = 1; /* GLSL 1.20 */
  sideray_frame_inputs in = sideray_frame_defaults();
  in.layers = layers;
  in.source.framebuffer = e->framebuffer;
  in.source.width = e->width;
  in.source.height = e->height;
  memcpy(in.view.clip_from_world, e->camera.clip_from_world, sizeof(in.view.clip_from_world));
  memcpy(in.view.world_from_clip, e->camera.world_from_clip, sizeof(in.view.world_from_clip));
  return in;
}

/* Draws a frame of the engine, without rays if `service` is NULL. */
static uint8_t* draw_frame(const struct engine* e, const struct room* room, sideray_service* service, GLuint program) {
  sideray_error error;
  draw_opaque(e, room);
  if (service) {
    sideray_layer_inputs layers;
    const sideray_frame_inputs in = frame_inputs(e, &layers);
    sideray_ticket ticket = 0;
    require_ok(sideray_service_submit(service, &in, &ticket, &error), &error);
    require_ok(sideray_service_wait(service, ticket, -1, &error), &error);
    require_ok(sideray_service_bind(service, 0, program, 2, &error), &error);
  }
  draw_glass(e, room, program);
  return read_picture(e);
}

/* ---- The checks ---- */

struct difference {
  int pixels, differing, largest; /* pixels of glass; those that differ; largest difference in 255ths */
  double mean;
};

/* Compares the pixels in the last frame's mask. */
static struct difference compare(const uint8_t* a, const uint8_t* b, const struct engine* e) {
  struct difference d = {0, 0, 0, 0.0};
  const int texels = e->width * e->height;
  uint8_t* stencil = malloc((size_t)texels);
  require(stencil != NULL, "no memory for a mask");
  gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
  gl.ReadPixels(0, 0, e->width, e->height, GL_STENCIL_INDEX, GL_UNSIGNED_BYTE, stencil);
  for (int i = 0; i < texels; ++i) {
    if (stencil[i] == 0) continue;
    bool same = true;
    for (int c = 0; c < 3; ++c) {
      const int difference = abs(a[3 * i + c] - b[3 * i + c]);
      if (difference > d.largest) d.largest = difference;
      d.mean += difference;
      same = same && difference == 0;
    }
    ++d.pixels;
    d.differing += !same;
  }
  free(stencil);
  d.mean /= 3.0 * (double)d.pixels;
  return d;
}

/* Returns RGBA of all layers, bottom row first; A is 1 where there is an answer. The caller frees it. */
static float* read_layers(sideray_service* service, const struct engine* e) {
  sideray_layer_outputs out = {.size = sizeof(out)};
  require(sideray_service_layers(service, 0, &out, NULL) == SIDERAY_OK, "there is no frame");
  float* radiance = malloc(4 * sizeof(float) * (size_t)e->width * (size_t)e->height * out.layers);
  require(radiance != NULL, "no memory for the layers");
  gl.ActiveTexture(GL_TEXTURE0);
  gl.BindTexture(GL_TEXTURE_2D_ARRAY, out.radiance_texture);
  gl.GetTexImage(GL_TEXTURE_2D_ARRAY, 0, GL_RGBA, GL_FLOAT, radiance);
  gl.BindTexture(GL_TEXTURE_2D_ARRAY, 0);
  return radiance;
}

/* Computes the engine's colour at the point of a face that a ray hits, without mip levels. */
static void look_at(const struct room* room, int number, const float at[2], const float position[3],
                    const float direction[3], struct fragment* f, float color[3]) {
  f->face = &room->faces[number];
  f->level = 0.0f;
  const float side = dot(f->face->normal, direction) < 0.0f ? 1.0f : -1.0f;
  for (int c = 0; c < 3; ++c) {
    f->normal[c] = side * f->face->normal[c];
    f->to_eye[c] = -direction[c];
    f->position[c] = position[c];
  }
  for (int k = 0; k < 2; ++k) f->uv[k] = at[k] * f->face->repeats[k], f->light_uv[k] = at[k];
  look(room, f, color);
}

/* Computes the colour of the nearest glass of a pixel and its reflection from the room's faces alone. Returns false
 * where there is no glass, where more glass is in the reflection's way, and where an edge is within rounding. */
static bool expected_layer(const struct engine* e, const struct room* room, int x, int y, float color[3]) {
  float direction[3] = {((float)x + 0.5f) / (float)e->width * 2.0f - 1.0f,
                        ((float)y + 0.5f) / (float)e->height * 2.0f - 1.0f, -1.0f};
  direction[0] *= e->camera.half_width, direction[1] *= e->camera.half_height;
  normalize(direction);
  float at[2], distance = 0.0f, position[3], reflected[3];
  const int glass = face_along(room, e->camera.eye, direction, -1, at, &distance);
  if (glass < 0 || room->faces[glass].alpha == 1.0f) return false;
  for (int c = 0; c < 3; ++c) position[c] = e->camera.eye[c] + direction[c] * distance;
  struct fragment f = {0};
  look_at(room, glass, at, position, direction, &f, color);
  const float share = reflectance(f.face, f.normal, f.to_eye);
  if (share == 0.0f) return true;
  const float cosine = dot(f.normal, f.to_eye);
  for (int c = 0; c < 3; ++c) direction[c] += 2.0f * cosine * f.normal[c];
  normalize(direction);
  const int mirrored = face_along(room, position, direction, glass, at, &distance);
  const float margin = 0.01f, low = fminf(at[0], at[1]), high = fmaxf(at[0], at[1]);
  if (mirrored < 0 || room->faces[mirrored].alpha < 1.0f || low < margin || high > 1.0f - margin) return false;
  for (int c = 0; c < 3; ++c) position[c] += direction[c] * distance;
  look_at(room, mirrored, at, position, direction, &f, reflected);
  for (int c = 0; c < 3; ++c) color[c] += share * reflected[c];
  return true;
}

/* Compares layers with sharp reflections to the room's own geometry. */
static void check_reflections(const struct engine* e, const struct room* room, sideray_service* service) {
  float* radiance = read_layers(service, e);
  int compared = 0, wrong = 0;
  float largest = 0.0f;
  for (int i = 0; i < e->width * e->height; ++i) {
    float expected[3], difference = 0.0f;
    if (!expected_layer(e, room, i % e->width, i / e->width, expected)) continue;
    for (int c = 0; c < 3; ++c) difference = fmaxf(difference, fabsf(radiance[4 * i + c] - expected[c]));
    ++compared;
    wrong += difference > 2.0f / 255.0f;
    if (difference <= 2.0f / 255.0f) largest = fmaxf(largest, difference);
  }
  free(radiance);
  printf(
      "reflections: %d pixels compared with the room's geometry, %d differ by more than 2/255, others by up to "
      "%.2f/255\n",
      compared, wrong, (double)(largest * 255.0f));
  require(compared > e->width * e->height / 20, "too few pixels of glass to compare");
  require(wrong * 500 <= compared, "what glass reflects is not the room as the engine draws it");
}

/* Checks that glass without reflections looks as rasterized. A texture unit may filter RGBA8 in steps of 1/255
 * (llvmpipe does), and lightmaps count twice. */
static void check_look(const struct engine* e, const struct room* room, sideray_service* service,
                       const uint8_t* before) {
  uint8_t* rays = draw_frame(e, room, service, e->glass);
  uint8_t* answered = draw_frame(e, room, service, e->answers);
  const struct difference look = compare(before, rays, e), unanswered = compare(rays, answered, e);
  printf("look: %d pixels of glass, by rays and by raster within %d/255, %.3f/255 in the mean; %d have no answer\n",
         look.pixels, look.largest, look.mean, unanswered.differing);
  free(rays);
  free(answered);
  require(look.pixels > e->width * e->height / 5, "too few pixels of glass to compare");
  /* At the edge of a pane a ray may just miss a pixel that the rasterizer draws. */
  require(unanswered.differing * 1000 <= look.pixels, "some pixels of glass have no ray-traced answer");
  require(look.largest <= 2 && look.mean < 0.25, "glass that does not reflect looks different by rays");
}

struct options {
  int width, height;
  const char *before, *after;
  sideray_shader_thread thread;
};

static struct options parse(int count, char** words) {
  struct options o = {320, 180, NULL, NULL, SIDERAY_SHADE_ON_WORKERS};
  for (int i = 1; i < count; ++i) {
    if (strcmp(words[i], "--size") == 0 && i + 1 < count) {
      require(sscanf(words[++i], "%dx%d", &o.width, &o.height) == 2, "--size: give WxH");
      require(o.width >= 16 && o.height >= 16 && o.width <= 4096 && o.height <= 4096,
              "--size: give sides of 16 to 4096");
    } else if (strcmp(words[i], "--pictures") == 0 && i + 2 < count) {
      o.before = words[++i];
      o.after = words[++i];
    } else if (strcmp(words[i], "--in-calls") == 0) {
      o.thread = SIDERAY_SHADE_IN_CALLS;
    } else {
      require(false, "usage: lightmapped_host [--size WxH] [--pictures BEFORE.png AFTER.png] [--in-calls]");
    }
  }
  return o;
}

int main(int count, char** words) {
  const struct options options = parse(count, words);
  static struct room room;
  struct engine engine;
  load_room(&room);
  start_engine(&engine, &room, options.width, options.height);
  uint8_t* before = draw_frame(&engine, &room, NULL, engine.raster_glass);

  struct hook hook = {&room, false, false};
  sideray_error error;
  sideray_scene* scene = create_scene(&hook, options.thread);
  sideray_tracer* tracer = NULL;
  sideray_service* service = NULL;
  const sideray_tracer_desc tracing = sideray_tracer_defaults();
  const sideray_host_gl host = {sizeof(host), get_proc_address, NULL};
  require_ok(sideray_tracer_create(scene, &tracing, &tracer, &error), &error);
  require_ok(sideray_service_create(tracer, &host, &service, &error), &error);
  check_look(&engine, &room, service, before);
  hook.reflects = hook.sharp = true; /* no frame is in flight */
  free(draw_frame(&engine, &room, service, engine.glass));
  check_reflections(&engine, &room, service);
  hook.sharp = false;
  uint8_t* after = draw_frame(&engine, &room, service, engine.glass);
  if (options.before) write_png(options.before, before, engine.width, engine.height);
  if (options.after) write_png(options.after, after, engine.width, engine.height);
  sideray_service_destroy(service);
  sideray_tracer_release(tracer);
  sideray_scene_release(scene);
  unload_room(&room);
  free(before);
  free(after);
  return 0;
}
