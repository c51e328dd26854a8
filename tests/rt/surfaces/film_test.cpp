// Thin films of shading.h against the text of KHR_materials_iridescence in double precision, and closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/constants.hpp>
#include <iostream>
#include <random>

#include "rt/textures/surface_textures.h"
#include "shaders/shading/shading_cpp.h"

namespace sideray::rt {
namespace {

using glm::dvec3;
using shading::SrMaterial;
using shading::SrSurface;

double schlick(double f0, double cosine) {
  return f0 + (1.0 - f0) * std::pow(1.0 - cosine, 5.0);
}

// evalSensitivity of the extension's implementation notes, without a shift.
dvec3 sensitivity(double path_nm) {
  const double pi = glm::pi<double>(), phase = 2.0 * pi * path_nm * 1e-9;
  const dvec3 value(5.4856e-13, 4.4201e-13, 5.2481e-13), position(1.6810e+06, 1.7953e+06, 2.2084e+06),
      variance(4.3278e+09, 9.3046e+09, 6.6121e+09);
  dvec3 xyz = value * glm::sqrt(2.0 * pi * variance) * glm::cos(position * phase) * glm::exp(-phase * phase * variance);
  xyz.x += 9.7470e-14 * std::sqrt(2.0 * pi * 4.5282e+09) * std::cos(2.2399e+06 * phase) *
           std::exp(-4.5282e+09 * phase * phase);
  xyz /= 1.0685e-7;
  return {3.2404542 * xyz.x - 1.5371385 * xyz.y - 0.4985314 * xyz.z,
          -0.9692660 * xyz.x + 1.8760108 * xyz.y + 0.0415560 * xyz.z,
          0.0556434 * xyz.x - 0.2040259 * xyz.y + 1.0572252 * xyz.z};
}

// evalIridescence of the notes, without its lower bound of 1e-5 on R123, which adds fringes where nothing reflects;
// what it shifts by half a wave are channels of the base, and so of the fringes.
dvec3 stated_reflectance(dvec3 f0, double ior, double thickness, double cosine) {
  const double inside = std::sqrt(1.0 - (1.0 - cosine * cosine) / (ior * ior));
  const double first = schlick(std::pow((ior - 1.0) / (ior + 1.0), 2.0), cosine), passed = 1.0 - first;
  const double path = 2.0 * ior * thickness * inside;
  dvec3 sum;
  for (int c = 0; c < 3; ++c) {
    const double root = std::sqrt(f0[c]), base = (1.0 + root) / (1.0 - root);
    const double second = schlick(std::pow((base - ior) / (base + ior), 2.0), inside);
    const double both = std::min(first * second, 0.9999), from_below = passed * passed * second / (1.0 - both);
    const double half_wave = base < ior ? 1.0 : -1.0;  // cos of the phases of both interfaces: 2 pi, or pi
    sum[c] = first + from_below +
             2.0 * (from_below - passed) *
                 (std::sqrt(both) * half_wave * sensitivity(path)[c] + both * sensitivity(2.0 * path)[c]);
  }
  return glm::clamp(sum, 0.0, 1.0);
}

TEST(Film, ReflectsWhatTheExtensionStates) {
  const dvec3 bases[] = {{0, 0, 0}, {0.02, 0.04, 0.2}, {0.04, 0.04, 0.04}, {0.9, 0.7, 0.35}, {0.9999, 0.99, 0.95}};
  double worst = 0;
  for (const dvec3& base : bases)
    for (const double ior : {1.0, 1.1, 1.3, 1.52, 2.0, 3.0})
      for (double thickness = 0.0; thickness < 4000.0; thickness += 37.0)
        for (const double cosine : {0.01, 0.1, 0.35, 0.7, 0.95, 1.0}) {
          const dvec3 stated = stated_reflectance(base, ior, thickness, cosine);
          const glm::vec3 ours = shading::sr_film_reflectance(
              glm::vec3(base), static_cast<float>(ior), static_cast<float>(thickness), static_cast<float>(cosine));
          for (int c = 0; c < 3; ++c) worst = std::max(worst, std::abs(stated[c] - double{ours[c]}));
        }
  std::cout << "  worst difference " << worst << "\n";
  EXPECT_LT(worst, 2e-5);
}

// Functions of its own, so that lanes, drivers and single numbers agree.
TEST(Film, WavesAndTheirFadingAreCosineAndExponential) {
  for (int i = 0; i <= 200000; ++i) {
    const float t = static_cast<float>(i) * 2.5e-4f;
    ASSERT_NEAR(shading::sr_turned(t), std::cos(2.0 * glm::pi<double>() * double{t}), 1e-6) << t;
    ASSERT_NEAR(shading::sr_faded(t), std::exp(-double{t}), 2e-6) << t;
  }
}

struct Filmed {
  SrMaterial material{};
  glm::vec3 to_eye{0, 0, 1};
  Filmed() {
    material.base_color = glm::vec4(0.8f, 0.5f, 0.3f, 1);
    material.specular_color = glm::vec3(1);
    material.specular = material.roughness = 1;
    material.ior = 1.5f;
    material.iridescence = 1, material.iridescence_ior = 1.6f;
    material.iridescence_thickness_min = 100, material.iridescence_thickness_max = 380;
  }
  void look_at(float cosine) { to_eye = {std::sqrt(1 - cosine * cosine), 0, cosine}; }
  SrSurface base() const { return shading::sr_surface(material, no_texels, {0, 0, 1}, {0, 0, 1}); }
  SrSurface surface(const shading::SrTexels& texels = no_texels) const {
    return shading::sr_filmed(base(), material, texels, to_eye);
  }
};

TEST(Film, OfNoShareOrNoThicknessIsTheBase) {
  for (const float metallic : {0.0f, 0.4f, 1.0f})
    for (const float cosine : {0.02f, 0.4f, 1.0f}) {
      Filmed without, thin, unlit;
      for (Filmed* f : {&without, &thin, &unlit}) f->material.metallic = metallic, f->look_at(cosine);
      without.material.iridescence = 0;
      thin.material.iridescence_thickness_max = 0;
      unlit.material.unlit = true;
      for (const Filmed* f : {&without, &thin, &unlit}) {
        EXPECT_EQ(f->surface().f0, f->base().f0);
        EXPECT_EQ(f->surface().f90, f->base().f90);
      }
      shading::SrTexels none = no_texels;
      none.iridescence = 0;
      EXPECT_EQ(Filmed().surface(none).f0, Filmed().base().f0);
      EXPECT_NE(Filmed().surface().f0, Filmed().base().f0);
    }
}

// Straight on: elsewhere Schlick's term lets even a boundary between equal media reflect, as stated.
TEST(Film, OfAirIsTheBaseStraightOn) {
  Filmed f;
  f.material.iridescence_ior = 1.0f, f.material.metallic = 0.6f;
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(f.surface().f0[c], f.base().f0[c], 1e-6f);
}

// The texture's 0 and 1 are the least and the largest thickness, whichever of them is more.
TEST(Film, IsAsThickAsTheTextureSays) {
  Filmed thick, textured;
  textured.material.iridescence_thickness_min = 500, textured.material.iridescence_thickness_max = 100;
  shading::SrTexels texels = no_texels;
  texels.iridescence_thickness = 0.25f;
  thick.material.iridescence_thickness_max = 400;
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(textured.surface(texels).f0[c], thick.surface().f0[c], 1e-5f);
}

// At the eye's own angle Fresnel's term is the film's reflectance, in the share that the film has.
TEST(Film, FresnelsTermIsItsReflectanceAtTheEyesAngle) {
  for (const float share : {0.3f, 1.0f})
    for (const float cosine : {0.3f, 0.6f, 1.0f}) {
      Filmed f;
      f.material.iridescence = share, f.material.specular = 0.5f, f.look_at(cosine);
      const SrSurface s = f.surface(), base = f.base();
      const glm::vec3 film = shading::sr_film_reflectance(base.f0, 1.6f, 380.0f, cosine);
      const glm::vec3 expected = glm::mix(shading::sr_fresnel(base.f0, base.f90, cosine), film, share);
      const glm::vec3 seen = shading::sr_fresnel(s.f0, s.f90, cosine);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(seen[c], expected[c], 2e-6f);
    }
}

// Beyond what the eye tells apart, a film over grey is grey: the light of its two sides, added.
TEST(Film, ThickOnesHaveNoColour) {
  for (const float thickness : {8e3f, 1e5f, 1e6f}) {
    const glm::vec3 seen = shading::sr_film_reflectance(glm::vec3(0.2f), 1.5f, thickness, 1.0f);
    const double upper = 0.04, root = std::sqrt(0.2), base = (1 + root) / (1 - root);
    const double lower = std::pow((base - 1.5) / (base + 1.5), 2);
    const double expected = upper + (1 - upper) * (1 - upper) * lower / (1 - upper * lower);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(double{seen[c]}, expected, 2e-6);
  }
}

TEST(Film, ReflectsNoLessThanNothingAndNoMoreThanAll) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  for (int i = 0; i < 200000; ++i) {
    Filmed f;
    SrMaterial& m = f.material;
    m.base_color = glm::vec4(unit(random), unit(random), unit(random), 1);
    m.metallic = unit(random) < 0.5f ? 1.0f : unit(random);
    m.ior = 1.0f + 1.5f * unit(random), m.specular = unit(random);
    m.iridescence = unit(random) < 0.5f ? 1.0f : unit(random);
    m.iridescence_ior = 1.0f + 2.0f * unit(random);
    m.iridescence_thickness_max = unit(random) < 0.1f ? 1e6f : 2000.0f * unit(random);
    f.look_at(unit(random) < 0.2f ? 0.02f * unit(random) : unit(random));
    const SrSurface s = f.surface();
    for (const glm::vec3 v : {s.f0, s.f90, shading::sr_fresnel(s.f0, s.f90, unit(random))})
      for (int c = 0; c < 3; ++c) {
        ASSERT_GE(v[c], 0.0f) << i;
        ASSERT_LE(v[c], 1.0f + 1e-6f) << i;
      }
  }
}

}  // namespace
}  // namespace sideray::rt
