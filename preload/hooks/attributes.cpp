// glVertex, glNormal, glColor, glTexCoord and glMultiTexCoord in all their forms.
#include "preload/gl/functions.h"
#include "preload/frame/session.h"

namespace sideray::run {
namespace {

// Each records the attribute if a draw is captured, and returns whether the driver must see the call.

template <int count, typename T>
bool note_Vertex(const T* values) {
  Session& now = session();
  if (!now.is_open()) return true;
  set_components<count>(now.next().position, values);
  now.add_vertex();
  return !now.is_held();
}

template <int count, typename T>
bool note_Normal(const T* values) {
  Session& now = session();
  if (now.follows_attributes()) set_normal(now.next(), values);
  return true;
}

template <int count, typename T>
bool note_Color(const T* values) {
  Session& now = session();
  if (now.follows_attributes()) set_color<count>(now.next(), values), now.note_color();
  return true;
}

template <int count, typename T>
bool note_MultiTexCoord(GLenum unit, const T* values) {
  Session& now = session();
  if (now.follows_attributes() && unit - GL_TEXTURE0 < kept_units) set_components<count>(now.next().uv[unit - GL_TEXTURE0], values);
  return true;
}

template <int count, typename T>
bool note_TexCoord(const T* values) {
  return note_MultiTexCoord<count>(GL_TEXTURE0, values);
}

}  // namespace
}  // namespace sideray::run

#define PARAMETERS_1(type) type x
#define PARAMETERS_2(type) type x, type y
#define PARAMETERS_3(type) type x, type y, type z
#define PARAMETERS_4(type) type x, type y, type z, type w
#define ARGUMENTS_1 x
#define ARGUMENTS_2 x, y
#define ARGUMENTS_3 x, y, z
#define ARGUMENTS_4 x, y, z, w

#define DEFINE(name, count, suffix, type)                                                     \
  void gl##name##count##suffix(PARAMETERS_##count(type)) {                                      \
    const type values[] = {ARGUMENTS_##count};                                                  \
    if (sideray::run::note_##name<count>(values)) sideray::run::real().name##count##suffix(ARGUMENTS_##count); \
  }                                                                                             \
  void gl##name##count##suffix##v(const type* values) {                                         \
    if (sideray::run::note_##name<count>(values)) sideray::run::real().name##count##suffix##v(values); \
  }

#define DEFINE_UNIT(name, count, suffix, type)                                                \
  void gl##name##count##suffix(GLenum unit, PARAMETERS_##count(type)) {                         \
    const type values[] = {ARGUMENTS_##count};                                                  \
    sideray::run::note_##name<count>(unit, values);                                             \
    sideray::run::real().name##count##suffix(unit, ARGUMENTS_##count);                          \
  }                                                                                             \
  void gl##name##count##suffix##v(GLenum unit, const type* values) {                            \
    sideray::run::note_##name<count>(unit, values);                                             \
    sideray::run::real().name##count##suffix##v(unit, values);                                  \
  }                                                                                             \
  void gl##name##count##suffix##ARB(GLenum unit, PARAMETERS_##count(type)) {                    \
    gl##name##count##suffix(unit, ARGUMENTS_##count);                                           \
  }                                                                                             \
  void gl##name##count##suffix##vARB(GLenum unit, const type* values) {                         \
    gl##name##count##suffix##v(unit, values);                                                   \
  }

#pragma GCC visibility push(default)
extern "C" {
SIDERAY_RUN_ATTRIBUTES(DEFINE)
SIDERAY_RUN_UNIT_ATTRIBUTES(DEFINE_UNIT)
}
#pragma GCC visibility pop
