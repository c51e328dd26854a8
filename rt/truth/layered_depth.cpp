#include "rt/truth/layered_depth.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "rt/layers/frame_pixels.h"
#include "rt/reference/ray_batches.h"
#include "rt/surfaces/surface_batch.h"
#include "rt/truth/path_frame.h"
#include "rt/truth/surface_walk.h"

namespace sideray::rt {
namespace {

constexpr size_t pixels_in_layer_chunk = 1024;  // for any thread count

sideray_surface_kind kind_of(const model::Material& material) {
  if (material.desc.transmission > 0.0f) return material.desc.thickness > 0.0f ? SIDERAY_KIND_VOLUME : SIDERAY_KIND_THIN;
  if (material.translucent) return SIDERAY_KIND_BLEND;
  return material.desc.alpha_mode == SIDERAY_MASK ? SIDERAY_KIND_MASK : SIDERAY_KIND_OPAQUE;
}

sideray_surface_face face_of(const model::Material& material, const Hit& hit) {
  if (hit.front) return SIDERAY_FACE_FRONT;
  return material.cull_back ? SIDERAY_FACE_HIDDEN_BACK : SIDERAY_FACE_BACK;
}

// Describes a surface that a pixel sees.
struct LayerMet {
  Hit hit;
  const Ray* ray;  // the ray that hit it
  double length;   // of the path from the camera to the ray's origin
  glm::vec3 normal, geometric_normal;
};

// Writes the requested values of each layer.
class LayerWriter {
 public:
  LayerWriter(const LayeredDepthRequest& request, const model::Snapshot& snapshot)
      : out_(request.wanted), depth_plane_(request.depth_plane), snapshot_(snapshot) {}

  void write(const PixelRequest& p, std::span<const LayerMet> layers) const {
    const size_t pixel = size_t{out_.height - 1 - p.y} * out_.width + p.x;
    if (out_.counts) out_.counts[pixel] = static_cast<uint32_t>(layers.size());
    for (uint32_t k = 0; k < out_.layers; ++k) {
      const size_t entry = pixel * out_.layers + k;
      if (k < layers.size())
        write_layer(entry, layers[k]);
      else
        write_nothing(entry);
    }
  }

 private:
  template <typename T, typename V>
  static void set(T* plane, size_t entry, V value) {
    if (plane) plane[entry] = static_cast<T>(value);
  }
  static void set_vector(float* plane, size_t entry, glm::vec3 v) {
    for (int c = 0; plane && c < 3; ++c) plane[3 * entry + static_cast<size_t>(c)] = v[c];
  }

  void write_layer(size_t entry, const LayerMet& layer) const {
    const model::Instance& instance = snapshot_.instances[layer.hit.instance];
    const model::Material& material = snapshot_.materials[instance.material];
    const model::Mesh& mesh = *snapshot_.meshes[instance.mesh];
    const glm::dvec3 point = glm::dvec3(layer.ray->origin) + layer.hit.distance * glm::dvec3(layer.ray->direction);
    set(out_.z, entry, glm::dot(depth_plane_, glm::dvec4(point, 1.0)));
    set(out_.distance, entry, layer.length + layer.hit.distance);
    set_vector(out_.normals, entry, layer.normal);
    set_vector(out_.geometric_normals, entry, layer.geometric_normal);
    set(out_.surface_ids, entry, instance.surface_id);
    set(out_.instances, entry, snapshot_.instance_names[layer.hit.instance].name);
    set(out_.primitives, entry,
        mesh.source_primitive.empty() ? layer.hit.primitive : mesh.source_primitive[layer.hit.primitive]);
    set(out_.kinds, entry, kind_of(material));
    set(out_.faces, entry, face_of(material, layer.hit));
  }

  void write_nothing(size_t entry) const {
    constexpr float nowhere = std::numeric_limits<float>::infinity();
    set(out_.z, entry, nowhere);
    set(out_.distance, entry, nowhere);
    set_vector(out_.normals, entry, glm::vec3(0.0f));
    set_vector(out_.geometric_normals, entry, glm::vec3(0.0f));
    set(out_.surface_ids, entry, 0u);
    set(out_.instances, entry, 0u);
    set(out_.primitives, entry, 0u);
    set(out_.kinds, entry, SIDERAY_KIND_NONE);
    set(out_.faces, entry, SIDERAY_FACE_NONE);
  }

  const sideray_layered_depth_desc& out_;
  const glm::dvec4 depth_plane_;
  const model::Snapshot& snapshot_;
};

// Refers to a layer whose normals are not computed yet.
struct Unmade {
  LayerMet* layer;
  size_t pixel;  // index in the chunk
};

// Is the scratch memory of one thread.
struct LayerWorker {
  std::vector<Ray> rays;
  std::vector<std::vector<LayerMet>> met;  // by pixel
  std::vector<uint32_t> found;             // by pixel, of one kind
  std::vector<Hit> opaque;
  RefractionTracer refraction;
  std::vector<PixelRequest> paths;
  std::vector<PathEnd> ends;
  std::vector<PathSurface> surfaces;
  std::vector<Unmade> unmade;
  std::vector<HitPlace> places;
  std::vector<SurfacePoint> points;
};

class LayerPass {
 public:
  LayerPass(const LayeredDepthRequest& request, const ShadingScene& scene, const Intersector& intersector,
            const RefractionScene* refraction)
      : wanted_(request.wanted),
        scene_(scene),
        intersector_(intersector),
        kernels_(shade_kernels(intersector.isa().c_str())),
        view_(request.view, wanted_.width, wanted_.height),
        writer_(request, *scene.snapshot) {
    if (refraction)
      paths_.emplace(request.view, view_, wanted_.width, wanted_.height, scene, intersector, *refraction);
  }

