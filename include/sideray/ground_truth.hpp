// ground_truth.h for C++20. Header-only; contracts are those of ground_truth.h.
#pragma once

#include <sideray/ground_truth.h>

#include <sideray/sideray.hpp>

namespace sideray {

// Returns the rays of sideray_camera_rays, top row first: rays[y * width + x].
inline std::vector<sideray_ray> camera_rays(const sideray_camera& camera, uint32_t width, uint32_t height) {
  std::vector<sideray_ray> rays(size_t{width} * height);
  check([&](sideray_error* e) {
    return sideray_camera_rays(&camera, width, height, rays.data(), sizeof(sideray_ray), e);
  });
  return rays;
}

// Fills the arrays that the description points to.
inline void layered_depth(const Tracer& tracer, const sideray_layered_depth_desc& desc) {
  check([&](sideray_error* e) { return sideray_tracer_layered_depth(tracer.get(), &desc, e); });
}

class ObjectTruths {
 public:
  static Result<ObjectTruths> create(const Tracer& tracer, const sideray_object_truth_desc& desc) {
    sideray_error error{};
    sideray_object_truths* truths = nullptr;
    if (sideray_object_truths_create(tracer.get(), &desc, &truths, &error) != SIDERAY_OK) return error;
    return ObjectTruths(truths);
  }
  size_t size() const { return sideray_object_truths_count(handle_.get()); }
  const sideray_object_truth& operator[](size_t index) const { return *sideray_object_truths_at(handle_.get(), index); }

 private:
  struct Release {
    void operator()(sideray_object_truths* truths) const { sideray_object_truths_release(truths); }
  };
  explicit ObjectTruths(sideray_object_truths* truths) : handle_(truths) {}
  std::unique_ptr<sideray_object_truths, Release> handle_;
};

}  // namespace sideray
