// Loads scenes on another thread. Main thread.
#pragma once

#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <string>

#include "viewer/scene/scene_file.h"

namespace sideray::viewer {

class Loader {
 public:
  // `wake` is called on another thread when a scene is loaded or has failed.
  explicit Loader(std::function<void()> wake) : wake_(std::move(wake)) {}

  // Loads a scene. One that is still being loaded cannot be stopped; it is dropped at its end.
  void load(const SceneSource& source);
  bool is_loading() const { return loading_.valid(); }
  // Returns the last requested scene.
  const SceneSource& latest() const { return next_ ? *next_ : source_; }

  struct Loaded {
    std::shared_ptr<SceneFile> scene;  // null: see error
    std::string error;
  };
  // Returns the scene that was loaded since the last call, if any.
  std::optional<Loaded> take();

 private:
  void begin();

  std::function<void()> wake_;
  SceneSource source_;
  std::optional<SceneSource> next_;
  std::future<Loaded> loading_;
};

}  // namespace sideray::viewer
