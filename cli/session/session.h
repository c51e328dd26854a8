// Draws configuration after configuration of one scene, with one camera and one renderer. Main thread.
#pragma once

#include <sideray/plan.h>

#include <array>
#include <memory>
#include <set>
#include <sideray/ground_truth.hpp>

#include "cli/options/render_options.h"
#include "cli/session/stats.h"
#include "scenes/content/content.h"

namespace sideray::cli {

struct ReleasePlan {
  void operator()(sideray_plan* plan) const { sideray_plan_release(plan); }
};
using PlanHandle = std::unique_ptr<sideray_plan, ReleasePlan>;

// Finds faults before a Session is made: in files, scenes, animations, variants, cameras.
class SceneChecks {
 public:
  // Throws UsageError or Error as Session does; prints nothing. Keeps the last content for the next call.
  void check(const RenderOptions& options);

 private:
  using Loaded = std::array<std::string, 4>;  // scene, animation, variant, whether files get a light
  std::set<std::tuple<Loaded, std::string, std::string>> passed_;  // also with camera and surroundings
  Loaded loaded_;
  scenes::Content content_;
};

class Session {
 public:
  // Takes SCENE, --camera and related options, --size, --env*, --gl, --device and --threads from `options` for its
  // lifetime. Prints the scene's warnings. Throws UsageError or Error.
  explicit Session(const RenderOptions& options);

  const scenes::Content& content() const { return content_; }
  const sideray_camera& camera() const { return camera_; }
  // Returns the device, which is opened if needed. Throws Error where nothing can be drawn.
  sideray_device_info device(const RenderOptions& options);
  bool draws_by_rays(const RenderOptions& options) const;

  // Throws UsageError where --ray-traced does not fit the scene.
  std::vector<bool> ray_traced(const RenderOptions& options) const;

  // Moves everything, also cameras, to the time of `options`. Throws Error.
  void move_to(const RenderOptions& options);

  struct Drawn {
    Picture picture;
    RenderRun run;
    std::vector<std::string> light_names;
  };
  Drawn draw(const RenderOptions& options);
  // Returns the truths of objects as the last picture shows them; surfaces[i] belongs to objects[i].
  ObjectTruths object_truths(const RenderOptions& options, const std::vector<uint32_t>& surfaces,
                             const std::vector<uint32_t>& objects);

  // Holds what draw() would do, found without a device; the statistics are empty.
  struct Planned {
    PlanHandle plan;
    RenderRun run;
  };
  Planned plan(const RenderOptions& options);
  // Returns the library's facts of the scene, with the layers that the options select.
  sideray_scene_facts facts(const RenderOptions& options);

 private:
  void select(const RenderOptions& options);
  std::vector<sideray_stage_time> stages_of(const Picture& picture);

  scenes::Content content_;
  std::string camera_name_;             // "" with --eye
  std::optional<size_t> camera_index_;  // into the content's cameras, if it is one of them
  sideray_camera camera_;
  Scene scene_;
  std::optional<Renderer> renderer_;         // created for the first picture
  std::optional<Tracer> truth_tracer_;       // created for the first object truths
  std::optional<std::vector<bool>> filled_;  // which objects have layers; empty until the first picture
  double time_s_ = 0;                        // time of the content's pose
  double time_before_s_ = 0;                 // time of the previous picture, for wind
  bool is_loaded_ = false;  // the scene has been filled
  double load_ms_ = 0, build_ms_ = 0, pose_ms_ = 0;
};

}  // namespace sideray::cli
