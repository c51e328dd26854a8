// Tests that the jobs of a frame finish separately: masks are ready while layers are still traced, and a job's failure
// does not affect others.
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "embed/faults/failing_gl.h"
#include "embed/hosts/small_host.h"

namespace sideray::tests::jobs_test {
namespace {

constexpr uint32_t masks_job = SIDERAY_JOB_MASKS, layers_job = SIDERAY_JOB_LAYERS;
constexpr uint32_t reflections_job = SIDERAY_JOB_REFLECTIONS, all_jobs = masks_job | layers_job | reflections_job;

// A host's shader that, while held, keeps layers and reflections waiting.
struct HeldShader {
  std::atomic<bool> hold{false};

  static void call(void* user, const sideray_shading_point*, size_t count, sideray_shading_result* results) {
    while (static_cast<HeldShader*>(user)->hold) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    for (size_t i = 0; i < count; ++i) results[i].radiance[0] = 0.25f;
  }
  sideray_shader_desc desc() {
    sideray_shader_desc d = sideray_shader_defaults();
    d.shade = call;
    d.user = this;
    return d;
  }
};

class Jobs : public testing::Test {
 protected:
  Jobs() : host_(gl::Context::create("auto", "")), failing_(host_.context()), program_(program()) {
    host_.scene().set_shader(shader_.desc());
    host_.scene().commit();
    const sideray_host_gl loader{sizeof(loader), FailingGl::get_proc_address, &failing_};
    sideray_error error{};
    EXPECT_EQ(sideray_service_create(host_.tracer(), &loader, &service_, &error), SIDERAY_OK) << error.message;
  }
  ~Jobs() override {
    shader_.hold = false;
    sideray_service_destroy(service_);
    host_.context().take_errors();
  }

  // Returns a program that uses everything that bind() sets.
  gl::Program program() const {
    return {host_.gl, "jobs", "#version 330\nvoid main() { gl_Position = vec4(0.0); }\n",
            std::string("#version 330\n") + sideray_glsl(330) +
                "uniform int light;\nout vec4 c;\nvoid main() { c = vec4(sideray_translucent(vec3(0.5), "
                "vec3(gl_FragCoord), 5u) * sideray_shadow(light) * sideray_ao(), 1.0); }\n"};
  }
  FrameInputs inputs(const char* name = "everything") const {
    FrameInputs in = host_.inputs();
    std::find_if(SmallHost::cases().begin(), SmallHost::cases().end(), [&](const auto& each) {
      return std::string(each.name) == name;
    })->ask(host_, in);
    return in;
  }
  sideray_ticket submit(const FrameInputs& in) {
    sideray_ticket ticket = 0;
    sideray_error error{};
    EXPECT_EQ(submit_frame(service_, in, ticket, &error), SIDERAY_OK) << error.message;
    return ticket;
  }
  sideray_status wait(sideray_ticket ticket, uint32_t jobs, int32_t timeout_ms = -1) {
    return sideray_service_wait_jobs(service_, ticket, jobs, timeout_ms, nullptr);
  }
  uint32_t finished(sideray_ticket ticket) {
    uint32_t jobs = ~0u;
    EXPECT_EQ(sideray_service_finished_jobs(service_, ticket, &jobs, nullptr), SIDERAY_OK);
    return jobs;
  }
  FrameOutputs newest() {
    FrameOutputs outputs;
    newest_of_each_kind(service_, 0, outputs);
    return outputs;
  }
  template <typename Outputs>
  std::vector<uint8_t> texels(const std::optional<Outputs>& outputs) {
    return outputs ? host_.texels(*outputs) : std::vector<uint8_t>();
  }
  template <typename Outputs>
  static sideray_ticket ticket_of(const std::optional<Outputs>& outputs) {
    return outputs ? outputs->ticket : 0;
  }
  // Holds texels of all three kinds from an undisturbed frame.
  struct Whole {
    std::vector<uint8_t> layers, masks, reflections;
  };
  Whole whole_frame(const FrameInputs& in) {
    EXPECT_EQ(wait(submit(in), all_jobs), SIDERAY_OK);
    const FrameOutputs out = newest();
    return {texels(out.layers), texels(out.masks), texels(out.reflections)};
  }

