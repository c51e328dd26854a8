// Draws motion vectors since the frame before: the camera's motion over the whole picture, then over it the instances
// that move by themselves.
#include <glm/gtc/matrix_transform.hpp>

#include "gl/passes/raster_state.h"
#include "model/mesh.h"
#include "model/wind.h"

namespace sideray::gl {
namespace {

glm::dmat4 without_jitter(const RasterView& view) {
  glm::dmat4 result(1.0);
  result[3] = glm::dvec4(-view.jitter, 0.0, 1.0);
  return result;
}

// Returns the matrix of the sky's motion, where a pixel's direction takes the place of its point and w is 1 over the
// distance. All pixels of the sky have the depth that was cleared, so that column 3 includes it.
glm::dmat4 sky_change(const RasterView& now, const glm::dmat4& before_from_local) {
  glm::dmat4 direction(1.0);
  direction[3] = glm::dvec4(-glm::dvec3(now.eye), 0.0);
  const glm::dmat4 before = before_from_local * direction * now.local_from_clip;
  const double nothing = now.reversed_depth ? 0.0 : 1.0;
  glm::dmat4 result(0.0);
  result[0] = before[0];
  result[1] = before[1];
  result[3] = before[3] + nothing * before[2];
  return result - without_jitter(now);
}

}  // namespace

void RasterState::draw_motion(const FrameBefore& before) {
  begin_pass({});
  targets.bind_motion(false);
  MotionMatrices matrices;
  matrices.still_from_local = matrices.before_from_local = without_jitter(view) * view.clip_from_local;
  if (before.snapshot) {
    matrices.before_from_local = without_jitter(before.view) * before.view.clip_from_local;
    const glm::dvec3 origin_moved = scene->snapshot().origin - before.snapshot->origin;
    if (origin_moved != glm::dvec3(0))
      matrices.before_from_local = glm::translate(matrices.before_from_local, origin_moved);
  }
  if (matrices.before_from_local == matrices.still_from_local) {
    const float none[4] = {};
    gl.ClearBufferfv(GL_COLOR, 0, none);
  } else {
    draw_motion_of_view(matrices, before.view);
  }
  if (before.snapshot && before.snapshot.get() != &scene->snapshot())
    draw_motion_of_instances(matrices, *before.snapshot);
}

void RasterState::draw_motion_of_view(const MotionMatrices& matrices, const RasterView& before) {
  const Program& program = programs.motion_of_view();
  program.use();
  const glm::vec2 size(targets.width(), targets.height());
  program.set("before_minus_now",
              glm::mat4((matrices.before_from_local - matrices.still_from_local) * view.local_from_clip));
  const bool sky_stays = view.orthographic || before.orthographic;  // all pixels have one direction
  program.set("sky_before_minus_now",
              sky_stays ? glm::mat4(0.0f) : glm::mat4(sky_change(view, matrices.before_from_local)));
  program.set("jitter", glm::vec2(view.jitter));
  program.set("pixel_size", 2.0f / size);
  program.set("half_size", 0.5f * size);
  program.set("depth_of_nothing", view.reversed_depth ? 0.0f : 1.0f);
  program.set("clip_z_from_depth", view.zero_to_one_depth ? glm::vec2(1, 0) : glm::vec2(2, -1));
  scene->textures().bind_plain(unit::material + 7, GL_TEXTURE_2D, targets.depth_stencil());
  draw_screen();
}

const Program& RasterState::motion_program(const Draw& draw, const MotionMatrices& matrices,
                                                 double time_before_s) {
  const model::Material& material = scene->material(draw);
  const Program& program = programs.coverage({.alpha = material.discards, .wind = draw.wind != 0, .motion = true});
  program.use();
  program.set("clip_from_local", clip_from_local);
  program.set("still_from_local", glm::mat4(matrices.still_from_local));
  program.set("before_from_local", glm::mat4(matrices.before_from_local));
  program.set("half_size", 0.5f * glm::vec2(targets.width(), targets.height()));
  program.set("is_placed_before", 0);
  program.set("is_shaped_before", 0);
  if (material.discards) scene->bind_material(draw.material, base_color_map);
  scene->set_wind(program, draw);
  if (draw.wind != 0)
    program.set("wind_cycles_before", model::wind_phase(scene->snapshot().winds[draw.wind - 1], time_before_s, 0.0f));
  set_culling(draw, material.cull_back ? GL_BACK : 0);
  return program;
}

// The depth test EQUAL and an invariant position select the pixels where the G-buffer shows an instance.
void RasterState::draw_motion_of_instances(const MotionMatrices& matrices, const model::Snapshot& before) {
  const model::Snapshot& now = scene->snapshot();
  begin_pass({.depth_test = true});
  targets.bind_motion(true);
  gl.DepthFunc(GL_EQUAL);
  const glm::mat4 before_from_its_local(glm::translate(matrices.before_from_local, before.origin - now.origin));
  const auto may_be_seen = [&](const model::Bounds& around) { return !is_outside(clip_from_local, around); };
  const auto is_seen = [&](uint32_t place) { return !is_hidden(scene->bounds_at(place)); };
  for (const Draw& draw : scene->opaque()) {
    if (!may_be_seen(draw.bounds)) continue;
    const model::Mesh* shape = model::shaped_before(now, draw.mesh, before);
    const auto placed_before = [&](uint32_t place) {
      return model::elsewhere_before(now, scene->instance_at(place), before, shape != nullptr);
    };
    if (draw.wind != 0 && now.time_s != before.time_s) {
      motion_program(draw, matrices, before.time_s);
      scene->draw_places(
          draw, [&](uint32_t block) { return may_be_seen(scene->bounds_of_block(block)); },
          [&](uint32_t place) { return is_seen(place) && !placed_before(place); });
    }
    const Program* program = nullptr;
    for (uint32_t place = draw.first_instance; place < draw.first_instance + draw.instance_count; ++place) {
      const model::Instance* then = placed_before(place);
      if (!then || !is_seen(place)) continue;
      if (!program) {
        program = &motion_program(draw, matrices, before.time_s);
        program->set("is_placed_before", 1);
        program->set("before_from_local", before_from_its_local);
        program->set("is_shaped_before", shape != nullptr);
        if (shape) scene->set_positions_before(draw, *shape);
      }
      program->set("local_before_from_object", glm::mat4(then->local_from_object));
      scene->draw_place(draw, place);
    }
    if (program && shape) scene->forget_positions_before(draw);
  }
}

}  // namespace sideray::gl
