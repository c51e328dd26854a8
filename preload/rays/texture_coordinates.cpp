#include "preload/rays/texture_coordinates.h"

#include <array>
#include <cmath>

#include "preload/base/hash.h"

namespace sideray::run {
namespace {

using Vector = std::array<float, 4>;

Vector transform(const Matrix& m, const float v[4]) {
  Vector result{};
  for (size_t row = 0; row < 4; ++row)
    for (size_t k = 0; k < 4; ++k) result[row] += m[4 * k + row] * v[k];
  return result;
}

float dot(const float* plane, const float* v) {
  return plane[0] * v[0] + plane[1] * v[1] + plane[2] * v[2] + plane[3] * v[3];
}

Vector unit(Vector v) {
  const float length = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  for (size_t c = 0; c < 3 && length > 0; ++c) v[c] /= length;
  return v;
}

// Returns the normal in eye space, for a matrix that rotates, translates and scales uniformly.
Vector eye_normal(const Matrix& modelview, const Vertex& vertex) {
  const float direction[4] = {vertex.normal[0], vertex.normal[1], vertex.normal[2], 0};
  return unit(transform(modelview, direction));
}

// Returns the direction from the eye to the vertex, reflected about its normal.
Vector reflected(const Vector& eye, const Vector& normal) {
  const Vector u = unit(eye);
  const float along = 2 * (u[0] * normal[0] + u[1] * normal[1] + u[2] * normal[2]);
  return {u[0] - along * normal[0], u[1] - along * normal[1], u[2] - along * normal[2], 0};
}

// The OpenGL Graphics System, version 2.1, section 2.11.4.
float generate(const TextureCoordinates& how, size_t c, const Vertex& vertex, const Vector& eye, const Vector& normal) {
  switch (how.mode[c]) {
    case GL_OBJECT_LINEAR:
      return dot(how.object_plane[c], vertex.position);
    case GL_EYE_LINEAR:
      return dot(how.eye_plane[c], eye.data());
    case GL_NORMAL_MAP:
      return normal[c];
    case GL_REFLECTION_MAP:
      return reflected(eye, normal)[c];
    default: {  // GL_SPHERE_MAP
      const Vector r = reflected(eye, normal);
      const float m = 2 * std::sqrt(r[0] * r[0] + r[1] * r[1] + (r[2] + 1) * (r[2] + 1));
      return m > 0 ? r[c] / m + 0.5f : 0.5f;
    }
  }
}

bool depends_on_eye(const TextureCoordinates& how) {
  for (size_t c = 0; c < 4; ++c)
    if (how.generated[c] && how.mode[c] != GL_OBJECT_LINEAR) return true;
  return false;
}

}  // namespace

uint64_t hash_of_coordinates(const DrawState& state, int unit) {
  if (unit < 0) return 0;
  const TextureCoordinates* how = state.units[static_cast<size_t>(unit)].coordinates.get();
  if (!how) return 0;
  uint64_t hash = hash_bytes(how->matrix.data(), sizeof(how->matrix), static_cast<uint64_t>(unit));
  for (size_t c = 0; c < 4; ++c) {
    hash = mix(hash, how->generated[c] ? how->mode[c] : 0);
    if (!how->generated[c]) continue;
    hash = hash_bytes(how->object_plane[c], sizeof(how->object_plane[c]), hash);
    hash = hash_bytes(how->eye_plane[c], sizeof(how->eye_plane[c]), hash);
  }
  if (depends_on_eye(*how)) hash = hash_bytes(state.modelview.data(), sizeof(state.modelview), hash);
  return hash | 1u;
}

void make_coordinates(const DrawState& state, int unit, std::vector<Vertex>& vertices) {
  if (unit < 0) return;
  const TextureCoordinates* how = state.units[static_cast<size_t>(unit)].coordinates.get();
  if (!how) return;
  for (Vertex& vertex : vertices) {
    float* uv = vertex.uv[unit];
    const Vector eye = transform(state.modelview, vertex.position), normal = eye_normal(state.modelview, vertex);
    for (size_t c = 0; c < 4; ++c)
      if (how->generated[c]) uv[c] = generate(*how, c, vertex, eye, normal);
    const Vector moved = transform(how->matrix, uv);
    const float q = moved[3] != 0 ? moved[3] : 1;
    uv[0] = moved[0] / q, uv[1] = moved[1] / q;
  }
}

}  // namespace sideray::run
