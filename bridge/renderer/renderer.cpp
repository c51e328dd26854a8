#include "bridge/renderer/renderer.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>

#include "bridge/base/local_view.h"
#include "bridge/renderer/reference_frame.h"
#include "bridge/renderer/trace_inputs.h"
#include "model/failure.h"
#include "rt/base/sampling.h"
#include "rt/layers/layer_check.h"

namespace sideray::bridge {
namespace {

struct CurrentContext {
  explicit CurrentContext(gl::Context& current) : context(current) { context.make_current(); }
  ~CurrentContext() { context.release_current(); }
  gl::Context& context;
};

void check_camera(const sideray_camera& c) {
  for (const double value : c.world_from_camera)
    if (!std::isfinite(value)) fail(SIDERAY_INVALID_ARGUMENT, "camera: world_from_camera is not finite");
  if (!(c.z_near > 0.0f) || !std::isfinite(c.z_near))
    fail(SIDERAY_INVALID_ARGUMENT, "camera z_near {}: give a finite distance above 0", c.z_near);
  if (!(c.z_far == 0.0f || c.z_far > c.z_near) || (c.orthographic && c.z_far == 0.0f))
    fail(SIDERAY_INVALID_ARGUMENT, "camera z_far {}: give more than z_near{}", c.z_far,
         c.orthographic ? "" : ", or 0 for infinite");
  if (!c.orthographic && !(c.yfov > 1e-4f && c.yfov < 3.13f))
    fail(SIDERAY_INVALID_ARGUMENT, "camera yfov {}: give radians between 0 and pi", c.yfov);
  if (c.orthographic && !(c.half_height > 0.0f && std::isfinite(c.half_height)))
    fail(SIDERAY_INVALID_ARGUMENT, "camera half_height {}: give a finite height above 0", c.half_height);
}

// The rasterizer's camera, as a host would state it: in world space.
sideray_view world_view(const gl::RasterView& view, glm::dvec3 origin) {
  sideray_view result{};
  const glm::dmat4 clip_from_world = glm::translate(view.clip_from_local, -origin);
  const glm::dmat4 world_from_clip = glm::translate(glm::dmat4(1.0), origin) * view.local_from_clip;
  std::copy_n(glm::value_ptr(clip_from_world), 16, result.clip_from_world);
  std::copy_n(glm::value_ptr(world_from_clip), 16, result.world_from_clip);
  result.reversed_depth = view.reversed_depth;
  result.zero_to_one_depth = view.zero_to_one_depth;
  return result;
}

gl::InexactMarks inexact_marks(const FramePlan& plan, const RenderOptions& o) {
  const bool neutral = plan.foliage.mode == SIDERAY_FOLIAGE_STATIC,
             unique = plan.foliage.mode == SIDERAY_FOLIAGE_UNIQUE;
  const uint32_t cap = plan.foliage.unique_cap == 0 ? UINT32_MAX : plan.foliage.unique_cap;
  return {.target = o.shadows.inexact_target,
          .rest = plan.fills_rest,
          .rest_copies = neutral ? 0 : std::max(plan.foliage.shared_copies, 1u),
          .rest_own = unique ? cap : 0};
}

template <typename T>
void add_to(std::vector<T>& sum, const std::vector<T>& values) {
  sum.resize(values.size(), T(0));
  for (size_t i = 0; i < values.size(); ++i) sum[i] += values[i];
}

}  // namespace

// The Halton sequence in bases 2 and 3 (Halton 1964), from its point 1.
glm::vec2 sample_jitter(uint32_t i, uint32_t samples) {
  if (samples <= 1) return glm::vec2(0);
  const auto radical_inverse = [](uint32_t n, uint32_t base) {
    double result = 0, digit = 1.0 / base;
    for (; n > 0; n /= base, digit /= base) result += (n % base) * digit;
    return result;
  };
  return {static_cast<float>(radical_inverse(i + 1, 2) - 0.5), static_cast<float>(radical_inverse(i + 1, 3) - 0.5)};
}

Renderer::Renderer(const sideray_renderer_desc& desc)
    : Renderer(gl::Context::create(desc.gl ? desc.gl : "auto", desc.device ? desc.device : ""),
               {desc.threads, desc.isa ? desc.isa : ""}) {}

Renderer::Renderer(std::unique_ptr<gl::Context> context, rt::TracerConfig tracer_config)
    : context_(std::move(context)), tracer_config_(std::move(tracer_config)) {
  const CurrentContext current(*context_);
  rasterizer_ = std::make_unique<gl::Rasterizer>(context_->functions());
}

Renderer::~Renderer() {
  {
    const CurrentContext current(*context_);
    service_.reset();
    rasterizer_.reset();
  }
  sideray_tracer_release(tracer_);
  sideray_scene_release(scene_);
}

std::unique_ptr<Picture> Renderer::render(sideray_scene* scene, const sideray_camera& camera,
                                          const RenderOptions& options) {
  check_camera(camera);
  check_options(options);
  const CurrentContext current(*context_);
  context_->take_errors();
  drawn_ = false;
  set_scene(scene);
  auto picture = std::make_unique<Picture>();
  picture->width = options.width;
  picture->height = options.height;
  picture->stats.size = sizeof(picture->stats);
  const FramePlan plan = plan_frame(*snapshot_, options);
  forget_before(plan, options);
  rasterizer_->resize(options.width, options.height);
  build(plan, camera, *picture);
  if (plan.reference) {
    draw_reference(plan, camera, options, *picture);
  } else if (plan.light_samples > 0 && options.repeats > 0) {
    draw_timed(plan, camera, options, *picture);
  } else {
    FrameTimer untimed(context_->functions(), FrameTimer::Mode::off);
    draw_picture(plan, camera, options, untimed, *picture);
    if (options.repeats > 0) measure(plan, camera, options, *picture);
  }
  describe_scene(*picture);
  require_no_gl_errors();
  keep_frame(plan, camera, options);
  return picture;
}

void Renderer::set_scene(sideray_scene* scene) {
  auto snapshot = scene->scene.snapshot();
  if (!snapshot) fail(SIDERAY_INVALID_ARGUMENT, "scene: nothing is committed; call sideray_scene_commit first");
  if (scene != scene_) {
    service_.reset();
    sideray_tracer_release(std::exchange(tracer_, nullptr));
    sideray_scene_retain(scene);
    sideray_scene_release(std::exchange(scene_, scene));
    before_ = {};
  }
  snapshot_ = std::move(snapshot);
  rasterizer_->set_scene(snapshot_);
}

void Renderer::build(const FramePlan& plan, const sideray_camera& camera, Picture& picture) {
  rasterizer_->set_culled({});
  if (!plan.uses_rays() && !plan.reference) return;
  const auto start = std::chrono::steady_clock::now();
  const bool first = !tracer_;
  if (first) tracer_ = new sideray_tracer(scene_, tracer_config_);
  if (plan.uses_rays() && !service_) service_ = std::make_unique<Service>(tracer_, context_->functions());
  const std::lock_guard lock(tracer_->turn);
  rt::FoliageOptions foliage = plan.foliage;
  foliage.eye = rasterizer_->make_view(camera, glm::vec2(0)).eye;
  if (camera.orthographic) foliage.cull_angle_deg = 0.0f;  // nothing looks smaller for being far
  tracer_->tracer.set_foliage(foliage);
  tracer_->use(snapshot_);
  rasterizer_->set_culled(tracer_->tracer.culled());
  const double ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  picture.stages.set(first ? SIDERAY_STAGE_BUILD : SIDERAY_STAGE_UPDATE, ms);
}

void Renderer::draw_opaque(const FramePlan& plan, const RenderOptions& options, FrameTimer& timer) {
  gl::Rasterizer& raster = *rasterizer_;
  const bool marks_in_gbuffer = plan.marks_inexact && options.shadows.inexact_target == SIDERAY_TARGET_BIT;
  timer.stage(SIDERAY_STAGE_GBUFFER, [&] { raster.gbuffer(marks_in_gbuffer); });
  if (plan.motion) timer.stage(SIDERAY_STAGE_GBUFFER, [&] { raster.motion(before_); });
  if (plan.shadow_maps) timer.stage(SIDERAY_STAGE_SHADOW_MAP, [&] { raster.shadow_maps(); });
  if (plan.masks) timer.stage(SIDERAY_STAGE_MASK, [&] { raster.mask(plan.mask_kind, plan.traced, plan.particles); });
  if (plan.marks_inexact) timer.stage(SIDERAY_STAGE_MASK, [&] { raster.mark_inexact(inexact_marks(plan, options)); });
}

Renderer::FrameResult Renderer::draw_frame(const FramePlan& plan, const gl::RasterView& view,
                                           const RenderOptions& options, FrameTimer& timer, bool count) {
  FrameResult result;
  const bool check = count && options.translucency.check && plan.fills_cache();
  gl::Rasterizer& raster = *rasterizer_;
  raster.set_view(view);
  draw_opaque(plan, options, timer);
  const sideray_ticket ticket = plan.uses_rays() ? start_trace(plan, view, options, check, timer.staged()) : 0;
  // The opaque picture is lit while the tracer works, where it needs nothing of it.
  if (plan.lights_by_rays()) service_->wait(ticket, SIDERAY_JOB_MASKS | SIDERAY_JOB_REFLECTIONS, -1);
  timer.stage(SIDERAY_STAGE_LIGHT, [&] { raster.light(plan.shadow_maps, occlusion(plan)); });
  if (plan.distorts) timer.stage(SIDERAY_STAGE_COMPOSITE, [&] { raster.distort(); });
  if (plan.uses_rays()) result.trace = finish_trace(ticket, timer);
  if (plan.second_wave) trace_second_wave(plan, view, options, ticket, timer, result.trace);
  if (plan.composites()) {
    sideray_layer_outputs outputs{};
    service_->layers(0, outputs);
    timer.stage(SIDERAY_STAGE_COMPOSITE,
                [&] { raster.composite_traced(outputs.radiance_texture, outputs.distance_texture); });
  }
  if (plan.rasters_translucency) draw_translucency(plan, options, timer, count, check, result);
  if (plan.averages) timer.stage(SIDERAY_STAGE_COMPOSITE, [&] { raster.average(before_); });
  return result;
}

rt::Counters Renderer::finish_trace(sideray_ticket ticket, FrameTimer& timer) {
  service_->wait(ticket, SIDERAY_JOB_ALL, -1);
  const rt::Counters stats = service_->stats(ticket);
  timer.add(SIDERAY_STAGE_READBACK, stats.readback_ms);
  timer.add(SIDERAY_STAGE_TRACE, stats.trace_ms);
  timer.add(SIDERAY_STAGE_TRACE_SHADOW, stats.trace_shadow_ms);
  timer.add(SIDERAY_STAGE_TRACE_AO, stats.trace_ao_ms);
  timer.add(SIDERAY_STAGE_DENOISE, stats.denoise_ms);
  timer.add(SIDERAY_STAGE_UPLOAD, stats.upload_ms);
  return stats;
}

void Renderer::draw_translucency(const FramePlan& plan, const RenderOptions& options, FrameTimer& timer,
                                 bool count, bool check, FrameResult& result) {
  gl::Translucency pass = translucency(plan, options);
  pass.count_fragments = count;
  gl::LayerTruth truth;
  if (check) {
    truth = {service_->truth().first, service_->truth().surfaces};
    pass.truth = &truth;
    result.duplicated = rt::count_duplicated(service_->cache(), service_->truth());
  }
  timer.stage(SIDERAY_STAGE_COMPOSITE, [&] { result.fragments = rasterizer_->translucency(pass); });
}

gl::OcclusionTextures Renderer::occlusion(const FramePlan& plan) const {
  gl::OcclusionTextures textures;
  sideray_mask_outputs masks{};
  if (plan.masks_occlusion() && service_->masks(0, masks)) {
    textures.shadow = masks.shadow_texture;
    textures.shadow_lights = masks.shadow_lights;
    textures.open = masks.ao_texture;
  }
  sideray_reflection_outputs reflections{};
  if (plan.reflections && service_->reflections(0, reflections)) textures.mirrored = reflections.reflection_texture;
  return textures;
}

gl::Translucency Renderer::translucency(const FramePlan& plan,
                                                    const RenderOptions& options) const {
  gl::Translucency pass;
  pass.shadows = plan.shadow_maps;
  pass.traced = plan.traced;
  pass.oit = options.translucency.oit;
  if (plan.traces) pass.front_layers = options.translucency.layers;
  if (plan.traces)
    pass.bind_cache = [this](uint32_t program, uint32_t unit) { service_->bind(0, program, unit, snapshot_->origin); };
  return pass;
}

FrameInputs Renderer::trace_inputs(const FramePlan& plan, const gl::RasterView& view,
                                   const RenderOptions& options) const {
  FrameInputs inputs = frame_inputs(plan, options);
  inputs.view = world_view(view, snapshot_->origin);
  inputs.source.framebuffer = rasterizer_->framebuffer();
  inputs.source.width = static_cast<int32_t>(options.width);
  inputs.source.height = static_cast<int32_t>(options.height);
  if (plan.motion) inputs.source.motion_texture = rasterizer_->motion_texture();
  if (plan.fills_rest && inputs.masks) inputs.masks->rest_texture = rasterizer_->rest_texture();
  if (inputs.reflections) inputs.reflections->normal_texture = rasterizer_->normal_texture();
  set_weights(plan, options, inputs.offscreen);
  return inputs;
}

// How the rasterizer is going to blend what the cache answers.
void Renderer::set_weights(const FramePlan& plan, const RenderOptions& options, Offscreen& offscreen) const {
  const bool needed = options.translucency.layer_threshold > 0.0f && plan.fills_cache();
  if (!needed) return;
  if (options.translucency.oit == SIDERAY_OIT_SORTED) {
    offscreen.weights = rt::LayerWeights::objects;
    offscreen.drawn = rasterizer_->places_of_objects();
  } else {
    offscreen.weights = rt::LayerWeights::fragments;
  }
}

sideray_ticket Renderer::start_trace(const FramePlan& plan, const gl::RasterView& view, const RenderOptions& options,
                                     bool check, bool timed) {
  FrameInputs inputs = trace_inputs(plan, view, options);
  inputs.offscreen.check = check;
  inputs.offscreen.redraws = std::exchange(drawn_, true);
  inputs.offscreen.timed = timed;
  return service_->submit(inputs);
}

void Renderer::draw_picture(const FramePlan& plan, const sideray_camera& camera, const RenderOptions& options,
                            FrameTimer& timer, Picture& picture) {
  std::vector<glm::vec4> sum;
  std::vector<glm::vec3> half_difference;
  for (uint32_t sample = 0; sample < options.samples; ++sample) {
    const gl::RasterView view = rasterizer_->make_view(camera, jitter(plan, options, sample));
    RenderOptions position = options;  // each with random numbers of its own
    if (sample > 0) position.seed = rt::random_key({options.seed, sample});
    const FrameResult frame = draw_frame(plan, view, position, timer, false);
    if (timer.staged()) add_counters(frame, picture.stats);
    const std::vector<glm::vec4> color = rasterizer_->read_color();
    if (plan.light_samples > 0) add_to(half_difference, service_->composite().half_difference);
    if (sample == 0) {
      sum = color;
      add_aovs(plan, view, options, picture);
    } else {
      add_to(sum, color);
    }
  }
  const auto positions = static_cast<float>(options.samples);
  if (options.samples > 1)
    for (glm::vec4& c : sum) c /= positions;
  for (glm::vec3& d : half_difference) d /= positions;
  add_color(picture, sum);
  if (plan.light_samples > 0) state_self_error(picture.stats, plan.light_samples, sum, half_difference);
}

void Renderer::describe_scene(Picture& picture) const {
  sideray_render_stats& stats = picture.stats;
  for (const model::Instance& instance : snapshot_->instances) {
    stats.triangles += snapshot_->meshes[instance.mesh]->triangles.size();
    stats.translucent_objects += snapshot_->materials[instance.material].translucent ? 1 : 0;
  }
  stats.instances = snapshot_->instances.size();
  stats.materials = snapshot_->materials.size();
}

void Renderer::require_no_gl_errors() {
  const std::vector<std::string> errors = context_->take_errors();
  if (!errors.empty())
    fail(SIDERAY_GL_FAILED, "OpenGL driver {}: {}; please report this with the driver's version ({})",
         context_->info().renderer, errors.front(), context_->info().version);
}

}  // namespace sideray::bridge
