#include "bridge/renderer/renderer.h"

#include <algorithm>
#include <cstdlib>
#include <string>
#include <utility>

#include "bridge/base/host_gl.h"
#include "bridge/drawing/frame_timer.h"
#include "bridge/drawing/views.h"
#include "bridge/options/check_options.h"
#include "bridge/plan/cull_angle.h"
#include "bridge/plan/rays_alone.h"
#include "bridge/raster/raster_backend.h"
#include "bridge/rays/ray_backend.h"
#include "bridge/renderer/measurement.h"
#include "bridge/renderer/positions.h"
#include "bridge/renderer/reference_picture.h"
#include "gl/resources/host_context.h"
#include "model/failure.h"
#include "model/stopwatch.h"
#include "rt/scene/scene_difference.h"

namespace sideray::bridge {
namespace {

struct BackendCall {
  explicit BackendCall(Backend& called) : backend(called) { backend.begin_call(); }
  ~BackendCall() { backend.end_call(); }
  BackendCall(const BackendCall&) = delete;
  BackendCall& operator=(const BackendCall&) = delete;
  Backend& backend;
};

void describe_scene(const model::Snapshot& snapshot, sideray_render_stats& stats) {
  for (const model::Instance& instance : snapshot.instances) {
    stats.triangles += snapshot.meshes[instance.mesh]->triangles.size();
    stats.translucent_objects += snapshot.materials[instance.material].translucent ? 1 : 0;
  }
  stats.instances = snapshot.instances.size();
  stats.materials = snapshot.materials.size();
}

// Returns whether two commits show the same picture. Wind and sprites always move.
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
    FrameTimer untimed(job.backend, FrameTimer::Mode::off);
    draw_positions(job, untimed, picture);
    if (job.options.picture.repeats > 0) measure(job, picture);
  }
  describe_scene(*job.snapshot, picture.stats);
}

// Returns the OpenGL platform: desc.gl, or if that is "auto", the environment variable SIDERAY_GL if it is set.
std::string choice_of(const sideray_renderer_desc& desc) {
  const std::string given = desc.gl ? desc.gl : "auto";
  const char* variable = std::getenv("SIDERAY_GL");
  return given == "auto" && variable && *variable ? variable : given;
}

std::unique_ptr<Backend> open_backend(const sideray_renderer_desc& desc) {
  if (desc.host) {
    const sideray_host_gl host = read_host(desc.host);
    return std::make_unique<RasterBackend>(gl::host_context(host.get_proc_address, host.user));
  }
  const std::string choice = choice_of(desc), device = desc.device ? desc.device : "";
  if (choice == "none") {
    if (!device.empty())
      fail(SIDERAY_INVALID_ARGUMENT, "device \"{}\" with gl \"none\": no device is used; leave one of them out", device);
    return std::make_unique<RayBackend>("");
  }
  try {
    return std::make_unique<RasterBackend>(gl::Context::create(choice, device));
  } catch (const Failure& failure) {
    if (choice != "auto" || !device.empty() || failure.status != SIDERAY_NO_DEVICE) throw;
    return std::make_unique<RayBackend>(failure.what());
  }
}

}  // namespace

Renderer::Renderer(const sideray_renderer_desc& desc)
    : Renderer(open_backend(desc), {desc.threads, desc.isa ? desc.isa : ""}) {}

Renderer::Renderer(std::unique_ptr<gl::Context> context, rt::TracerConfig tracer_config)
    : Renderer(std::make_unique<RasterBackend>(std::move(context)), std::move(tracer_config)) {}

Renderer::Renderer(std::unique_ptr<Backend> backend, rt::TracerConfig tracer_config)
    : backend_(std::move(backend)),
      sequence_(std::make_unique<Sequence>(*backend_)),
      tracer_config_(std::move(tracer_config)) {}

// Destroys the backend first: it owns OpenGL objects and uses the tracer.
Renderer::~Renderer() {
  drawn_.helpers.clear();
  sequence_.reset();
  backend_.reset();
}

