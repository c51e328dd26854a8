// Tests structs of other versions: fields that a shorter one lacks have their defaults, unknown fields of a longer one
// must be 0 or are refused by name, and impossible sizes are refused.
#include <gmock/gmock.h>

#include <sideray/diagnostics.h>
#include <sideray/plan.h>
#include <sideray/scenes.h>

#include <cstddef>
#include <cstring>
#include <functional>
#include <optional>
#include <sideray/sideray.hpp>

#include "gl/context/context.h"
#include "gl/resources/objects.h"

namespace sideray::tests::version_test {
namespace {

using testing::HasSubstr;

struct Answer {
  sideray_status status;
  std::string message;
};

Answer answer(const std::function<sideray_status(sideray_error*)>& call) {
  sideray_error error{};
  const sideray_status status = call(&error);
  return {status, error.message};
}

// A struct as in a later version.
template <typename T>
struct Later {
  T known;
  uint64_t unknown = 0;
};

// `accepts` passes the struct to the library. `garbage` fills the last field, at `last_field`, which an older struct
// lacks, with a value that the library would refuse.
template <typename T>
void expect_versions(const char* name, const T& valid, size_t last_field, const std::function<void(T&)>& garbage,
                     const std::function<sideray_status(const T*, sideray_error*)>& accepts) {
  SCOPED_TRACE(name);
  const auto given = [&](const T* t) { return answer([&](sideray_error* error) { return accepts(t, error); }); };
  EXPECT_EQ(given(&valid).status, SIDERAY_OK) << given(&valid).message;

  T broken = valid;
  garbage(broken);
  EXPECT_LT(given(&broken).status, 0) << "the last field is not read at all";
  T shorter = broken;
  shorter.size = last_field;
  EXPECT_EQ(given(&shorter).status, SIDERAY_OK) << given(&shorter).message;

  Later<T> longer{valid};
  longer.known.size = sizeof(longer);
  EXPECT_EQ(given(&longer.known).status, SIDERAY_OK) << given(&longer.known).message;
  longer.unknown = uint64_t{1} << 40;
  EXPECT_EQ(given(&longer.known).status, SIDERAY_UNSUPPORTED);
  EXPECT_THAT(given(&longer.known).message, HasSubstr(name));
  EXPECT_THAT(given(&longer.known).message, HasSubstr("byte " + std::to_string(sizeof(T) + 5)));

  for (const size_t size : {size_t{0}, size_t{3}, sizeof(T) + 5000, ~size_t{0}, size_t{0xcdcdcdcdcdcdcdcd}}) {
    T odd = valid;
    odd.size = size;
    EXPECT_EQ(given(&odd).status, SIDERAY_INVALID_ARGUMENT) << size;
    EXPECT_THAT(given(&odd).message, HasSubstr(name)) << size;
  }
}

class Versions : public testing::Test {
 protected:
  Versions() : scene_(Scene::create().value()) { scene_.commit(); }

  // Neither needs a context nor draws.
  sideray_status plan(const sideray_render_options* options, sideray_error* error) {
    sideray_plan* plan = nullptr;
    const sideray_status status = sideray_plan_create(scene_.get(), options, &plan, error);
    sideray_plan_release(plan);
    return status;
  }
  template <typename T>
  std::function<sideray_status(const T*, sideray_error*)> as_part(const T* sideray_render_options::*part) {
    return [this, part](const T* given, sideray_error* error) {
      sideray_render_options options = sideray_render_defaults();
      options.*part = given;
      return plan(&options, error);
    };
  }

