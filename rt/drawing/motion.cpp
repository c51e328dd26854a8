#include "rt/drawing/motion.h"

#include <glm/gtc/matrix_transform.hpp>

#include "model/mesh.h"
#include "model/wind.h"
#include "rt/base/view_rays.h"
#include "rt/drawing/view_tile.h"

namespace sideray::rt {
namespace {

constexpr double least_w = 1e-6;  // a smaller w, or a negative one, would project far outside

// Describes an instance in the previous frame.
struct Before {
  const model::Instance* then = nullptr;  // null: it has not moved
  const model::Mesh* shape = nullptr;     // null: its vertices have not moved
};

class MotionPass {
 public:
  MotionPass(const MotionRequest& request, const OpaquePixels& pixels, TracedScene& scene, std::vector<glm::vec2>& motion)
      : request_(request),
        pixels_(pixels),
        now_(*scene.committed()),
        rays_(request.view, pixels.width, pixels.height),
        motion_(motion),
        half_size_(0.5 * pixels.width, 0.5 * pixels.height),
        origin_moved_(now_.origin - request.before->origin),
        before_from_local_(glm::translate(request.clip_from_local_before, origin_moved_)) {
    glm::dmat4 unmoved(1.0);
    unmoved[3] = glm::dvec4(-request.jitter, 0.0, 1.0);
    view_stands_ = unmoved * request.view.clip_from_local == before_from_local_;
    before_.resize(now_.instances.size());
    if (&now_ == request.before) return;
    for (uint32_t i = 0; i < now_.instances.size(); ++i) {
      before_[i].shape = model::shaped_before(now_, now_.instances[i].mesh, *request.before);
      before_[i].then = model::elsewhere_before(now_, i, *request.before, before_[i].shape != nullptr);
      if (!before_[i].then) before_[i].shape = nullptr;
    }
  }

  void move(size_t index, ViewTile& tile) const {
    tile.aim(rays_, pixels_.width, pixels_.height, index);
    for (size_t i = 0; i < tile.pixels.size(); ++i) {
      const glm::uvec2 p = tile.pixels[i];
      const size_t texel = size_t{p.y} * pixels_.width + p.x;
      motion_[texel] = motion_of(p, tile.rays[i], pixels_.hits[texel]);
    }
  }

 private:
  glm::vec2 motion_of(glm::uvec2 pixel, const Ray& ray, const Hit& hit) const {
    const glm::dvec3 direction(ray.direction);
    if (hit.instance == no_instance)
      return view_stands_ || request_.sky_stays ? glm::vec2(0.0f) : since(pixel, before_from_local_ * glm::dvec4(direction, 0.0));
    const auto of_view = [&] {
      if (view_stands_) return glm::vec2(0.0f);
      return since(pixel, before_from_local_ * glm::dvec4(glm::dvec3(ray.origin) + hit.distance * direction, 1.0));
    };
    if (is_thin(hit)) return of_view();
    const model::Instance& instance = now_.instances[hit.instance];
    const Before& before = before_[hit.instance];
    const bool swayed = instance.wind != 0 && now_.time_s != request_.before->time_s;
    if (!before.then && !swayed) return of_view();
    const model::Instance& placed = before.then ? *before.then : instance;
    const glm::vec3 place = placed.local_from_object * glm::vec4(object_place(instance, before, hit), 1.0f);
    return since(pixel, (before.then ? request_.clip_from_local_before : before_from_local_) * glm::dvec4(place, 1.0));
  }

  // Returns where the point that a ray hit was in the mesh in the previous frame.
  glm::vec3 object_place(const model::Instance& instance, const Before& before, const Hit& hit) const {
    const model::Mesh& mesh = before.shape ? *before.shape : *now_.meshes[instance.mesh];
    const glm::uvec3 t = mesh.triangles[hit.primitive];
    glm::vec3 corners[] = {mesh.positions[t.x], mesh.positions[t.y], mesh.positions[t.z]};
    if (instance.wind != 0) {
      const model::Wind& wind = now_.winds[instance.wind - 1];
      const glm::vec3 phase = model::wind_phase(wind, request_.before->time_s, instance.wind_phase);
      for (glm::vec3& corner : corners) corner = moved_by_wind(wind, phase, corner);
    }
    return corners[0] * (1.0f - hit.u - hit.v) + corners[1] * hit.u + corners[2] * hit.v;
  }

  glm::vec2 since(glm::uvec2 pixel, const glm::dvec4& before) const {
    if (!(before.w > least_w)) return glm::vec2(8.0 * half_size_);
    const glm::dvec2 now = (glm::dvec2(pixel) + 0.5) / half_size_ - 1.0 - request_.jitter;
    return glm::vec2((now - glm::dvec2(before) / before.w) * half_size_);
  }

  const MotionRequest& request_;
  const OpaquePixels& pixels_;
  const model::Snapshot& now_;
  ViewRays rays_;
  std::vector<glm::vec2>& motion_;
  glm::dvec2 half_size_;
  glm::dvec3 origin_moved_;
  glm::dmat4 before_from_local_;  // from this frame's local space
  bool view_stands_ = false;
  std::vector<Before> before_;  // by instance
};

}  // namespace

std::vector<glm::vec2> trace_motion(const MotionRequest& request, const OpaquePixels& pixels, TracedScene& scene) {
  std::vector<glm::vec2> motion(pixels.hits.size(), glm::vec2(0.0f));
  if (!request.before) return motion;
  const MotionPass pass(request, pixels, scene, motion);
  std::vector<ViewTile> tiles(scene.executor().threads());
  scene.executor().run(ViewTile::tiles_in(pixels.width, pixels.height),
                       [&](size_t tile, uint32_t thread) { pass.move(tile, tiles[thread]); });
  return motion;
}

}  // namespace sideray::rt
