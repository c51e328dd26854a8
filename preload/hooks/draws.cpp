// Draws: immediate mode, arrays, lists, and other calls that draw or copy.
#include "preload/gl/functions.h"
#include "preload/frame/session.h"

namespace sideray::run {
namespace {

bool take_arrays(GLenum mode, GLint first, GLsizei count) {
  return session().looks() && count > 0 && session().take([&] { return session().arrays().read(mode, first, count); });
}

bool take_elements(GLenum mode, GLsizei count, GLenum type, const void* indices) {
  return session().looks() && count > 0 && session().take([&] { return session().arrays().read_indexed(mode, count, type, indices); });
}

}  // namespace
}  // namespace sideray::run

using sideray::run::real;
using sideray::run::session;

#pragma GCC visibility push(default)
extern "C" {

void glBegin(GLenum mode) {
  if (!session().begin(mode)) real().Begin(mode);
}

void glEnd() {
  const bool held = session().is_held();
  if (!held) real().End();
  session().end();
}

void glDrawArrays(GLenum mode, GLint first, GLsizei count) {
  if (!sideray::run::take_arrays(mode, first, count)) real().DrawArrays(mode, first, count);
}

void glDrawElements(GLenum mode, GLsizei count, GLenum type, const void* indices) {
  if (!sideray::run::take_elements(mode, count, type, indices)) real().DrawElements(mode, count, type, indices);
}

void glDrawRangeElements(GLenum mode, GLuint start, GLuint end, GLsizei count, GLenum type, const void* indices) {
  if (!sideray::run::take_elements(mode, count, type, indices)) real().DrawRangeElements(mode, start, end, count, type, indices);
}

void glMultiDrawArrays(GLenum mode, const GLint* first, const GLsizei* count, GLsizei draws) {
  for (GLsizei i = 0; i < draws; ++i) glDrawArrays(mode, first[i], count[i]);
}

void glMultiDrawElements(GLenum mode, const GLsizei* count, GLenum type, const void* const* indices, GLsizei draws) {
  for (GLsizei i = 0; i < draws; ++i) glDrawElements(mode, count[i], type, indices[i]);
}

void glArrayElement(GLint i) {
  session().frame().survey().miss("glArrayElement");
  real().ArrayElement(i);
}

void glCallList(GLuint list) {
  if (session().is_recording()) {
    session().lists().add_call(list);
  } else if (session().looks() && session().call_list(list)) {
    return;
  }
  real().CallList(list);
}

void glCallLists(GLsizei count, GLenum type, const void* lists) {
  if (session().is_recording()) session().lists().add_unknown();
  session().before_other("glCallLists");
  real().CallLists(count, type, lists);
}

// Calls that draw or copy and are not captured.
#define OTHER(name, parameters, arguments)  \
  void gl##name parameters {                \
    session().before_other("gl" #name);     \
    real().name arguments;                  \
  }
OTHER(DrawPixels, (GLsizei width, GLsizei height, GLenum format, GLenum type, const void* pixels), (width, height, format, type, pixels))
OTHER(Bitmap, (GLsizei width, GLsizei height, GLfloat x, GLfloat y, GLfloat dx, GLfloat dy, const GLubyte* bits), (width, height, x, y, dx, dy, bits))
OTHER(CopyPixels, (GLint x, GLint y, GLsizei width, GLsizei height, GLenum type), (x, y, width, height, type))
OTHER(ReadPixels, (GLint x, GLint y, GLsizei width, GLsizei height, GLenum format, GLenum type, void* pixels), (x, y, width, height, format, type, pixels))
OTHER(Accum, (GLenum op, GLfloat value), (op, value))
OTHER(EvalMesh1, (GLenum mode, GLint a, GLint b), (mode, a, b))
OTHER(EvalMesh2, (GLenum mode, GLint a, GLint b, GLint c, GLint d), (mode, a, b, c, d))
OTHER(Rectf, (GLfloat a, GLfloat b, GLfloat c, GLfloat d), (a, b, c, d))
OTHER(Recti, (GLint a, GLint b, GLint c, GLint d), (a, b, c, d))
OTHER(Rectd, (GLdouble a, GLdouble b, GLdouble c, GLdouble d), (a, b, c, d))
OTHER(Rects, (GLshort a, GLshort b, GLshort c, GLshort d), (a, b, c, d))
OTHER(Rectfv, (const GLfloat* a, const GLfloat* b), (a, b))
OTHER(Rectiv, (const GLint* a, const GLint* b), (a, b))
OTHER(Rectdv, (const GLdouble* a, const GLdouble* b), (a, b))
OTHER(Rectsv, (const GLshort* a, const GLshort* b), (a, b))
OTHER(BlitFramebuffer,
      (GLint a, GLint b, GLint c, GLint d, GLint e, GLint f, GLint g, GLint h, GLbitfield mask, GLenum filter),
      (a, b, c, d, e, f, g, h, mask, filter))
OTHER(DrawArraysInstanced, (GLenum mode, GLint first, GLsizei count, GLsizei instances), (mode, first, count, instances))
OTHER(DrawElementsInstanced, (GLenum mode, GLsizei count, GLenum type, const void* indices, GLsizei instances),
      (mode, count, type, indices, instances))
OTHER(DrawElementsBaseVertex, (GLenum mode, GLsizei count, GLenum type, const void* indices, GLint base),
      (mode, count, type, indices, base))

void glClear(GLbitfield mask) {
  if (session().looks()) session().before_cut();
  real().Clear(mask);
}

}  // extern "C"
#pragma GCC visibility pop