  Scene scene_;
};

TEST_F(Versions, OfRenderOptions) {
  static const sideray_diagnostics unsized{};
  expect_versions<sideray_render_options>(
      "render options", sideray_render_defaults(), offsetof(sideray_render_options, diagnostics),
      [](sideray_render_options& o) { o.diagnostics = &unsized; },
      [this](const sideray_render_options* o, sideray_error* error) { return plan(o, error); });
}

TEST_F(Versions, OfThePartsOfRenderOptions) {
  sideray_translucency_options raster = sideray_translucency_defaults();
  raster.method = SIDERAY_TRANSLUCENCY_RASTER;
  expect_versions<sideray_translucency_options>(
      "translucency options", raster, offsetof(sideray_translucency_options, check),
      [](sideray_translucency_options& o) { o.check = 1; }, as_part(&sideray_render_options::translucency));
  expect_versions<sideray_shadow_options>(
      "shadow options", sideray_shadow_defaults(), offsetof(sideray_shadow_options, bias),
      [](sideray_shadow_options& o) { o.bias = -1; }, as_part(&sideray_render_options::shadows));
  expect_versions<sideray_pose_options>(
      "pose options", sideray_pose_defaults(), offsetof(sideray_pose_options, cull_angle_deg),
      [](sideray_pose_options& o) { o.cull_angle_deg = 91; }, as_part(&sideray_render_options::poses));
  expect_versions<sideray_reference_options>(
      "reference options", sideray_reference_defaults(), offsetof(sideray_reference_options, light_samples),
      [](sideray_reference_options& o) { o.light_samples = 0; }, as_part(&sideray_render_options::reference));
}

TEST_F(Versions, OfMaterials) {
  expect_versions<sideray_material_desc>(
      "material", sideray_material_defaults(), offsetof(sideray_material_desc, diffuse_transmission_color_texture),
      [](sideray_material_desc& m) { m.diffuse_transmission_color_texture.texture = 99; },
      [this](const sideray_material_desc* m, sideray_error* error) {
        sideray_material material = 0;
        return sideray_scene_add_material(scene_.get(), m, &material, error);
      });
}

TEST_F(Versions, OfCameras) {
  auto renderer = Renderer::create().value();
  const auto render = [&](const sideray_camera* camera, sideray_error* error) {
    sideray_render_options options = sideray_render_defaults();
    options.width = options.height = 4;
    sideray_picture* picture = nullptr;
    const sideray_status status =
        sideray_renderer_render(renderer.get(), scene_.get(), camera, &options, &picture, error);
    sideray_picture_release(picture);
    return status;
  };
  expect_versions<sideray_camera>("camera", sideray_camera_defaults(), offsetof(sideray_camera, z_far),
                                  [](sideray_camera& c) { c.z_far = -1; }, render);
}

// A target that a service can read.
class ServiceVersions : public Versions {
 protected:
  ServiceVersions() : context_(gl::Context::create("auto", "")), depth_(gl()), framebuffer_(gl()) {
    gl().BindRenderbuffer(GL_RENDERBUFFER, depth_.id());
    gl().RenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH32F_STENCIL8, 4, 4);
    gl().BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    gl().FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER, depth_.id());
    const sideray_host_gl host{sizeof(sideray_host_gl), &gl::Context::get_proc_address, context_.get()};
    tracer_.emplace(Tracer::create(scene_).value());
    service_.emplace(Service::create(*tracer_, host).value());
  }
  const gl::Functions& gl() const { return context_->functions(); }

  sideray_frame_inputs inputs() const {
    sideray_frame_inputs in = sideray_frame_defaults();
    for (int i = 0; i < 4; ++i) in.view.clip_from_world[5 * i] = in.view.world_from_clip[5 * i] = 1;
    in.source.framebuffer = framebuffer_.id();
    in.source.width = in.source.height = 4;
    in.layers = &layers_;
    return in;
  }
  sideray_status submit(const sideray_frame_inputs* in, sideray_error* error) {
    sideray_ticket ticket = 0;
    const sideray_status status = sideray_service_submit(service_->get(), in, &ticket, error);
    if (status == SIDERAY_OK) service_->wait(ticket);
    return status;
  }
  template <typename T>
  std::function<sideray_status(const T*, sideray_error*)> as_job(const T* sideray_frame_inputs::*job) {
    return [this, job](const T* given, sideray_error* error) {
      sideray_frame_inputs in = inputs();
      in.*job = given;
      return submit(&in, error);
    };
  }

  std::unique_ptr<gl::Context> context_;
  gl::Renderbuffer depth_;
  gl::Framebuffer framebuffer_;
  sideray_layer_inputs layers_ = sideray_layer_inputs_defaults();
  std::optional<Tracer> tracer_;
  std::optional<Service> service_;
};

