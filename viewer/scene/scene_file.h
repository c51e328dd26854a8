// Holds the scene of a file and its surroundings, to be drawn at any time of its animation. Any threads, also at once.
#pragma once

#include <sideray/plan.h>

#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "scenes/builtin/surroundings.h"
#include "scenes/content/content.h"

namespace sideray::viewer {

struct SceneSource {
  std::string scene;          // a .gltf or .glb file, or a built-in scene
  std::string animation;      // "" = the first
  std::string variant;        // of the materials; "" = none
  bool default_light = true;  // a sun for files without lights
  scenes::Surroundings surroundings;
};

class SceneFile {
 public:
  // Throws Error with one line that says what is wrong.
  explicit SceneFile(const SceneSource& source);

  const SceneSource& source() const { return source_; }
  // Returns the content. Read only names and materials: other threads may move its objects.
  const scenes::Content& content() const { return content_; }
  bool moves() const { return scenes::moves(content_); }
  double length_s() const;  // of its longest animation; 0 = none
  double radius() const { return radius_; }  // half the diagonal of the scene's bounds

  // Returns the file's camera `index` at a time; if the file has no camera, one that frames everything.
  sideray_camera camera(size_t index, double time_s, float aspect);
  sideray_camera framing(float aspect);

  // Returns the scene at a time. `selected`: the option ray-traced, "" = auto; its "largest:K" means the objects that
  // look largest from `camera` at this size. Throws Error if the selection does not fit the scene.
  const Scene& at(double time_s, const std::string& selected, const sideray_camera& camera, uint32_t width, uint32_t height);
  // Returns whether the object was selected when the scene was last drawn.
  bool is_traced(size_t object);
  sideray_scene_facts facts();

  // Returns whether the file of the scene or of its surroundings has changed since it was read or since the last call.
  // Main thread.
  bool has_changed();

 private:
  using Times = std::vector<std::filesystem::file_time_type>;
  Times file_times() const;
  void move_to(double time_s);

  SceneSource source_;
  Times seen_;
  std::mutex mutex_;
  scenes::Content content_;
  Scene scene_;
  double time_s_ = 0, radius_ = 1;
  std::string selection_ = "auto";
  std::vector<bool> traced_;
};

}  // namespace sideray::viewer
