#include "bridge/renderer/renderer.h"

#include <utility>

#include "bridge/base/host_gl.h"
#include "bridge/options/check_options.h"
#include "bridge/plan/cull_angle.h"
#include "bridge/renderer/frame.h"
#include "bridge/renderer/measurement.h"
#include "bridge/renderer/positions.h"
#include "bridge/renderer/reference_picture.h"
#include "bridge/renderer/views.h"
#include "gl/resources/host_context.h"
#include "model/failure.h"
#include "model/stopwatch.h"
#include "rt/scene/scene_difference.h"

namespace sideray::bridge {
namespace {

struct CurrentContext {
  explicit CurrentContext(gl::Context& current) : context(current) { context.make_current(); }
  ~CurrentContext() { context.release_current(); }
  gl::Context& context;
};

void describe_scene(const model::Snapshot& snapshot, sideray_render_stats& stats) {
  for (const model::Instance& instance : snapshot.instances) {
    stats.triangles += snapshot.meshes[instance.mesh]->triangles.size();
    stats.translucent_objects += snapshot.materials[instance.material].translucent ? 1 : 0;
  }
  stats.instances = snapshot.instances.size();
  stats.materials = snapshot.materials.size();
}

// Commits that change nothing. What the wind moves and sprites do not stand still.
bool show_the_same(const model::Snapshot& a, const model::Snapshot& b) {
  const auto stands_still = [](const model::Snapshot& s) { return s.winds.empty() && s.particles.empty(); };
  return &a == &b || (stands_still(a) && stands_still(b) && rt::are_equal(a, b));
}

void draw(PictureJob& job, Picture& picture) {
  if (job.plan.reference) {
    draw_reference(job, picture);
  } else if (job.plan.layers.light_samples > 0 && job.options.picture.repeats > 0) {
    draw_timed(job, picture);
  } else {
    FrameTimer untimed(job.gl, FrameTimer::Mode::off);
    draw_positions(job, untimed, picture);
    if (job.options.picture.repeats > 0) measure(job, picture);
  }
  describe_scene(*job.snapshot, picture.stats);
}

std::unique_ptr<gl::Context> context_of(const sideray_renderer_desc& desc) {
  if (!desc.host) return gl::Context::create(desc.gl ? desc.gl : "auto", desc.device ? desc.device : "");
  const sideray_host_gl host = read_host(desc.host);
  return gl::host_context(host.get_proc_address, host.user);
}

}  // namespace

Renderer::Renderer(const sideray_renderer_desc& desc)
    : Renderer(context_of(desc), {desc.threads, desc.isa ? desc.isa : ""}) {}

Renderer::Renderer(std::unique_ptr<gl::Context> context, rt::TracerConfig tracer_config)
    : context_(std::move(context)), tracer_config_(std::move(tracer_config)) {
  const CurrentContext current(*context_);
  rasterizer_ = std::make_unique<gl::Rasterizer>(context_->functions());
  sequence_ = std::make_unique<Sequence>(*rasterizer_);
}

// Somebody else in the process may have terminated the display, or the driver lost the context: their objects are gone with
// them, and deleting those without a context does nothing.
Renderer::~Renderer() {
  try {
    context_->make_current();
  } catch (const Failure&) {
    if (service_) service_->abandon_context();
  }
  service_.reset();
  rasterizer_.reset();
  context_->release_current();
}

std::unique_ptr<Picture> Renderer::render(sideray_scene* scene, const sideray_camera& camera,
                                          const RenderOptions& options) {
  check_camera(camera);
  check_options(options);
  const CurrentContext current(*context_);
  context_->require_drawable();
  context_->take_errors();
  set_scene(scene);
  const FramePlan plan = plan_frame(*snapshot_, options);
  sequence_->begin(plan, {camera, options, snapshot_});
  if (auto picture = sequence_->done()) {
    state_counters({}, picture->stats);
    picture->stages = {};
    picture->stats.repeats = options.picture.repeats;
    return picture;
  }
  rasterizer_->resize(plan.width, plan.height);
  auto picture = std::make_unique<Picture>(plan.width, plan.height);
  prepare_rays(plan, camera, picture->stages);
  PictureJob job{context_->functions(), *rasterizer_, *sequence_, service_.get(), tracer_.get(), snapshot_, plan,
                 camera, options};
  draw(job, *picture);
  require_no_gl_errors();
  sequence_->keep(plan, {rasterizer_->make_view(camera, glm::vec2(0)), snapshot_}, *picture);
  return picture;
}

void Renderer::set_scene(sideray_scene* scene) {
  auto snapshot = scene->scene.snapshot();
  if (!snapshot) fail(SIDERAY_INVALID_ARGUMENT, "scene: nothing is committed; call sideray_scene_commit first");
  if (scene != scene_.get()) {
    service_.reset();
    tracer_.reset();
    sideray_scene_retain(scene);
    scene_.reset(scene);
    sequence_->forget();
  } else if (snapshot_ && show_the_same(*snapshot_, *snapshot)) {
    return;
  }
  snapshot_ = std::move(snapshot);
  rasterizer_->set_scene(snapshot_);
}

void Renderer::prepare_rays(const FramePlan& plan, const sideray_camera& camera, StageTimes& stages) {
  rasterizer_->set_culled({});
  if (!plan.uses_rays() && !plan.reference && !plan.ground_truth) return;
  const Stopwatch watch;
  const bool first = !tracer_;
  if (first) tracer_.reset(new sideray_tracer(scene_.get(), tracer_config_));
  if (plan.uses_rays() && !service_) service_ = std::make_unique<Service>(tracer_.get(), context_->functions());
  const std::lock_guard lock(tracer_->turn);
  rt::FoliageOptions foliage = plan.foliage;
  foliage.eye = rasterizer_->make_view(camera, glm::vec2(0)).eye;
  foliage.cull_angle_deg = cull_angle_deg(camera, foliage.cull_angle_deg);
  tracer_->tracer.set_foliage(foliage);
  tracer_->tracer.set_glass_shadows(plan.glass_shadows);
  tracer_->use(snapshot_);
  rasterizer_->set_culled(tracer_->tracer.culled());
  stages.set(first ? SIDERAY_STAGE_BUILD : SIDERAY_STAGE_UPDATE, watch.ms());
}

void Renderer::require_no_gl_errors() {
  const std::vector<std::string> errors = context_->take_errors();
  if (!errors.empty())
    fail(SIDERAY_GL_FAILED, "OpenGL driver {}: {}; please report this with the driver's version ({})",
         context_->info().renderer, errors.front(), context_->info().version);
}

}  // namespace sideray::bridge
