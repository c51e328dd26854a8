// Finds which reflectance looks right in a host that blends displayed values.
#include "embed/fixed/fixed_points.h"

namespace sideray::tests {
namespace {

// Tests the reflectance for a host that blends displayed values, against blending in linear light.
class GammaReflections : public FixedFunction {
 protected:
  // Returns what the pane adds to the picture, for an environment of the displayed value `mirrored`.
  float added(float reflectance, float mirrored) {
    for (float& c : material_.reflectance) c = reflectance;
    const std::vector<float> sky(3 * 2 * 2, std::pow(mirrored, 2.2f));
    host.scene().set_environment(2, 2, sky.data(), 1.0f, 0.0f);
    host.scene().set_fixed_material(host.pane_desc().material, material_);
    host.scene().set_fixed_function(sideray_fixed_function_defaults());
    host.scene().commit();
    host.trace(host.inputs());
    return host.draw(program_, 330)[size_t{GlassHost::height / 2} * GlassHost::width + GlassHost::width / 2].x;
  }
  // Returns the root mean square error against blending in linear light, over all brightnesses.
  double error(float share, float reflectance) {
    double sum = 0;
    int count = 0;
    for (const float mirrored : {0.05f, 0.2f, 0.4f, 0.6f, 0.8f, 1.0f}) {
      const double adds = static_cast<double>(added(reflectance, mirrored));
      EXPECT_NEAR(adds, static_cast<double>(reflectance * mirrored), 0.002)
          << "the mirrored picture is mixed as it is shown";
      for (double behind = 0; behind <= 1; behind += 0.05, ++count) {
        const double light = (1 - static_cast<double>(share)) * std::pow(behind, 2.2) +
                             static_cast<double>(share) * std::pow(static_cast<double>(mirrored), 2.2);
        const double off = (1 - static_cast<double>(reflectance)) * behind + adds - std::pow(light, 1 / 2.2);
        sum += off * off;
      }
    }
    return std::sqrt(sum / count);
  }

  void SetUp() override {
    for (int c = 0; c < 3; ++c) material_.ambient[c] = 0;
  }

 private:
  sideray_fixed_material material_ = sideray_fixed_material_defaults();
  gl::Program program_ = host.program(330, "sideray_translucent(vec3(0.0, 0.0, 1.0), world, id)");
};

TEST_F(GammaReflections, AreNearestWithTheTrueReflectance) {
  for (const float share : {0.04f, 0.08f}) {
    const double root = error(share, std::pow(share, 1 / 2.2f)), true_share = error(share, share),
                 best = error(share, std::pow(share, 0.8f));
    EXPECT_GT(root, 1.7 * true_share) << "the root is for glass before black";
    EXPECT_LT(best, true_share);
  }
}

}  // namespace
}  // namespace sideray::tests
