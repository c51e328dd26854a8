#include "viewer/scene/scene_file.h"

#include <algorithm>

#include "scenes/builtin/builtin.h"
#include "scenes/content/placement.h"

namespace sideray::viewer {
namespace {

double radius_of(const scenes::Content& content) {
  const scenes::Bounds bounds = scenes::bounds_of(content);
  return bounds.empty() ? 1.0 : std::max(0.5 * glm::length(bounds.maximum - bounds.minimum), 1e-6);
}

}  // namespace

SceneFile::SceneFile(const SceneSource& source)
    : source_(source),
      seen_(file_times()),
      content_(scenes::load(source.scene, {.animation = source.animation,
                                           .variant = source.variant,
                                           .default_light = source.default_light})),
      scene_(Scene::create().value()),
      radius_(radius_of(content_)) {
  scene_.set_time(0, 0);
  scenes::set_surroundings(scene_, source_.surroundings);
  traced_ = scenes::select_ray_traced(content_, selection_, framing(1.0f), 64, 64);
  scenes::fill(scene_, content_, traced_);
}

double SceneFile::length_s() const {
  double length = 0;
  for (const scenes::Animation& animation : content_.animations) length = std::max(length, animation.length_s);
  return length;
}

sideray_camera SceneFile::framing(float aspect) {
  const std::lock_guard lock(mutex_);
  return scenes::framing_camera(content_, aspect);
}

sideray_camera SceneFile::camera(size_t index, double time_s, float aspect) {
  const std::lock_guard lock(mutex_);
  if (index >= content_.cameras.size()) return scenes::framing_camera(content_, aspect);
  move_to(time_s);
  return content_.cameras[index].camera;
}

const Scene& SceneFile::at(double time_s, const std::string& selected, const sideray_camera& camera, uint32_t width,
                           uint32_t height) {
  const std::lock_guard lock(mutex_);
  move_to(time_s);
  const std::string selection = selected.empty() ? "auto" : selected;
  if (selection != selection_) {
    std::vector<bool> traced = scenes::select_ray_traced(content_, selection, camera, width, height);
    if (traced != traced_) scenes::set_traced(scene_, content_, traced);
    traced_ = std::move(traced);
    selection_ = selection;
  }
  return scene_;
}

bool SceneFile::is_traced(size_t object) {
  const std::lock_guard lock(mutex_);
  return object < traced_.size() && traced_[object];
}

sideray_scene_facts SceneFile::facts() {
  const std::lock_guard lock(mutex_);
  sideray_scene_facts facts{};
  facts.size = sizeof(facts);
  check([&](sideray_error* error) { return sideray_plan_scene(scene_.get(), &facts, error); });
  return facts;
}

void SceneFile::move_to(double time_s) {
  if (time_s == time_s_ || !scenes::moves(content_)) return;
  scenes::pose(content_, time_s);
  scene_.set_time(time_s, time_s_);
  scenes::move(scene_, content_);
  time_s_ = time_s;
}

SceneFile::Times SceneFile::file_times() const {
  Times times;
  for (const std::string& path : {source_.scene, source_.surroundings.name}) {
    std::error_code error;
    const auto time = std::filesystem::last_write_time(path, error);
    times.push_back(error ? std::filesystem::file_time_type{} : time);
  }
  return times;
}

bool SceneFile::has_changed() {
  Times now = file_times();
  const bool is_other = now != seen_;
  seen_ = std::move(now);
  return is_other;
}

}  // namespace sideray::viewer