  HeldShader shader_;
  SmallHost host_;
  FailingGl failing_;
  gl::Program program_;
  sideray_service* service_ = nullptr;
};

TEST_F(Jobs, MasksAreThereWhileLayersAreTraced) {
  const FrameInputs in = inputs();
  const Whole whole = whole_frame(in);
  const sideray_ticket before = newest().ticket;
  EXPECT_FALSE(whole.masks.empty() || whole.layers.empty() || whole.reflections.empty());
  shader_.hold = true;
  const sideray_ticket ticket = submit(in);
  ASSERT_EQ(wait(ticket, masks_job), SIDERAY_OK);
  EXPECT_EQ(finished(ticket), masks_job);
  EXPECT_EQ(wait(ticket, layers_job, 20), SIDERAY_NOT_READY);
  EXPECT_EQ(wait(ticket, all_jobs, 0), SIDERAY_NOT_READY);
  const FrameOutputs out = newest();
  EXPECT_EQ(ticket_of(out.masks), ticket);
  EXPECT_EQ(ticket_of(out.layers), before);
  EXPECT_EQ(ticket_of(out.reflections), before);
  EXPECT_EQ(texels(out.masks) == whole.masks, true);
  EXPECT_EQ(finished(ticket), masks_job);
  shader_.hold = false;
  ASSERT_EQ(wait(ticket, layers_job), SIDERAY_OK);
  EXPECT_EQ(finished(ticket) & (masks_job | layers_job), masks_job | layers_job);
  ASSERT_EQ(wait(ticket, all_jobs), SIDERAY_OK);
  EXPECT_EQ(finished(ticket), all_jobs);
  EXPECT_EQ(texels(newest().layers) == whole.layers, true);
  EXPECT_EQ(texels(newest().reflections) == whole.reflections, true);
}

TEST_F(Jobs, ThatAFrameDoesNotHaveCountAsUploaded) {
  shader_.hold = true;
  const sideray_ticket ticket = submit(inputs("count in stencil"));
  EXPECT_EQ(wait(ticket, masks_job | reflections_job), SIDERAY_OK);
  EXPECT_EQ(wait(ticket, all_jobs, 20), SIDERAY_NOT_READY);
  EXPECT_EQ(finished(ticket), 0u);
  shader_.hold = false;
  EXPECT_EQ(wait(ticket, all_jobs), SIDERAY_OK);
  EXPECT_EQ(finished(ticket), layers_job);
  EXPECT_FALSE(newest().masks || newest().reflections);
}

TEST_F(Jobs, OfAFrameThatIsCancelledStayWhereTheyWereUploaded) {
  const FrameInputs in = inputs();
  const Whole whole = whole_frame(in);
  const sideray_ticket before = newest().ticket;
  shader_.hold = true;
  const sideray_ticket ticket = submit(in);
  ASSERT_EQ(wait(ticket, masks_job), SIDERAY_OK);
  ASSERT_EQ(sideray_service_cancel(service_, ticket, nullptr), SIDERAY_OK);
  shader_.hold = false;
  EXPECT_EQ(wait(ticket, all_jobs), SIDERAY_CANCELLED);
  EXPECT_EQ(wait(ticket, layers_job), SIDERAY_CANCELLED);
  EXPECT_EQ(wait(ticket, masks_job), SIDERAY_OK);
  EXPECT_EQ(finished(ticket), masks_job);
  const FrameOutputs out = newest();
  EXPECT_EQ(ticket_of(out.masks), ticket);
  EXPECT_EQ(ticket_of(out.layers), before);
  EXPECT_EQ(ticket_of(out.reflections), before);
  EXPECT_EQ(texels(out.layers) == whole.layers, true);
  EXPECT_EQ(texels(out.reflections) == whole.reflections, true);
  const Whole next = whole_frame(in);
  EXPECT_EQ(next.layers == whole.layers && next.masks == whole.masks && next.reflections == whole.reflections, true);
}

// A frame's jobs continue where one of them cannot be uploaded.
TEST_F(Jobs, FailAlone) {
  const FrameInputs in = inputs("reflections and layers");
  FrameInputs with_masks = in;
  with_masks.masks = inputs().masks;
  const Whole whole = whole_frame(in);
  shader_.hold = true;
  const sideray_ticket ticket = submit(with_masks);
  failing_.fail(FailingGl::Failure::allocation);
  EXPECT_EQ(wait(ticket, masks_job), SIDERAY_OUT_OF_MEMORY);
  EXPECT_TRUE(failing_.has_failed());
  failing_.fail(FailingGl::Failure::none);
  EXPECT_EQ(wait(ticket, layers_job, 20), SIDERAY_NOT_READY);
  shader_.hold = false;
  EXPECT_EQ(wait(ticket, layers_job | reflections_job), SIDERAY_OK);
  EXPECT_EQ(wait(ticket, all_jobs), SIDERAY_OUT_OF_MEMORY);
  EXPECT_EQ(finished(ticket), layers_job | reflections_job);
  const FrameOutputs out = newest();
  EXPECT_FALSE(out.masks);
  EXPECT_EQ(ticket_of(out.layers), ticket);
  EXPECT_EQ(texels(out.layers) == whole.layers && texels(out.reflections) == whole.reflections, true);
  EXPECT_EQ(wait(submit(with_masks), all_jobs), SIDERAY_OK);
  EXPECT_TRUE(newest().masks);
}

TEST_F(Jobs, ThatFailLeaveThoseUploadedBefore) {
  FrameInputs in = inputs();
  const Whole whole = whole_frame(in);
  const sideray_ticket before = newest().ticket;
  shader_.hold = true;
  in.layers->max_layers = 3;  // needs other textures
  const sideray_ticket ticket = submit(in);
  ASSERT_EQ(wait(ticket, masks_job), SIDERAY_OK);
  failing_.fail(FailingGl::Failure::allocation);
  shader_.hold = false;
  EXPECT_EQ(wait(ticket, layers_job), SIDERAY_OUT_OF_MEMORY);
  failing_.fail(FailingGl::Failure::none);
  EXPECT_EQ(wait(ticket, reflections_job), SIDERAY_OK);
  EXPECT_EQ(finished(ticket), masks_job | reflections_job);
  const FrameOutputs out = newest();
  EXPECT_EQ(ticket_of(out.masks), ticket);
  EXPECT_EQ(ticket_of(out.layers), before);
  EXPECT_EQ(texels(out.layers) == whole.layers && texels(out.masks) == whole.masks, true);
}

// The host draws with masks of this frame and layers of the previous one, of another rectangle.
TEST_F(Jobs, OutputsOfDifferentFramesAreBoundTogether) {
  FrameInputs in = inputs();
  whole_frame(in);
  const sideray_ticket before = newest().ticket;
  in.frame.source.x = 8;
  in.frame.source.width -= 8;
  shader_.hold = true;
  const sideray_ticket ticket = submit(in);
  ASSERT_EQ(wait(ticket, masks_job), SIDERAY_OK);
  const FrameOutputs out = newest();
  EXPECT_EQ(out.layers->ticket, before);
  EXPECT_EQ(out.layers->x, 0);
  EXPECT_EQ(out.masks->ticket, ticket);
  EXPECT_EQ(out.masks->x, 8);
  EXPECT_EQ(out.masks->width, SmallHost::width - 8);
  ASSERT_EQ(sideray_service_bind(service_, 0, program_.id(), 0, nullptr), SIDERAY_OK);
  const auto uniform = [&](const char* name) {
    std::array<float, 4> value{};
    host_.gl.GetUniformfv(program_.id(), program_.uniform(name), value.data());
    return value;
  };
  EXPECT_EQ(uniform("sideray_viewport")[0], 0.0f);
  EXPECT_EQ(uniform("sideray_cache_size")[0], static_cast<float>(SmallHost::width));
  EXPECT_EQ(uniform("sideray_mask_viewport")[0], 8.0f);
  EXPECT_EQ(uniform("sideray_mask_size")[0], static_cast<float>(SmallHost::width - 8));
  shader_.hold = false;
  ASSERT_EQ(wait(ticket, all_jobs), SIDERAY_OK);
  EXPECT_EQ(newest().layers->ticket, ticket);
  EXPECT_EQ(newest().layers->x, 8);
}

// With three frames in flight, each job's outputs come in the order of tickets, and no job is ahead of the jobs before
// it.
TEST_F(Jobs, OfSeveralFramesComeInOrder) {
  const FrameInputs in = inputs();
  const Whole whole = whole_frame(in);
  shader_.hold = true;
  const sideray_ticket tickets[] = {submit(in), submit(in), submit(in)};
  ASSERT_EQ(wait(tickets[0], masks_job), SIDERAY_OK);
  shader_.hold = false;
  FrameOutputs last = newest();
  while (finished(tickets[2]) != all_jobs) {
    ASSERT_EQ(sideray_service_advance(service_, nullptr), SIDERAY_OK);
    const FrameOutputs now = newest();
    EXPECT_GE(now.masks->ticket, last.masks->ticket);
    EXPECT_GE(now.layers->ticket, last.layers->ticket);
    EXPECT_GE(now.reflections->ticket, last.reflections->ticket);
    EXPECT_GE(now.masks->ticket, now.layers->ticket);
    last = now;
  }
  for (const sideray_ticket ticket : tickets) {
    EXPECT_EQ(wait(ticket, all_jobs), SIDERAY_OK);
    sideray_frame_stats stats{};
    stats.size = sizeof(stats);
    ASSERT_EQ(sideray_service_stats(service_, ticket, &stats, nullptr), SIDERAY_OK);
    EXPECT_EQ(stats.pixels_total, uint64_t{SmallHost::width} * SmallHost::height);
    EXPECT_GT(stats.rays_primary, 0u);
    EXPECT_EQ(stats.rays_ao, 0u) << "masks of the same inputs stay";
    EXPECT_GT(stats.rays_reflection, 0u);
  }
  EXPECT_EQ(texels(last.layers) == whole.layers && texels(last.masks) == whole.masks, true);
}

// Under a budget too short for any job, the job that waited longest traces.
class JobsInTurns : public Jobs {
 protected:
  FrameInputs of_view(uint32_t view, const char* name) const {
    FrameInputs in = inputs(name);
    in.frame.view_id = view;
    in.frame.budget_ms = 1e-3f;
    return in;
  }
  // Keeps the worker busy with layers of view 0, outside of any budget.
  sideray_ticket keep_worker_busy() {
    shader_.hold = true;
    const sideray_ticket ticket = submit(inputs("count in stencil"));
    EXPECT_EQ(wait(ticket, layers_job, 20), SIDERAY_NOT_READY);
    return ticket;
  }
  void advance() { EXPECT_EQ(sideray_service_advance(service_, nullptr), SIDERAY_OK); }
  // Submits a frame whose jobs the budget expects: its depth is mapped, and the worker has taken none of them.
  sideray_ticket submit_expected(const FrameInputs& in) {
    const sideray_ticket ticket = submit(in);
    host_.gl.Finish();
    advance();
    return ticket;
  }
  void cancel(sideray_ticket ticket) {
    EXPECT_EQ(sideray_service_cancel(service_, ticket, nullptr), SIDERAY_OK);
    advance();
  }
  bool has_traced(sideray_ticket ticket) {
    EXPECT_EQ(wait(ticket, all_jobs), SIDERAY_OK);
    sideray_frame_stats stats{};
    stats.size = sizeof(stats);
    EXPECT_EQ(sideray_service_stats(service_, ticket, &stats, nullptr), SIDERAY_OK);
    return stats.rays_shadow + stats.rays_ao > 0;
  }
  // Lets all jobs of view 1 but one wait for a frame, so that they go before a job that has not waited.
  void let_view_1_wait() { EXPECT_EQ(wait(submit(of_view(1, "everything")), all_jobs), SIDERAY_OK); }
};

// One of the cancelled frames is in the worker's queue, the other waits for it.
TEST_F(JobsInTurns, GoOnAtOnceWhereAnotherViewsFramesAreCancelled) {
  let_view_1_wait();
  const sideray_ticket busy = keep_worker_busy();
  const sideray_ticket queued = submit_expected(of_view(1, "everything"));
  const sideray_ticket waiting = submit_expected(of_view(1, "everything"));
  cancel(waiting);
  cancel(queued);
  shader_.hold = false;
  EXPECT_EQ(wait(busy, layers_job), SIDERAY_OK);
  EXPECT_EQ(wait(queued, all_jobs), SIDERAY_CANCELLED);
  EXPECT_EQ(wait(waiting, all_jobs), SIDERAY_CANCELLED);
  EXPECT_TRUE(has_traced(submit(of_view(2, "masks"))));
}

TEST_F(JobsInTurns, WaitForAnotherViewsFrameWhoseNextOneIsCancelledWhileItIsRead) {
  let_view_1_wait();
  const sideray_ticket busy = keep_worker_busy();
  const sideray_ticket masks = submit_expected(of_view(2, "masks"));
  const sideray_ticket expected = submit_expected(of_view(1, "everything"));
  cancel(submit(of_view(1, "everything")));
  shader_.hold = false;
  EXPECT_EQ(wait(busy, layers_job), SIDERAY_OK);
  EXPECT_FALSE(has_traced(masks));
  EXPECT_EQ(wait(expected, all_jobs), SIDERAY_OK);
}

// The sun is a point and the pane, turned toward the wall, is matt: only bounced light draws random numbers.
TEST_F(Jobs, DrawBouncedLightByTheSeed) {
  constexpr float corners[] = {-1, -1, -1, 1, -1, 1, 1, 1, 1, -1, 1, -1};
  constexpr uint32_t indices[] = {0, 1, 2, 0, 2, 3};
  sideray_mesh_desc mesh = sideray_mesh_defaults();
  mesh.vertex_count = 4, mesh.index_count = 6;
  mesh.positions.data = corners, mesh.indices = indices;
  sideray_material_desc matt = sideray_material_defaults();
  matt.alpha_mode = SIDERAY_BLEND, matt.base_color[3] = 0.5f, matt.double_sided = 1, matt.specular = 0;
  sideray_instance_desc pane{};
  pane.mesh = host_.scene().add_mesh(mesh), pane.material = host_.scene().add_material(matt);
  for (int i : {0, 4, 8}) pane.world_from_object[i] = 0.5;
  pane.world_from_object[11] = 1.0;
  pane.surface_id = SmallHost::glass_id, pane.visibility = SIDERAY_VISIBLE_ALL;
  sideray_light sun = sideray_light_defaults();
  sun.type = SIDERAY_LIGHT_DIRECTIONAL;
  sun.direction[2] = -1.0f, sun.intensity[0] = 1.0f;
  const sideray_instance before = host_.pane();
  host_.scene().replace_instances({&before, 1}, {&pane, 1});
  host_.scene().set_lights({&sun, 1});
  host_.scene().set_built_in_shader();
  host_.scene().commit();
  const auto layers = [&](uint32_t seed, bool bounces) {
    FrameInputs in = inputs("count in stencil");
    in.frame.seed = seed;
    in.layers->denoise = 0;
    if (bounces) in.irradiance = sideray_irradiance_inputs_defaults();
    EXPECT_EQ(wait(submit(in), all_jobs | SIDERAY_JOB_IRRADIANCE), SIDERAY_OK);
    return texels(newest().layers);
  };
  EXPECT_EQ(SmallHost::difference(layers(1, false), layers(2, false)), "");
  EXPECT_EQ(SmallHost::difference(layers(1, true), layers(1, true)), "");
  EXPECT_NE(SmallHost::difference(layers(1, true), layers(2, true)), "");
}

TEST_F(Jobs, ThatAskForNothingAreRefusedByName) {
  const auto refused = [&](const FrameInputs& in, sideray_status expected, const char* named) {
    sideray_ticket ticket = 0;
    sideray_error error{};
    EXPECT_EQ(submit_frame(service_, in, ticket, &error), expected) << named;
    EXPECT_NE(std::string(error.message).find(named), std::string::npos) << error.message;
  };
  FrameInputs in = inputs();
  in.layers.reset();
  in.masks.reset();
  in.reflections.reset();
  refused(in, SIDERAY_INVALID_ARGUMENT, "no job");
  in.masks = sideray_mask_inputs_defaults();
  refused(in, SIDERAY_INVALID_ARGUMENT, "masks");
  in.masks->ao_rays = 1;
  in.masks->shadow_bias = -1.0f;
  refused(in, SIDERAY_INVALID_ARGUMENT, "shadow_bias");
  in.masks.reset();
  in.reflections = sideray_reflection_inputs_defaults();
  refused(in, SIDERAY_INVALID_ARGUMENT, "normal_texture");
  in.reflections.reset();
  in.layers = sideray_layer_inputs_defaults();
  in.layers->mode = SIDERAY_COMPOSITE;
  in.layers->refraction = 1;
  in.layers->ray_reuse = 0.1f;
  refused(in, SIDERAY_INVALID_ARGUMENT, "refraction");
  EXPECT_EQ(sideray_service_wait_jobs(service_, 1, 8, 0, nullptr), SIDERAY_INVALID_ARGUMENT);
  uint32_t jobs = 0;
  EXPECT_EQ(sideray_service_finished_jobs(service_, 77, &jobs, nullptr), SIDERAY_INVALID_ARGUMENT);
}

// The combined mask follows those of single lights; the snippet finds it for lights from number 32 on.
TEST_F(Jobs, CombinedLightsHaveAMaskOfTheirOwn) {
  std::vector<sideray_light> lights(40);
  for (sideray_light& light : lights) {
    light.size = sizeof(light);
    light.direction[2] = -1.0f;
    for (float& c : light.intensity) c = 1.0f;
  }
  host_.scene().set_lights(lights);
  host_.scene().commit();
  FrameInputs in = inputs("masks");
  in.masks->shadow_lights = 5;
  in.masks->combined_lights = 1;
  ASSERT_EQ(wait(submit(in), all_jobs), SIDERAY_OK);
  const sideray_mask_outputs out = newest().masks.value();
  EXPECT_EQ(out.shadow_lights, 5u);
  EXPECT_EQ(out.combined_lights, 1);
  host_.gl.BindTexture(GL_TEXTURE_2D_ARRAY, out.shadow_texture);
  GLint layers = 0;
  host_.gl.GetTexLevelParameteriv(GL_TEXTURE_2D_ARRAY, 0, GL_TEXTURE_DEPTH, &layers);
  host_.gl.BindTexture(GL_TEXTURE_2D_ARRAY, 0);
  EXPECT_EQ(layers, 3);
  ASSERT_EQ(sideray_service_bind(service_, 0, program_.id(), 0, nullptr), SIDERAY_OK);
  GLint combined = -1;
  host_.gl.GetUniformiv(program_.id(), program_.uniform("sideray_combined_layer"), &combined);
  EXPECT_EQ(combined, 3);
  // All lights are equal: the combined mask is dark where a single one is, apart from filters.
  in.masks->denoise = 0;
  ASSERT_EQ(wait(submit(in), all_jobs), SIDERAY_OK);
  const std::vector<uint8_t> texels = host_.texels(newest().masks.value());
  const size_t plane = size_t{SmallHost::width} * SmallHost::height;
  EXPECT_TRUE(std::equal(texels.begin(), texels.begin() + static_cast<ptrdiff_t>(plane),
                         texels.begin() + static_cast<ptrdiff_t>(2 * plane)));
  EXPECT_GT(std::count(texels.begin(), texels.begin() + static_cast<ptrdiff_t>(plane), uint8_t{0}), 20);
}

}  // namespace
}  // namespace sideray::tests::jobs_test