TEST_F(ServiceVersions, OfFrameInputs) {
  expect_versions<sideray_frame_inputs>(
      "frame inputs", inputs(), offsetof(sideray_frame_inputs, view_id),
      [](sideray_frame_inputs& in) { in.view_id = SIDERAY_MAX_VIEWS; },
      [this](const sideray_frame_inputs* in, sideray_error* error) { return submit(in, error); });
}

TEST_F(ServiceVersions, OfJobs) {
  expect_versions<sideray_layer_inputs>(
      "layer inputs", layers_, offsetof(sideray_layer_inputs, adds_to),
      [](sideray_layer_inputs& in) { in.adds_to = 12345; }, as_job(&sideray_frame_inputs::layers));
  sideray_mask_inputs masks = sideray_mask_inputs_defaults();
  masks.ao_rays = 1;
  expect_versions<sideray_mask_inputs>(
      "mask inputs", masks, offsetof(sideray_mask_inputs, shadow_bias_steps),
      [](sideray_mask_inputs& in) { in.shadow_bias_steps = -1; },
      as_job(&sideray_frame_inputs::masks));
}

TEST_F(Versions, OfWhatTheLibraryFillsAreFilledAsFarAsTheCallerKnows) {
  Later<sideray_scene_facts> facts{};
  std::memset(static_cast<void*>(&facts), 0x77, sizeof(facts));
  facts.known.size = offsetof(sideray_scene_facts, lit_lights);
  ASSERT_EQ(answer([&](sideray_error* e) { return sideray_plan_scene(scene_.get(), &facts.known, e); }).status,
            SIDERAY_OK);
  EXPECT_EQ(facts.known.size, offsetof(sideray_scene_facts, lit_lights)) << "stays the caller's";
  EXPECT_EQ(facts.known.sprites, 0u);
  EXPECT_EQ(facts.known.lit_lights, 0x7777777777777777u);
  facts.known.size = sizeof(facts);
  ASSERT_EQ(answer([&](sideray_error* e) { return sideray_plan_scene(scene_.get(), &facts.known, e); }).status,
            SIDERAY_OK);
  EXPECT_EQ(facts.known.lit_lights, 0u);
  EXPECT_EQ(facts.unknown, 0u) << "what only a later version knows is 0";
}

TEST(VersionsOfDefaults, AreFilledAsFarAsTheCallerKnows) {
  sideray_render_options options;
  std::memset(static_cast<void*>(&options), 0x77, sizeof(options));
  sideray_render_init(&options, offsetof(sideray_render_options, seed));
  EXPECT_EQ(options.size, offsetof(sideray_render_options, seed));
  EXPECT_EQ(options.width, 1280u);
  EXPECT_EQ(options.samples, 1u);
  EXPECT_EQ(options.seed, 0x77777777u);
}

TEST(VersionsOfScenes, OfLoadOptions) {
  sideray_load_options options = sideray_load_defaults();
  options.size = 3;
  sideray_content* content = nullptr;
  const Answer odd =
      answer([&](sideray_error* e) { return sideray_content_load("absent.glb", &options, &content, e); });
  EXPECT_EQ(odd.status, SIDERAY_INVALID_ARGUMENT);
  EXPECT_THAT(odd.message, HasSubstr("load options"));
  options.size = offsetof(sideray_load_options, time_s);
  const Answer shorter =
      answer([&](sideray_error* e) { return sideray_content_load("absent.glb", &options, &content, e); });
  EXPECT_THAT(shorter.message, HasSubstr("absent.glb")) << "the options are accepted, the file is not there";
}

// Built-in scenes are the program's: the library says so.
TEST(Content, OfABuiltInNameSaysHowToMakeAFile) {
  sideray_content* content = nullptr;
  const Answer named = answer([&](sideray_error* e) { return sideray_content_load("panes", nullptr, &content, e); });
  EXPECT_EQ(named.status, SIDERAY_INVALID_ARGUMENT);
  EXPECT_THAT(named.message, HasSubstr("built-in scenes come with the program"));
  EXPECT_THAT(named.message, HasSubstr("sideray make panes -o panes.glb"));
}

}  // namespace
}  // namespace sideray::tests::version_test
