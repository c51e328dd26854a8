// Tests that masks neither change the host's state nor depend on it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <sideray/sideray.hpp>

#include "embed/hosts/frame_outputs.h"
#include "gl/context/context.h"
#include "gl/random_state.h"
#include "gl/resources/objects.h"
#include "gl/resources/state_guard.h"

namespace sideray::tests {
namespace {

constexpr int width = 80, height = 48;

// Returns a wall at z = 0 and a plate that casts a soft shadow on it.
sideray::Scene wall_and_plate() {
  sideray::Scene scene = sideray::Scene::create().value();
  sideray_material_desc white = sideray_material_defaults();
  white.double_sided = 1;
  const float positions[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
  const uint32_t indices[] = {0, 1, 2, 0, 2, 3};
  sideray_mesh_desc mesh = sideray_mesh_defaults();
  mesh.vertex_count = 4, mesh.index_count = 6;
  mesh.positions.data = positions, mesh.indices = indices;
  sideray_instance_desc instance{};
  instance.mesh = scene.add_mesh(mesh);
  instance.material = scene.add_material(white);
  instance.visibility = SIDERAY_VISIBLE_ALL;
  for (const double size : {5.0, 0.4}) {
    for (int i : {0, 4, 8}) instance.world_from_object[i] = size;
    instance.world_from_object[11] = size < 1.0 ? 0.5 : 0.0;
    scene.add_instances({&instance, 1});
  }
  sideray_light sun{};
  sun.size = sizeof(sun);
  sun.direction[0] = 0.8f, sun.direction[2] = -1.0f;
  sun.angular_diameter_deg = 20.0f;
  for (float& c : sun.intensity) c = 1.0f;
  scene.set_lights({&sun, 1});
  scene.commit();
  return scene;
}

class MaskState : public testing::Test {
 protected:
  MaskState() {
    context_->make_current();
    const gl::Functions& gl = context_->functions();
    framebuffer_ = gl::Framebuffer(gl), depth_ = gl::Renderbuffer(gl);
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    gl.BindRenderbuffer(GL_RENDERBUFFER, depth_.id());
    gl.RenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH24_STENCIL8, width, height);
    gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER, depth_.id());
    const glm::dvec4 clip = clip_from_world() * glm::dvec4(0, 0, 0, 1);
    gl.ClearDepth(0.5 + 0.5 * clip.z / clip.w);
    gl.Clear(GL_DEPTH_BUFFER_BIT);
    shaker_.emplace(gl);
  }
  ~MaskState() override {
    service_.reset();
    shaker_.reset();
    framebuffer_.reset(), depth_.reset();
    context_->release_current();
  }

  static glm::dmat4 clip_from_world() {
    return glm::perspective(0.9, double{width} / height, 0.1, 50.0) *
           glm::translate(glm::dmat4(1.0), glm::dvec3(0, 0, -3));
  }

  void create_service() {
    service_.reset();
    const sideray_host_gl host{sizeof(host), gl::Context::get_proc_address, context_.get()};
    service_.emplace(sideray::Service::create(tracer_, host).value());
  }

  template <typename Call>
  void expect_untouched(const Call& call) {
    const auto read = [&] {
      return gl::read_state(context_->functions(), [&] { shaker_->bind_stencil_framebuffer(); });
    };
    const gl::State before = read();
    call();
    EXPECT_EQ(gl::differences(before, read()), std::vector<std::string>{});
  }

  void shake(uint32_t seed) {
    if (seed == 0) return;
    shaker_->random.seed(seed);
    shaker_->shake_framebuffers(), shaker_->shake_pixel_transfer(), shaker_->shake_textures();
    shaker_->shake_buffers(), shaker_->shake_draw();
  }

  // Returns the masks of two consecutive frames under random host state; seed 0 changes no state.
  std::vector<uint8_t> masks(uint32_t seed) {
    create_service();
    std::vector<uint8_t> result;
    for (const int32_t continues : {0, 1}) {
      FrameInputs in = inputs();
      in.frame.continues = continues;
      in.frame.seed = 5 + static_cast<uint32_t>(continues);
      sideray_ticket ticket = 0;
      sideray_error error{};
      shake(seed);
      expect_untouched([&] { ASSERT_EQ(submit_frame(service_->get(), in, ticket, &error), SIDERAY_OK); });
      shake(seed == 0 ? 0 : seed + 100);
      expect_untouched(
          [&] { ASSERT_EQ(sideray_service_wait(service_->get(), ticket, -1, &error), SIDERAY_OK) << error.message; });
      read_masks(result);
    }
    return result;
  }

