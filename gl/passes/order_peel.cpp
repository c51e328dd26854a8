// Peels depths (Everitt 2001) by a total order of fragments, so that none of several coplanar ones is lost. A step
// draws only keys; then the fragments that it found are shaded, each once, and blended as sorted objects are.
#include "gl/passes/raster_state.h"
#include "model/failure.h"

namespace sideray::gl {

void RasterState::need_slices() {
  if (static_cast<uint32_t>(gl.texture_units) <= unit::order_keys)
    fail(SIDERAY_UNSUPPORTED, "oit peel: {} has {} texture units, {} are needed; take abuffer or sorted", gl.renderer,
         gl.texture_units, unit::order_keys + 1);
  if (slices && slices->fits()) return;
  slices.reset();
  slices = std::make_unique<PeelSlices>(gl, targets);
}

// Draws primitives in the order of their numbers. Of equally deep fragments the last one remains, which is the next in
// the order from the back.
bool RasterState::peel(Items items, const Translucency& pass, uint32_t before, uint32_t slice) {
  begin_pass({.depth_test = true, .depth_write = true});
  slices->begin(slice);
  gl.ClearBufferfi(GL_DEPTH_STENCIL, 0, view.reversed_depth ? 1.0f : 0.0f, 0);
  gl.DepthFunc(view.reversed_depth ? GL_LEQUAL : GL_GEQUAL);
  scene->textures().bind_plain(unit::order_keys, GL_TEXTURE_2D, slices->keys(before));
  Query query(gl);
  gl.BeginQuery(GL_ANY_SAMPLES_PASSED, query.id());
  draw_translucent_items(items, pass, FragmentOrder::key);
  gl.EndQuery(GL_ANY_SAMPLES_PASSED);
  GLuint any = 0;
  gl.GetQueryObjectuiv(query.id(), GL_QUERY_RESULT, &any);
  return any != 0;
}

// The depth test EQUAL lets only the slice's fragment be shaded, and coplanar ones, which their keys reject.
void RasterState::draw_slice(Items items, const Translucency& pass, uint32_t slice) {
  begin_pass({.depth_test = true, .blend_dual_source = true});
  gl.DepthFunc(GL_EQUAL);
  slices->bind_picture(slice);
  scene->textures().bind_plain(unit::order_keys, GL_TEXTURE_2D, slices->keys(slice));
  draw_translucent_items(items, pass, FragmentOrder::slice);
}

// Peels from the back: each slice is blended into the picture as soon as it is found, so that two slices are enough.
void RasterState::draw_peeled(Items items, const Translucency& pass) {
  need_slices();
  begin_pass({});
  slices->begin(1);
  const Program& start = programs.peel_start();
  start.use();
  start.set("depth_flip", view.reversed_depth ? ~0u : 0u);
  scene->textures().bind_plain(unit::material + 7, GL_TEXTURE_2D, targets.depth_stencil());
  draw_screen();
  for (uint32_t slice = 0; peel(items, pass, 1 - slice, slice); slice = 1 - slice)
    draw_slice(items, pass, slice);
}

}  // namespace sideray::gl
