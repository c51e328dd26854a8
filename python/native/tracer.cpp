// Provides queries: arrays of rays in, arrays of hits out.
#include <cstddef>
#include <sideray/ground_truth.hpp>

#include "python/native/native.h"

namespace sideray::python {
namespace {

struct TracerHandle {
  Tracer tracer;
  std::mutex mutex;

  TracerHandle(SceneHandle& s, uint32_t threads, const std::string& isa)
      : tracer([&] {
          sideray_tracer_desc desc = sideray_tracer_defaults();
          desc.threads = threads;
          desc.isa = isa.empty() ? nullptr : isa.c_str();
          py::gil_scoped_release released;
          const std::lock_guard lock(s.mutex);
          return Tracer::create(s.scene, desc).value();
        }()) {}
};

// Returns sideray_hit as a numpy type, so that hits need no copies.
py::dtype hit_type() {
  py::list names, formats, offsets;
  const auto field = [&](const char* name, const py::object& format, size_t offset) {
    names.append(name);
    formats.append(format);
    offsets.append(offset);
  };
  const auto sized = [](const char* format, int count) { return py::make_tuple(py::str(format), py::make_tuple(count)); };
  field("distance", py::str("f8"), offsetof(sideray_hit, distance));
  field("normal", sized("f4", 3), offsetof(sideray_hit, normal));
  field("barycentric", sized("f4", 2), offsetof(sideray_hit, u));
  field("surface_id", py::str("u4"), offsetof(sideray_hit, surface_id));
  field("instance", py::str("u4"), offsetof(sideray_hit, instance));
  field("primitive", py::str("u4"), offsetof(sideray_hit, primitive));
  return py::dtype(names, formats, offsets, sizeof(sideray_hit));
}

std::vector<sideray_ray> rays_of(const Array<double>& origins, const Array<float>& directions, const Array<float>& t_near,
                                 const Array<float>& t_far) {
  require_shape(origins, {-1, 3}, "origins");
  const py::ssize_t count = origins.shape(0);
  require_shape(directions, {count, 3}, "directions");
  require_shape(t_near, {count}, "t_near");
  require_shape(t_far, {count}, "t_far");
  std::vector<sideray_ray> rays(static_cast<size_t>(count));
  for (size_t i = 0; i < rays.size(); ++i) {
    std::copy_n(origins.data() + 3 * i, 3, rays[i].origin);
    std::copy_n(directions.data() + 3 * i, 3, rays[i].direction);
    rays[i].t_near = t_near.data()[i];
    rays[i].t_far = t_far.data()[i];
  }
  return rays;
}

py::array trace_rays(TracerHandle& t, const Array<double>& origins, const Array<float>& directions,
                     const Array<float>& t_near, const Array<float>& t_far, bool translucent, uint32_t layers) {
  const std::vector<sideray_ray> rays = rays_of(origins, directions, t_near, t_far);
  py::array hits(hit_type(), {static_cast<py::ssize_t>(rays.size()), static_cast<py::ssize_t>(layers)});
  sideray_ray_batch batch = sideray_ray_batch_defaults();
  batch.set = translucent ? SIDERAY_RAYS_TRANSLUCENT : SIDERAY_RAYS_OPAQUE;
  batch.layers = layers;
  batch.rays = rays.data();
  batch.count = rays.size();
  batch.hits = static_cast<sideray_hit*>(hits.mutable_data());
  call(t.mutex, [&](sideray_error* e) { return sideray_tracer_trace_rays(t.tracer.get(), &batch, e); });
  return hits;
}

py::dict fields_of(const sideray_object_mask& mask) {
  py::dict fields;
  fields["box"] = py::make_tuple(mask.x, mask.y, mask.width, mask.height);
  fields["area"] = mask.pixels;
  fields["runs"] = py::array_t<uint32_t>(static_cast<py::ssize_t>(mask.run_count), mask.runs);
  return fields;
}

py::list list_of(const ObjectTruths& truths) {
  py::list list;
  for (size_t i = 0; i < truths.size(); ++i) {
    py::dict fields;
    fields["object"] = truths[i].object;
    fields["visible"] = fields_of(truths[i].visible);
    fields["amodal"] = fields_of(truths[i].amodal);
    fields["coverage"] = truths[i].coverage;
    fields["visible_fraction"] = truths[i].visible_fraction;
    list.append(fields);
  }
  return list;
}

py::list object_truths(TracerHandle& t, const py::dict& camera, uint32_t width, uint32_t height,
                       uint32_t samples_per_side, bool through_glass, const std::optional<Array<uint32_t>>& surface_ids,
                       const std::optional<Array<uint32_t>>& objects) {
  const sideray_camera seen_from = camera_of(camera);
  sideray_object_truth_desc desc = sideray_object_truth_defaults();
  desc.camera = &seen_from;
  desc.width = width, desc.height = height;
  desc.samples_per_side = samples_per_side;
  desc.hidden_by = through_glass ? SIDERAY_HIDDEN_BY_OPAQUE : SIDERAY_HIDDEN_BY_ALL;
  if (surface_ids && objects) {
    require_shape(*objects, {surface_ids->size()}, "objects");
    desc.surface_ids = surface_ids->data(), desc.objects = objects->data();
    desc.count = static_cast<size_t>(surface_ids->size());
  }
  std::optional<ObjectTruths> truths;
  {
    py::gil_scoped_release released;
    const std::lock_guard lock(t.mutex);
    truths = ObjectTruths::create(t.tracer, desc).value();
  }
  return list_of(*truths);
}

py::dict layered_depth(TracerHandle& t, const py::dict& camera, uint32_t width, uint32_t height, uint32_t layers, bool bent) {
  const sideray_camera seen_from = camera_of(camera);
  sideray_layered_depth_desc desc = sideray_layered_depth_defaults();
  desc.camera = &seen_from;
  desc.width = width, desc.height = height, desc.layers = layers;
  desc.path = bent ? SIDERAY_LAYERS_BENT : SIDERAY_LAYERS_STRAIGHT;
  py::dict arrays;
  const bool refused = layers > 64 || width > 16384 || height > 16384;  // by the library: nothing is allocated
  const auto make = [&](const char* name, auto*& plane, std::vector<py::ssize_t> behind) {
    if (refused) return;
    std::vector<py::ssize_t> shape{py::ssize_t{height}, py::ssize_t{width}};
    shape.insert(shape.end(), behind.begin(), behind.end());
    py::array_t<std::remove_reference_t<decltype(*plane)>> array(shape);
    plane = array.mutable_data();
    arrays[name] = array;
  };
  const py::ssize_t depth = py::ssize_t{layers};
  make("count", desc.counts, {});
  make("z", desc.z, {depth});
  make("distance", desc.distance, {depth});
  make("normal", desc.normals, {depth, 3});
  make("geometric_normal", desc.geometric_normals, {depth, 3});
  make("surface_id", desc.surface_ids, {depth});
  make("instance", desc.instances, {depth});
  make("primitive", desc.primitives, {depth});
  make("kind", desc.kinds, {depth});
  make("face", desc.faces, {depth});
  call(t.mutex, [&](sideray_error* e) { return sideray_tracer_layered_depth(t.tracer.get(), &desc, e); });
  return arrays;
}

}  // namespace

void define_tracer(py::module_& module) {
  py::class_<TracerHandle>(module, "Tracer")
      .def(py::init<SceneHandle&, uint32_t, const std::string&>(), py::arg("scene"), py::arg("threads"), py::arg("isa"))
      .def("trace_rays", trace_rays, py::arg("origins"), py::arg("directions"), py::arg("t_near"), py::arg("t_far"),
           py::arg("translucent"), py::arg("layers"))
      .def("object_truths", object_truths, py::arg("camera"), py::arg("width"), py::arg("height"),
           py::arg("samples_per_side"), py::arg("through_glass"), py::arg("surface_ids"), py::arg("objects"))
      .def("layered_depth", layered_depth, py::arg("camera"), py::arg("width"), py::arg("height"), py::arg("layers"),
           py::arg("bent"));
}

}  // namespace sideray::python