  FrameInputs inputs() const {
    FrameInputs in;
    const glm::dmat4 clip = clip_from_world(), world = glm::inverse(clip);
    std::memcpy(in.frame.view.clip_from_world, glm::value_ptr(clip), sizeof(in.frame.view.clip_from_world));
    std::memcpy(in.frame.view.world_from_clip, glm::value_ptr(world), sizeof(in.frame.view.world_from_clip));
    in.frame.source.framebuffer = framebuffer_.id();
    in.frame.source.mask = SIDERAY_MASK_NONE;
    in.frame.source.width = width;
    in.frame.source.height = height;
    in.layers.reset();
    in.masks = sideray_mask_inputs_defaults();
    in.masks->shadow_lights = 1;
    in.masks->ao_rays = 4;
    return in;
  }

  void read_masks(std::vector<uint8_t>& result) {
    const gl::Functions& gl = context_->functions();
    const gl::PixelTransferGuard transfer(gl);
    const gl::TextureGuard textures(gl, 0, 1);
    gl.ActiveTexture(GL_TEXTURE0);
    sideray_mask_outputs outputs{};
    outputs.size = sizeof(outputs);
    ASSERT_EQ(sideray_service_masks(service_->get(), 0, &outputs, nullptr), SIDERAY_OK);
    for (const auto& [target, texture] : {std::pair<GLenum, uint32_t>{GL_TEXTURE_2D_ARRAY, outputs.shadow_texture},
                                          std::pair<GLenum, uint32_t>{GL_TEXTURE_2D, outputs.ao_texture}}) {
      std::vector<uint8_t> texels(size_t{width} * height);
      gl.BindTexture(target, texture);
      gl.GetTexImage(target, 0, GL_RED, GL_UNSIGNED_BYTE, texels.data());
      result.insert(result.end(), texels.begin(), texels.end());
    }
  }

  std::unique_ptr<gl::Context> context_ = gl::Context::create("auto", "");
  sideray::Scene scene_ = wall_and_plate();
  sideray::Tracer tracer_ = sideray::Tracer::create(scene_).value();
  gl::Framebuffer framebuffer_;
  gl::Renderbuffer depth_;
  std::optional<gl::Shaker> shaker_;
  std::optional<sideray::Service> service_;
};

TEST_F(MaskState, UploadsLeaveNoTraceAndTakeNone) {
  const std::vector<uint8_t> still = masks(0);
  const auto soft = std::count_if(still.begin(), still.end(), [](uint8_t texel) { return texel != 0 && texel != 255; });
  EXPECT_GT(soft, static_cast<ptrdiff_t>(still.size() / 20));
  for (uint32_t seed = 1; seed <= 4; ++seed) EXPECT_EQ(masks(seed), still) << seed;
}

// In a still view, frames trace no rays and upload no texels once the masks have converged.
TEST_F(MaskState, MasksOfWhatStandsStillAreNeitherTracedNorUploadedAgain) {
  create_service();
  std::vector<uint8_t> settled;
  uint32_t seed = 0;
  const auto frame = [&](const std::function<void(FrameInputs&)>& change) {
    FrameInputs in = inputs();
    in.frame.continues = 1;
    in.frame.seed = ++seed;
    change(in);
    sideray_ticket ticket = 0;
    EXPECT_EQ(submit_frame(service_->get(), in, ticket), SIDERAY_OK);
    EXPECT_EQ(sideray_service_wait(service_->get(), ticket, -1, nullptr), SIDERAY_OK);
    sideray_frame_stats stats{};
    stats.size = sizeof(stats);
    EXPECT_EQ(sideray_service_stats(service_->get(), ticket, &stats, nullptr), SIDERAY_OK);
    return stats;
  };
  const auto none = [](FrameInputs&) {};
  for (int i = 0; i < 48; ++i) {
    const sideray_frame_stats stats = frame(none);
    EXPECT_GT(stats.rays_shadow, 0u) << i;
    EXPECT_GT(stats.rays_ao, 0u) << i;
    EXPECT_GT(stats.bytes_upload, 0u) << i;
  }
  read_masks(settled);
  for (int i = 0; i < 3; ++i) {
    const sideray_frame_stats stats = frame(none);
    EXPECT_EQ(stats.rays_shadow + stats.rays_ao, 0u) << i;
    EXPECT_EQ(stats.bytes_upload, 0u) << i;
    std::vector<uint8_t> now;
    read_masks(now);
    EXPECT_EQ(now, settled) << i;
  }
  EXPECT_GT(frame([](FrameInputs& in) { in.masks->shadow_bias = 0.01f; }).rays_shadow, 0u);
}

}  // namespace
}  // namespace sideray::tests