std::unique_ptr<Picture> Renderer::render(sideray_scene* scene, const sideray_camera& camera,
                                          const RenderOptions& options) {
  check({&camera, 1}, options);
  cancelled_ = false;
  const BackendCall call(*backend_);
  set_scene(scene);
  const FramePlan plan = plan_frame(*snapshot_, options, backend_->drawing());
  sequence_->begin(plan, {camera, options, snapshot_});
  if (auto picture = sequence_->done()) {
    state_counters({}, picture->stats);
    picture->stages = {};
    picture->stats.repeats = options.picture.repeats;
    return picture;
  }
  return draw_next(plan, camera, options);
}

void Renderer::check(std::span<const sideray_camera> cameras, const RenderOptions& options) const {
  for (const sideray_camera& camera : cameras) check_camera(camera);
  check_options(options);
  if (backend_->drawing() == Drawing::rays) check_rays_alone(options);
}

std::unique_ptr<Picture> Renderer::draw_next(const FramePlan& plan, const sideray_camera& camera,
                                             const RenderOptions& options) {
  backend_->resize(plan.width, plan.height);
  auto picture = std::make_unique<Picture>(plan.width, plan.height);
  prepare_rays(plan, camera, picture->stages);
  PictureJob job{*backend_, *sequence_, drawn_.tracer.get(), snapshot_, plan, camera, options, cancelled_};
  draw(job, *picture);
  backend_->require_no_errors();
  sequence_->keep(plan, {backend_->make_view(camera, glm::vec2(0)), snapshot_}, *picture);
  return picture;
}

std::vector<std::unique_ptr<Picture>> Renderer::render_many(sideray_scene* scene, std::span<const sideray_camera> cameras,
                                                            const RenderOptions& options) {
  check(cameras, options);
  if (options.picture.continues || options.is_bounded() || options.picture.repeats > 0)
    fail(SIDERAY_INVALID_ARGUMENT, "several pictures: each is one of its own, drawn once and whole; leave `continues`, `repeats` "
                                   "and budgets out");
  cancelled_ = false;
  const BackendCall call(*backend_);
  set_scene(scene);
  const FramePlan plan = plan_frame(*snapshot_, options, backend_->drawing());
  std::vector<std::unique_ptr<Picture>> pictures(cameras.size());
  for (size_t i = 0; i < pictures.size(); ++i) {
    // The first picture makes what all others share.
    if (i == 1 && draws_beside(plan, pictures.size() - i)) {
      draw_beside(plan, cameras.subspan(i), options, std::span(pictures).subspan(i));
      break;
    }
    sequence_->begin(plan, {cameras[i], options, snapshot_});
    pictures[i] = draw_next(plan, cameras[i], options);
  }
  return pictures;
}

// Returns whether each thread draws pictures of its own. That gains more than sharing one picture, unless there are too
// few. Large pictures keep all threads busy, and several at once would take much memory.
bool Renderer::draws_beside(const FramePlan& plan, size_t pictures) const {
  constexpr uint64_t most_pixels = 512 * 512;
  return plan.draws_by_rays() && !plan.reference && !snapshot_->shader.shade && drawn_.tracer->tracer.may_trace_beside() &&
         pictures >= drawn_.tracer->tracer.threads() && uint64_t{plan.width} * plan.height <= most_pixels;
}

void Renderer::draw_beside(const FramePlan& plan, std::span<const sideray_camera> cameras, const RenderOptions& options,
                           std::span<std::unique_ptr<Picture>> pictures) {
  const std::lock_guard turn(drawn_.tracer->turn);
  while (drawn_.helpers.size() < drawn_.tracer->tracer.threads()) {
    auto backend = std::make_unique<RayBackend>("");
    auto sequence = std::make_unique<Sequence>(*backend);
    drawn_.helpers.push_back({std::move(backend), std::move(sequence), std::make_unique<sideray_tracer>(*drawn_.tracer)});
  }
  drawn_.tracer->tracer.run(cameras.size(), [&](size_t i, uint32_t worker) {
    Helper& h = drawn_.helpers[worker];
    h.backend->set_scene(snapshot_);
    h.backend->set_tracer(h.tracer.get());
    h.backend->resize(plan.width, plan.height);
    h.sequence->begin(plan, {cameras[i], options, snapshot_});
    pictures[i] = std::make_unique<Picture>(plan.width, plan.height);
    PictureJob job{*h.backend, *h.sequence, h.tracer.get(), snapshot_, plan, cameras[i], options, cancelled_};
    draw(job, *pictures[i]);
  });
}