  void trace(std::span<const PixelRequest> pixels, LayerWorker& w) {
    w.rays.clear();
    for (const PixelRequest& p : pixels) w.rays.push_back(view_.ray(p.x, p.y));
    w.met.resize(pixels.size());
    for (std::vector<LayerMet>& of_pixel : w.met) of_pixel.clear();
    w.unmade.clear();
    if (wanted_.path == SIDERAY_LAYERS_STRAIGHT)
      find_straight(w);
    else
      find_bent(pixels, w);
    make_normals(pixels, w);
    for (size_t i = 0; i < pixels.size(); ++i) writer_.write(pixels[i], w.met[i]);
  }

 private:
  // Finds the nearest surfaces of each kind and merges both kinds in one order.
  void find_straight(LayerWorker& w) const {
    SurfaceWalk walk(*scene_.snapshot, intersector_, view_.alpha_cone(), false);
    const auto meet = [&](uint32_t i, const Hit& hit) {
      w.met[i].push_back({hit, &w.rays[i], 0.0, {}, {}});
      return ++w.found[i] < wanted_.layers;
    };
    w.found.assign(w.rays.size(), 0);
    walk.opaque(w.rays, meet);
    std::vector<uint32_t> opaque(w.rays.size(), 0);
    opaque.swap(w.found);
    walk.translucent(w.rays, meet);
    for (size_t i = 0; i < w.met.size(); ++i) {
      std::vector<LayerMet>& layers = w.met[i];
      std::inplace_merge(layers.begin(), layers.begin() + opaque[i], layers.end(),
                         [&](const LayerMet& a, const LayerMet& b) { return nearer(a.hit, id(a.hit), b.hit, id(b.hit)); });
      if (layers.size() > wanted_.layers) layers.resize(wanted_.layers);
      for (LayerMet& layer : layers) w.unmade.push_back({&layer, i});
    }
  }

  // Finds the surfaces that each path crosses, and its end.
  void find_bent(std::span<const PixelRequest> pixels, LayerWorker& w) {
    trace_drawn_surfaces(intersector_, view_.alpha_cone(), w.rays, w.opaque);
    w.paths.clear();
    w.ends.clear();
    w.surfaces.clear();
    for (size_t i = 0; paths_ && i < pixels.size(); ++i) {
      paths_->end_ray(pixels[i], w.rays[i], w.opaque[i]);
      w.paths.push_back(pixels[i]);
      w.paths.back().layers = wanted_.layers;
    }
    Counters unread;
    if (paths_) w.refraction.find_ends(paths_->context(), w.paths, w.ends, unread, &w.surfaces);
    for (const PathSurface& s : w.surfaces)
      w.met[s.path].push_back({s.hit, &s.ray, s.length, s.normal, s.geometric_normal});
    for (size_t i = 0; i < pixels.size(); ++i) add_end(i, w);
  }

  // A path that already hit the wanted number of translucent surfaces needs no end.
  void add_end(size_t i, LayerWorker& w) const {
    if (w.met[i].size() == wanted_.layers) return;
    const bool straight = !paths_ || w.ends[i].turns == 0;
    const Hit& end = straight ? w.opaque[i] : w.ends[i].opaque;
    if (end.instance == no_instance) return;
    w.met[i].push_back({end, straight ? &w.rays[i] : &w.ends[i].ray, straight ? 0.0 : w.ends[i].length, {}, {}});
    w.unmade.push_back({&w.met[i].back(), i});
  }

  void make_normals(std::span<const PixelRequest> pixels, LayerWorker& w) const {
    w.places.clear();
    for (const Unmade& u : w.unmade)
      w.places.push_back({&u.layer->hit, u.layer->ray, view_.cone(pixels[u.pixel].x, pixels[u.pixel].y)});
    w.points.clear();
    append_surfaces(scene_, kernels_, w.places, w.points);
    for (size_t i = 0; i < w.unmade.size(); ++i) {
      w.unmade[i].layer->normal = w.points[i].surface.normal;
      w.unmade[i].layer->geometric_normal = w.points[i].geometric_normal;
    }
  }

  uint32_t id(const Hit& hit) const { return scene_.snapshot->instances[hit.instance].surface_id; }

  const sideray_layered_depth_desc& wanted_;
  const ShadingScene& scene_;
  const Intersector& intersector_;
  const ShadeKernels& kernels_;
  const ViewRays view_;
  const LayerWriter writer_;
  std::optional<PathFrame> paths_;  // empty if nothing is translucent
};

}  // namespace

void LayeredDepthTracing::trace(const LayeredDepthRequest& request, TracedScene& scene) {
  const ShadingScene& shading = scene.shading();
  const bool crosses = request.wanted.path == SIDERAY_LAYERS_BENT &&
                       scene.intersector().has_translucent(LayerSet::all_translucent);
  LayerPass pass(request, shading, scene.intersector(), crosses ? &refraction_.of(shading.snapshot) : nullptr);
  const FramePixels frame = every_pixel(request.wanted.width, request.wanted.height, scene.executor());
  std::vector<LayerWorker> workers(scene.executor().threads());
  trace_in_chunks(frame, pixels_in_layer_chunk, scene.executor(), [&](std::span<const PixelRequest> pixels, uint32_t thread) {
    pass.trace(pixels, workers[thread]);
  });
}

}  // namespace sideray::rt
