// Keeps per-pixel lists of all fragments (Yang et al. 2010), which are sorted when they are resolved: exact, and the
// measure of the other orders. Where they need more memory than allowed, draws the picture in bands of rows.
#include <algorithm>

#include "gl/passes/raster_state.h"
#include "model/failure.h"

namespace sideray::gl {
namespace {

uint32_t most_nodes(const Functions& gl, uint64_t most_bytes) {
  const uint64_t bytes = std::min(most_bytes, static_cast<uint64_t>(gl.storage_block_bytes));
  return static_cast<uint32_t>(std::min<uint64_t>(bytes / FragmentLists::node_bytes, 0xffffffffu / 9u));
}

}  // namespace

void RasterState::draw_listed(Items items, const Translucency& pass) {
  if (!gl.storage_buffers)
    fail(SIDERAY_UNSUPPORTED,
         "oit abuffer: {} has OpenGL {}.{}, lists of fragments need 4.3; take peel, which is as exact", gl.renderer,
         gl.version / 10, gl.version % 10);
  const uint32_t most = most_nodes(gl, pass.most_list_bytes);
  if (!lists || lists->capacity() > most) lists = std::make_unique<FragmentLists>(gl);
  uint32_t rows = targets.height();
  for (uint32_t first = 0; first < targets.height();) {
    rows = std::min(rows, targets.height() - first);
    const uint32_t wanted = fill_lists(items, pass, first, rows);
    if (wanted <= lists->capacity()) {
      resolve_lists(first, rows);
      first += rows;
    } else if (lists->capacity() < most) {
      // Allocates a quarter more than is needed now, so that the next frames of a sequence fit.
      lists->grow(static_cast<uint32_t>(std::min<uint64_t>(most, uint64_t{wanted} * 5 / 4)));
    } else if (rows > 1) {
      rows = std::max(1u, static_cast<uint32_t>(uint64_t{rows} * most / wanted / 2));
    } else {
      fail(SIDERAY_OUT_OF_MEMORY,
           "oit abuffer: row {} has {} fragments and {} bytes hold no more than {}; take peel, which needs no lists",
           first, wanted, uint64_t{most} * FragmentLists::node_bytes, most);
    }
  }
  gl.Disable(GL_SCISSOR_TEST);
}

// Returns how many nodes the fragments of these rows need.
uint32_t RasterState::fill_lists(Items items, const Translucency& pass, uint32_t first, uint32_t rows) {
  begin_pass({.depth_test = true, .color_write = false});
  targets.bind_frame();
  lists->begin(targets.width() * targets.height());
  limit_rows(first, rows);
  leave_whole_out(pass.whole);
  draw_translucent_items(items, pass, FragmentOrder::listed);
  take_whole_in();
  gl.ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  return lists->wanted();
}

void RasterState::resolve_lists(uint32_t first, uint32_t rows) {
  begin_pass({.blend_dual_source = true});
  targets.bind_resolve();
  limit_rows(first, rows);
  const Program& program = programs.resolve_lists();
  program.use();
  program.set("list_row", static_cast<int>(targets.width()));
  draw_screen();
}

void RasterState::limit_rows(uint32_t first, uint32_t rows) const {
  gl.Enable(GL_SCISSOR_TEST);
  gl.Scissor(0, static_cast<GLint>(first), static_cast<GLsizei>(targets.width()), static_cast<GLsizei>(rows));
}

}  // namespace sideray::gl