void Renderer::set_scene(sideray_scene* scene) {
  auto snapshot = scene->scene.snapshot();
  if (!snapshot) fail(SIDERAY_INVALID_ARGUMENT, "scene: nothing is committed; call sideray_scene_commit first");
  if (snapshot->fixed)
    fail(SIDERAY_UNSUPPORTED, "scene: it is shaded by the fixed function, which shades frames of hosts alone; call "
                              "sideray_scene_set_fixed_function with NULL and commit");
  if (scene != drawn_.scene.get())
    change_scene(scene);
  else if (snapshot_ && show_the_same(*snapshot_, *snapshot))
    return;
  snapshot_.reset();  // stays empty until the upload succeeds
  try {
    backend_->set_scene(snapshot);
  } catch (const Failure& failure) {
    if (failure.status != SIDERAY_OUT_OF_MEMORY || others_.empty()) throw;
    while (!others_.empty()) forget(others_.begin());
    backend_->set_scene(snapshot);
  }
  snapshot_ = std::move(snapshot);
}

// Releases the earlier scenes that only this renderer still holds.
void Renderer::change_scene(sideray_scene* scene) {
  constexpr size_t most_others = 3;
  sequence_->forget();
  if (drawn_.scene) others_.push_back(std::move(drawn_));
  drawn_ = {};
  const auto known = std::ranges::find_if(others_, [&](const DrawnScene& other) { return other.scene.get() == scene; });
  if (known != others_.end()) {
    drawn_ = std::move(*known);
    others_.erase(known);
  } else {
    sideray_scene_retain(scene);
    drawn_.scene.reset(scene);
  }
  backend_->change_scene(scene);
  for (auto other = others_.begin(); other != others_.end();)
    other = is_held_elsewhere(*other) ? other + 1 : forget(other);
  if (others_.size() > most_others) forget(others_.begin());
}

bool Renderer::is_held_elsewhere(const DrawnScene& drawn) {
  const uint32_t own = drawn.tracer ? 2 + static_cast<uint32_t>(drawn.helpers.size()) : 1;
  return drawn.scene->references > own;
}

// Frees the backend's part first, since it uses the tracer.
std::vector<Renderer::DrawnScene>::iterator Renderer::forget(std::vector<DrawnScene>::iterator other) {
  backend_->forget_scene(other->scene.get());
  return others_.erase(other);
}

void Renderer::prepare_rays(const FramePlan& plan, const sideray_camera& camera, StageTimes& stages) {
  backend_->set_culled({});
  if (!plan.uses_rays() && !plan.reference && !plan.ground_truth) return;
  const Stopwatch watch;
  const bool first = !drawn_.tracer;
  if (first) drawn_.tracer.reset(new sideray_tracer(drawn_.scene.get(), tracer_config_));
  if (plan.uses_rays()) backend_->set_tracer(drawn_.tracer.get());
  const std::lock_guard lock(drawn_.tracer->turn);
  rt::FoliageOptions foliage = plan.foliage;
  foliage.eye = backend_->make_view(camera, glm::vec2(0)).eye;
  foliage.cull_angle_deg = cull_angle_deg(camera, foliage.cull_angle_deg);
  drawn_.tracer->tracer.set_foliage(foliage);
  drawn_.tracer->tracer.set_glass_shadows(plan.glass_shadows);
  drawn_.tracer->use(snapshot_);
  backend_->set_culled(drawn_.tracer->tracer.culled());
  stages.set(first ? SIDERAY_STAGE_BUILD : SIDERAY_STAGE_UPDATE, watch.ms());
}

}  // namespace sideray::bridge
