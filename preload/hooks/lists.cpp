// Display lists, and the commands in them that say where and how they draw.
#include <algorithm>
#include <cmath>

#include "preload/gl/functions.h"
#include "preload/frame/session.h"

namespace sideray::run {
namespace {

template <typename T>
Matrix matrix_of(const T* values) {
  Matrix matrix;
  for (size_t i = 0; i < 16; ++i) matrix[i] = static_cast<float>(values[i]);
  return matrix;
}

Matrix identity() {
  return {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
}

Matrix translation(double x, double y, double z) {
  const double values[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x, y, z, 1};
  return matrix_of(values);
}

Matrix scale(double x, double y, double z) {
  const double values[16] = {x, 0, 0, 0, 0, y, 0, 0, 0, 0, z, 0, 0, 0, 0, 1};
  return matrix_of(values);
}

Matrix rotation(double degrees, double x, double y, double z) {
  const double length = std::sqrt(x * x + y * y + z * z);
  if (!(length > 0)) return identity();
  x /= length, y /= length, z /= length;
  const double angle = degrees * 0.017453292519943295, c = std::cos(angle), s = std::sin(angle), k = 1 - c;
  const double values[16] = {x * x * k + c,     y * x * k + z * s, x * z * k - y * s, 0, x * y * k - z * s, y * y * k + c,
                             y * z * k + x * s, 0, x * z * k + y * s, y * z * k - x * s, z * z * k + c, 0, 0, 0, 0, 1};
  return matrix_of(values);
}

void note(const Matrix& matrix, bool replaces = false) {
  if (session().is_recording()) session().lists().add_matrix(matrix, replaces);
}

}  // namespace
}  // namespace sideray::run

using namespace sideray::run;

#pragma GCC visibility push(default)
extern "C" {

void glNewList(GLuint list, GLenum mode) {
  if (session().looks()) {
    session().before_change();
    session().begin_list(list);
  }
  real().NewList(list, mode);
}

void glEndList() {
  session().lists().end();
  real().EndList();
}

void glDeleteLists(GLuint list, GLsizei count) {
  if (session().looks()) {
    session().before_change();
    session().lists().remove(list, count);
  }
  real().DeleteLists(list, count);
}

void glMatrixMode(GLenum mode) {
  if (session().is_recording()) session().lists().add_matrix_mode(mode);
  real().MatrixMode(mode);
}

void glPushMatrix() {
  if (session().is_recording()) session().lists().add_push(true);
  real().PushMatrix();
}

void glPopMatrix() {
  if (session().is_recording()) session().lists().add_push(false);
  real().PopMatrix();
}

void glLoadIdentity() {
  note(identity(), true);
  real().LoadIdentity();
}

void glLoadMatrixf(const GLfloat* values) {
  note(matrix_of(values), true);
  real().LoadMatrixf(values);
}

void glLoadMatrixd(const GLdouble* values) {
  note(matrix_of(values), true);
  real().LoadMatrixd(values);
}

void glMultMatrixf(const GLfloat* values) {
  note(matrix_of(values));
  real().MultMatrixf(values);
}

void glMultMatrixd(const GLdouble* values) {
  note(matrix_of(values));
  real().MultMatrixd(values);
}

void glTranslatef(GLfloat x, GLfloat y, GLfloat z) {
  if (session().is_recording()) note(translation(double{x}, double{y}, double{z}));
  real().Translatef(x, y, z);
}

void glTranslated(GLdouble x, GLdouble y, GLdouble z) {
  if (session().is_recording()) note(translation(x, y, z));
  real().Translated(x, y, z);
}

void glRotatef(GLfloat angle, GLfloat x, GLfloat y, GLfloat z) {
  if (session().is_recording()) note(rotation(double{angle}, double{x}, double{y}, double{z}));
  real().Rotatef(angle, x, y, z);
}

void glRotated(GLdouble angle, GLdouble x, GLdouble y, GLdouble z) {
  if (session().is_recording()) note(rotation(angle, x, y, z));
  real().Rotated(angle, x, y, z);
}

void glScalef(GLfloat x, GLfloat y, GLfloat z) {
  if (session().is_recording()) note(scale(double{x}, double{y}, double{z}));
  real().Scalef(x, y, z);
}

void glScaled(GLdouble x, GLdouble y, GLdouble z) {
  if (session().is_recording()) note(scale(x, y, z));
  real().Scaled(x, y, z);
}

void glBindTexture(GLenum target, GLuint texture) {
  if (session().is_recording() && target == GL_TEXTURE_2D) session().lists().add_texture(texture);
  real().BindTexture(target, texture);
}

void glEnable(GLenum name) {
  if (name == GL_VERTEX_PROGRAM_ARB || name == GL_FRAGMENT_PROGRAM_ARB) session().uses_shaders("glEnable of a program");
  if (session().is_recording()) session().lists().add_switch(name, true);
  real().Enable(name);
}

void glDisable(GLenum name) {
  if (session().is_recording()) session().lists().add_switch(name, false);
  real().Disable(name);
}

void glMaterialfv(GLenum face, GLenum name, const GLfloat* values) {
  if (session().is_recording()) session().lists().add_unknown();
  real().Materialfv(face, name, values);
}

void glMaterialf(GLenum face, GLenum name, GLfloat value) {
  if (session().is_recording()) session().lists().add_unknown();
  real().Materialf(face, name, value);
}

}  // extern "C"
#pragma GCC visibility pop
