// scenes.h for C++20: glTF files. Header-only; contracts are those of scenes.h.
#pragma once

#include <sideray/scenes.h>

#include <sideray/sideray.hpp>

namespace sideray {

class Content {
 public:
  // Loads a .gltf or .glb file.
  static Result<Content> load(const std::string& path, const sideray_load_options& options = sideray_load_defaults()) {
    sideray_error error{};
    sideray_content* content = nullptr;
    if (sideray_content_load(path.c_str(), &options, &content, &error) != SIDERAY_OK) return error;
    return Content(content);
  }
  sideray_content* get() const { return handle_.get(); }

  // Returns the names of the file's material variants, which sideray_load_options::variant may hold.
  std::vector<std::string> variants() const {
    std::vector<std::string> names;
    for (size_t i = 0; i < sideray_content_variant_count(get()); ++i)
      names.emplace_back(sideray_content_variant_name(get(), i));
    return names;
  }
  size_t camera_count() const { return sideray_content_camera_count(get()); }
  // Returns a camera. If there is none, camera 0 frames the content in a picture of this width / height.
  sideray_camera camera(size_t index = 0, float aspect = 16.0f / 9.0f) const {
    sideray_camera camera = sideray_camera_defaults();
    check([&](sideray_error* e) { return sideray_content_camera(get(), index, aspect, &camera, e); });
    return camera;
  }
  // Fills an empty scene and commits it.
  void fill(const Scene& scene, const sideray_fill_options& options = sideray_fill_defaults()) const {
    check([&](sideray_error* e) { return sideray_content_fill(get(), &options, scene.get(), e); });
  }
  // Moves the content and the scene that it filled to another time.
  void move(const Scene& scene, double time_s, double previous_time_s) {
    check([&](sideray_error* e) { return sideray_content_move(get(), time_s, previous_time_s, scene.get(), e); });
  }

 private:
  struct Release {
    void operator()(sideray_content* content) const { sideray_content_release(content); }
  };
  explicit Content(sideray_content* content) : handle_(content) {}
  std::unique_ptr<sideray_content, Release> handle_;
};

}  // namespace sideray
