#include "cli/session/session.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <string_view>

#include "cli/base/failure.h"
#include "scenes/builtin/builtin.h"
#include "scenes/builtin/surroundings.h"
#include "scenes/content/animation.h"

namespace sideray::cli {
namespace {

using scenes::Content;

double ms_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

float aspect_of(const RenderOptions& options) {
  return static_cast<float>(options.width()) / static_cast<float>(options.height());
}

struct ChosenCamera {
  sideray_camera camera;
  std::string name;             // for the stats
  std::optional<size_t> index;  // into the content's cameras, if it is one of them
};

sideray_camera projected(sideray_camera camera, const RenderOptions& options) {
  const std::optional<Projection>& p = options.projection;
  if (!p) return camera;
  if (camera.orthographic) wrong_usage("--intrinsics: the camera is orthographic; choose another with --camera");
  camera.yfov = p->yfov, camera.fx_per_fy = p->fx_per_fy;
  camera.shift_x = p->shift_x, camera.shift_y = p->shift_y;
  return camera;
}

void warn_about_aspect(const scenes::Camera& camera, float aspect) {
  if (camera.camera.orthographic || camera.aspect <= 0 || std::abs(camera.aspect / aspect - 1.0f) <= 0.01f) return;
  print_warning(fmt::format("camera {}: its aspect ratio is {:.3f}, the picture's {:.3f}; the vertical angle is kept",
                            camera.name, camera.aspect, aspect));
}

ChosenCamera of_file(const Content& content, size_t index, const RenderOptions& options) {
  const scenes::Camera& camera = content.cameras[index];
  if (!options.projection) warn_about_aspect(camera, aspect_of(options));
  return {camera.camera, camera.name.empty() ? std::to_string(index) : camera.name, index};
}

// Returns a camera's index; a name takes precedence over an index.
size_t index_of_camera(const Content& content, const std::string& wanted) {
  for (size_t i = 0; i < content.cameras.size(); ++i)
    if (content.cameras[i].name == wanted) return i;
  size_t index = 0;
  const auto [end, error] = std::from_chars(wanted.data(), wanted.data() + wanted.size(), index);
  if (error == std::errc() && end == wanted.data() + wanted.size() && index < content.cameras.size()) return index;
  wrong_usage("--camera {}: no such camera; the scene has {}, see sideray info", wanted, content.cameras.size());
}

ChosenCamera choose_camera(const RenderOptions& options, const Content& content) {
  if (const std::optional<FreeCamera>& c = options.free_camera)
    return {scenes::look_at(c->eye.data(), c->target.data(), c->fov_deg), "", {}};
  if (!options.camera.empty()) return of_file(content, index_of_camera(content, options.camera), options);
  if (!content.cameras.empty()) return of_file(content, 0, options);
  return {scenes::framing_camera(content, aspect_of(options)), "framed", {}};
}

scenes::Surroundings surroundings_of(const RenderOptions& options) {
  return {options.environment, options.environment_scale, options.environment_rotation_deg};
}

Renderer make_renderer(const RenderOptions& options) {
  sideray_renderer_desc desc = sideray_renderer_defaults();
  desc.gl = options.gl.c_str();
  desc.device = options.device.empty() ? nullptr : options.device.c_str();
  desc.threads = options.threads;
  desc.isa = options.isa.empty() ? nullptr : options.isa.c_str();
  Result<Renderer> renderer = Renderer::create(desc);
  // A device or instruction set that does not exist is wrong usage, not a failure of the machine.
  if (!renderer && renderer.error().status == SIDERAY_INVALID_ARGUMENT) throw UsageError(renderer.error().message);
  Renderer made = std::move(renderer).value();
  const sideray_device_info& device = made.device();
  if (std::string_view(device.gl) == "none" && *device.reason != '\0')
    print_warning(fmt::format("no OpenGL: rays alone draw (--gl none): {}", device.reason));
  // softpipe's fragment shaders lack gl_PrimitiveID, which ids of opaque surfaces need.
  if (std::string_view(device.renderer).starts_with("softpipe"))
    print_warning("OpenGL device softpipe: it draws no opaque surface; unset GALLIUM_DRIVER, or set it to llvmpipe");
  return made;
}

Content load(const RenderOptions& options) {
  try {
    return scenes::load(options.scene, {.animation = options.animation, .variant = options.variant,
                                         .time_s = options.time_s,
                                         .default_light = options.default_light});
  } catch (const scenes::UnknownScene& error) {
    throw UsageError(error.what());
  } catch (const scenes::UnknownAnimation& error) {
    throw UsageError(error.what());
  } catch (const scenes::UnknownVariant& error) {
    throw UsageError(error.what());
  }
}

// Returns what pose() changes in a scene: everything but cameras.
std::vector<double> pose_of(const Content& content) {
  std::vector<double> pose;
  const auto add = [&](const auto& values) { pose.insert(pose.end(), std::begin(values), std::end(values)); };
  if (const scenes::Rig* rig = content.rig.get()) {
    for (const scenes::Attached& a : rig->objects) add(content.objects[a.index].world_from_object);
    for (const scenes::Attached& a : rig->lights) {
      add(content.lights[a.index].light.position);
      add(content.lights[a.index].light.direction);
    }
    for (const scenes::AnimatedLight& a : rig->light_values) {
      const sideray_light& light = content.lights[a.light].light;
      add(light.intensity);
      add(std::array{light.range, light.inner_cone, light.outer_cone});
    }
    for (const scenes::AnimatedMaterial& a : rig->materials) {
      const sideray_material_desc& desc = content.materials[a.shown.front().material].desc;
      const auto* bytes = reinterpret_cast<const unsigned char*>(&desc);
      add(std::vector<unsigned char>(bytes, bytes + sizeof(desc)));
    }
    for (const scenes::SkinnedMesh& skinned : rig->skinned) {
      add(content.meshes[skinned.mesh].positions);
      add(content.meshes[skinned.mesh].normals);
    }
    for (const scenes::MorphedMesh& morphed : rig->morphed) {
      const scenes::Mesh& mesh = content.meshes[morphed.mesh];
      for (const auto* values : {&mesh.positions, &mesh.normals, &mesh.tangents, &mesh.uv0, &mesh.uv1, &mesh.colors})
        add(*values);
    }
  }
  for (const scenes::Emitter& emitter : content.emitters)
    for (const sideray_sprite& sprite : emitter.sprites) {
      add(sprite.position);
      add(sprite.color);
      add(std::array{sprite.width, sprite.height, sprite.rotation, sprite.cell});
    }
  return pose;
}

// Returns the animation's name for the stats.
std::string played(const RenderOptions& options, const Content& content) {
  if (!options.animation.empty()) return options.animation;
  return content.animations.empty() ? "" : content.animations[0].name;
}

}  // namespace

void SceneChecks::check(const RenderOptions& options) {
  const std::string light = options.default_light ? "lit" : "unlit";
  const Loaded wanted{options.scene, options.animation, options.variant, light};
  if (!passed_.insert({wanted, options.camera, options.environment}).second) return;
  if (loaded_ != wanted) {
    content_ = load(options);
    loaded_ = wanted;
  }
  if (!options.free_camera && !options.camera.empty()) (void)index_of_camera(content_, options.camera);
  scenes::check_surroundings(surroundings_of(options));
}

Session::Session(const RenderOptions& options) : scene_(Scene::create().value()) {
  const auto start = std::chrono::steady_clock::now();
  content_ = load(options);
  for (const std::string& warning : content_.warnings) print_warning(warning);
  const ChosenCamera chosen = choose_camera(options, content_);
  camera_ = projected(chosen.camera, options);
  camera_name_ = chosen.name;
  camera_index_ = chosen.index;
  time_s_ = time_before_s_ = options.time_s;
  scene_.set_time(time_s_, time_before_s_);
  scenes::set_surroundings(scene_, surroundings_of(options));
  load_ms_ = ms_since(start);
}

std::vector<bool> Session::ray_traced(const RenderOptions& options) const {
  const bool is_hybrid = options.translucency() == SIDERAY_TRANSLUCENCY_HYBRID;
  try {
    return scenes::select_ray_traced(content_, is_hybrid ? options.named["ray-traced"] : "all", camera_,
                                     options.width(), options.height());
  } catch (const Error& error) {
    throw UsageError(error.what());
  }
}

// Sets which objects have layers. Methods without layers keep the last choice, since a change would rebuild everything.
void Session::select(const RenderOptions& options) {
  if (filled_ && options.translucency() != SIDERAY_TRANSLUCENCY_HYBRID) return;
  const std::vector<bool> traced = ray_traced(options);
  if (filled_ == traced) return;
  if (filled_) {
    scenes::set_traced(scene_, content_, traced);
  } else {
    const auto start = std::chrono::steady_clock::now();
    scenes::fill(scene_, content_, traced);
    (is_loaded_ ? pose_ms_ : load_ms_) += ms_since(start);
    is_loaded_ = true;
  }
  filled_ = traced;
}

void Session::move_to(const RenderOptions& options) {
  pose_ms_ = 0;
  const double time_before_s =
      options.frames && options.continues ? options.time_s - 1.0 / options.frames->fps : options.time_s;
  if ((options.time_s == time_s_ && time_before_s == time_before_s_) || !scenes::moves(content_)) return;
  const auto start = std::chrono::steady_clock::now();
  const std::vector<double> before = pose_of(content_);
  scenes::pose(content_, options.time_s);
  time_s_ = options.time_s;
  time_before_s_ = time_before_s;
  scene_.set_time(time_s_, time_before_s_);
  if (camera_index_) camera_ = projected(content_.cameras[*camera_index_].camera, options);
  // Commits only changes: a commit updates all acceleration structures, which a moving camera does not need.
  if (filled_ && (!content_.winds.empty() || pose_of(content_) != before)) scenes::move(scene_, content_);
  pose_ms_ = ms_since(start);
}

// Does not open a device, since a plan needs none.
bool Session::draws_by_rays(const RenderOptions& options) const {
  if (renderer_) return std::string_view(renderer_->device().gl) == "none";
  return options.gl == "none";
}

Session::Planned Session::plan(const RenderOptions& options) {
  select(options);
  const sideray_render_options picture = options.picture();
  sideray_plan* plan = nullptr;
  const auto create = draws_by_rays(options) ? &sideray_plan_create_without_gl : &sideray_plan_create;
  check([&](sideray_error* error) { return create(scene_.get(), &picture, &plan, error); });
  Planned planned{PlanHandle(plan), {}};
  planned.run.camera = camera_name_;
  planned.run.animation = played(options, content_);
  planned.run.layers = sideray_plan_layers(plan);
  planned.run.ray_reuse = sideray_plan_ray_reuse(plan);
  planned.run.ao = sideray_plan_ao(plan) != 0;
  planned.run.bounce = sideray_plan_bounce(plan) != 0;
  planned.run.reflections = sideray_plan_reflections(plan) != 0;
  return planned;
}

sideray_scene_facts Session::facts(const RenderOptions& options) {
  select(options);
  sideray_scene_facts facts{};
  facts.size = sizeof(facts);
  check([&](sideray_error* error) { return sideray_plan_scene(scene_.get(), &facts, error); });
  return facts;
}

sideray_device_info Session::device(const RenderOptions& options) {
  if (!renderer_) renderer_ = make_renderer(options);
  return renderer_->device();
}

// Returns the stages of a picture with those that the session times. Only the first traced picture builds, but later
// ones depend on that, so all report it.
std::vector<sideray_stage_time> Session::stages_of(const Picture& picture) {
  std::vector<sideray_stage_time> stages = picture.stages();
  const auto stage = [&](sideray_stage wanted) -> sideray_stage_time& {
    return *std::find_if(stages.begin(), stages.end(), [&](const sideray_stage_time& s) { return s.stage == wanted; });
  };
  const auto set_all = [](sideray_stage_time& time, double ms) { time.p25 = time.median = time.p75 = ms; };
  sideray_stage_time &build = stage(SIDERAY_STAGE_BUILD), &update = stage(SIDERAY_STAGE_UPDATE);
  build_ms_ = std::max(build_ms_, build.median);
  if (build.median > 0 || update.median > 0) set_all(build, build_ms_);
  for (double sideray_stage_time::*quartile :
       {&sideray_stage_time::p25, &sideray_stage_time::median, &sideray_stage_time::p75})
    update.*quartile += pose_ms_;
  set_all(stage(SIDERAY_STAGE_LOAD), load_ms_);
  return stages;
}

ObjectTruths Session::object_truths(const RenderOptions& options, const std::vector<uint32_t>& surfaces,
                                    const std::vector<uint32_t>& objects) {
  if (!truth_tracer_) {
    sideray_tracer_desc desc = sideray_tracer_defaults();
    desc.threads = options.threads;
    desc.isa = options.isa.empty() ? nullptr : options.isa.c_str();
    truth_tracer_ = Tracer::create(scene_, desc).value();
  }
  sideray_object_truth_desc desc = sideray_object_truth_defaults();
  desc.camera = &camera_;
  desc.width = options.width(), desc.height = options.height();
  desc.surface_ids = surfaces.data(), desc.objects = objects.data();
  desc.count = surfaces.size();
  return ObjectTruths::create(*truth_tracer_, desc).value();
}

Session::Drawn Session::draw(const RenderOptions& options) {
  const sideray_device_info drawing = device(options);
  RenderRun run = plan(options).run;
  run.device = drawing;
  run.raw_frame = sideray_raw_frame_defaults();
  sideray_diagnostics diagnostics = options.diagnostics;
  if (options.raw_frame) diagnostics.raw_frame = &run.raw_frame;
  sideray_render_options drawn = options.picture();
  drawn.diagnostics = &diagnostics;
  Picture picture = renderer_->render(scene_, camera_, drawn).value();
  run.stats = picture.stats();
  run.stages = stages_of(picture);
  std::vector<std::string> light_names;
  for (const scenes::Light& light : content_.lights) light_names.push_back(light.name);
  return {std::move(picture), std::move(run), std::move(light_names)};
}

}  // namespace sideray::cli
