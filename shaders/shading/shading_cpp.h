// Lets shading.h compile as C++ on GLM types, in namespace sideray::shading. Include this, never shading.h itself.
#pragma once

#include <glm/glm.hpp>

#include "elementary/functions.h"

namespace sideray::shading {

using real = float;
using real2 = glm::vec2;
using real3 = glm::vec3;
using real4 = glm::vec4;
using boolean = bool;
using integer = int;
using one_real = float;
using one_real3 = glm::vec3;
using elementary::acos, elementary::exp, elementary::exp2, elementary::log, elementary::log2;
using glm::abs, glm::ceil, glm::clamp, glm::cross, glm::dot, glm::floor, glm::length, glm::max, glm::min, glm::mix,
    glm::normalize, glm::reflect, glm::sqrt;

template <typename T>
inline T sr_select(bool condition, const T& yes, const T& no) {
  return condition ? yes : no;
}
inline bool sr_any(bool condition) {
  return condition;
}
inline real sr_atan2(real y, real x) {
  return elementary::atan2(y, x);
}

#define SR_FN inline __attribute__((always_inline))
#include "shaders/shading/shading.h"

#include "shaders/shading/fixed_function.h"
#include "shaders/shading/sprites.h"
#include "shaders/shading/wind.h"
#undef SR_FN

}  // namespace sideray::shading
