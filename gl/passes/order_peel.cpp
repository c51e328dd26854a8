// Peels depths (Everitt 2001) by a total order of fragments, so that coplanar ones are all found: a step draws no more
// than keys; then each fragment that a step found is shaded, once, and blended as sorted objects are.
#include <algorithm>

#include "gl/passes/raster_state.h"
#include "model/failure.h"

namespace sideray::gl {

void RasterState::need_slices(uint32_t count) {
  if (static_cast<uint32_t>(gl.texture_units) <= unit::order_keys)
    fail(SIDERAY_UNSUPPORTED, "oit peel and front: {} has {} texture units, {} are needed; take abuffer or weighted",
         gl.renderer, gl.texture_units, unit::order_keys + 1);
  if (slices && slices->fits(count)) return;
  slices.reset();
  slices = std::make_unique<PeelSlices>(gl, targets, count);
}

// Primitives are drawn in the order of their numbers. From the front the first of equally deep ones stays, from the
// back the last: in both cases that is the next one in the order.
bool RasterState::peel(Items items, const Translucency& pass, uint32_t before, uint32_t slice,
                             FragmentOrder direction) {
  begin_pass({.depth_test = true, .depth_write = true});
  const bool from_back = direction == FragmentOrder::key_from_back;
  slices->begin(slice, from_back ? 0u : ~0u);
  if (from_back) {
    gl.ClearBufferfi(GL_DEPTH_STENCIL, 0, view.reversed_depth ? 1.0f : 0.0f, 0);
    gl.DepthFunc(view.reversed_depth ? GL_LEQUAL : GL_GEQUAL);
  } else {
    slices->copy_frame_depth(slice);
  }
  scene.textures().bind_plain(unit::order_keys, GL_TEXTURE_2D, slices->keys(before));
  Query query(gl);
  gl.BeginQuery(GL_ANY_SAMPLES_PASSED, query.id());
  draw_translucent_items(items, pass, direction);
  gl.EndQuery(GL_ANY_SAMPLES_PASSED);
  GLuint any = 0;
  gl.GetQueryObjectuiv(query.id(), GL_QUERY_RESULT, &any);
  return any != 0;
}

// The slice's depth lets no other fragment of a pixel be shaded, except for coplanar ones, whose keys differ.
void RasterState::draw_slice(Items items, const Translucency& pass, uint32_t slice) {
  begin_pass({.depth_test = true, .blend_dual_source = true});
  gl.DepthFunc(GL_EQUAL);
  slices->bind_picture(slice);
  scene.textures().bind_plain(unit::order_keys, GL_TEXTURE_2D, slices->keys(slice));
  draw_translucent_items(items, pass, FragmentOrder::slice);
}

// Peels from the back: each slice is blended into the picture as it is found, and two of them are enough for any
// number.
void RasterState::draw_peeled(Items items, const Translucency& pass) {
  need_slices(2);
  begin_pass({});
  slices->begin(1, 0);
  const Program& start = programs.peel_start();
  start.use();
  start.set("depth_flip", view.reversed_depth ? ~0u : 0u);
  scene.textures().bind_plain(unit::material + 7, GL_TEXTURE_2D, targets.depth_stencil());
  draw_screen();
  for (uint32_t slice = 0; peel(items, pass, 1 - slice, slice, FragmentOrder::key_from_back); slice = 1 - slice)
    draw_slice(items, pass, slice);
}

// Peels from the front, to the layers requested; then draws what lies behind them, weighted, and over it the slices,
// the last first.
void RasterState::draw_front(Items items, const Translucency& pass) {
  need_slices(std::max(pass.front_layers, 2u));
  const uint32_t start = slices->count() - 1;
  slices->begin(start, 0);
  uint32_t found = 0;
  while (found < pass.front_layers &&
         peel(items, pass, found == 0 ? start : found - 1, found, FragmentOrder::key_from_front))
    ++found;
  if (found == 0) return;
  if (found == pass.front_layers) {
    scene.textures().bind_plain(unit::order_keys, GL_TEXTURE_2D, slices->keys(found - 1));
    draw_weighted(items, pass, FragmentOrder::weighted_behind);
  }
  while (found > 0) draw_slice(items, pass, --found);
}

}  // namespace sideray::gl
