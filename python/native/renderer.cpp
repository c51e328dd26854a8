// Provides renderers and their pictures. Planes are arrays that share the picture's memory and keep it alive.
#include <cstring>

#include "python/native/native.h"
#include "python/native/structs.h"

namespace sideray::python {
namespace {

struct ReleasePicture {
  void operator()(sideray_picture* picture) const { sideray_picture_release(picture); }
};

struct PictureHandle {
  std::shared_ptr<sideray_picture> picture;
  uint32_t width = 0, height = 0;

  explicit PictureHandle(sideray_picture* drawn) : picture(drawn, ReleasePicture()) {
    sideray_picture_size(drawn, &width, &height);
  }
  // Returns an owner for an array, which keeps the picture alive.
  py::capsule owner() const {
    return py::capsule(new std::shared_ptr<sideray_picture>(picture),
                       [](void* kept) { delete static_cast<std::shared_ptr<sideray_picture>*>(kept); });
  }
};

template <typename T>
py::array plane_of(const PictureHandle& p, const sideray_channel& channel) {
  return py::array_t<T>({py::ssize_t{p.height}, py::ssize_t{p.width}}, static_cast<const T*>(channel.values), p.owner());
}

py::dict channels(const PictureHandle& p) {
  py::dict planes;
  for (size_t i = 0; i < sideray_picture_channel_count(p.picture.get()); ++i) {
    const sideray_channel& channel = *sideray_picture_channel(p.picture.get(), i);
    planes[channel.name] =
        channel.type == SIDERAY_CHANNEL_UINT ? plane_of<uint32_t>(p, channel) : plane_of<float>(p, channel);
  }
  return planes;
}

py::dict stats(const PictureHandle& p) {
  sideray_render_stats s{};
  s.size = sizeof(s);
  check([&](sideray_error* e) { return sideray_picture_stats(p.picture.get(), &s, e); });
  py::dict result;
#define SIDERAY_STAT(name) result[#name] = s.name
  SIDERAY_STAT(repeats);
  SIDERAY_STAT(triangles);
  SIDERAY_STAT(instances);
  SIDERAY_STAT(materials);
  SIDERAY_STAT(translucent_objects);
  SIDERAY_STAT(rays_primary);
  SIDERAY_STAT(rays_reflection);
  SIDERAY_STAT(rays_shadow);
  SIDERAY_STAT(rays_ao);
  SIDERAY_STAT(rays_bounce);
  SIDERAY_STAT(pixels_total);
  SIDERAY_STAT(pixels_masked);
  SIDERAY_STAT(layers_requested);
  SIDERAY_STAT(layers_found);
  SIDERAY_STAT(layers_matched);
  SIDERAY_STAT(layers_missed);
  SIDERAY_STAT(traversals_wasted);
  SIDERAY_STAT(layers_misassigned);
  SIDERAY_STAT(layers_duplicated);
  SIDERAY_STAT(pixels_late);
  SIDERAY_STAT(pixels_older);
  SIDERAY_STAT(mask_pixels_late);
  SIDERAY_STAT(mask_pixels_older);
  SIDERAY_STAT(answer_age);
  SIDERAY_STAT(reflection_pixels_late);
  SIDERAY_STAT(reflection_pixels_older);
  SIDERAY_STAT(jobs_starved);
  SIDERAY_STAT(positions);
  SIDERAY_STAT(dropped_particles);
  SIDERAY_STAT(layers_borrowed);
  SIDERAY_STAT(layers_refracted);
  SIDERAY_STAT(bytes_readback);
  SIDERAY_STAT(bytes_upload);
  SIDERAY_STAT(bytes_cache);
  SIDERAY_STAT(reference_light_samples);
  SIDERAY_STAT(reference_self_error);
  SIDERAY_STAT(threads);
  SIDERAY_STAT(isa);
  SIDERAY_STAT(embree);
#undef SIDERAY_STAT
  return result;
}

py::dict times(const PictureHandle& p) {
  py::dict result;
  for (size_t i = 0; i < sideray_picture_stage_count(p.picture.get()); ++i) {
    const sideray_stage_time& time = *sideray_picture_stage(p.picture.get(), i);
    result[time.name] = py::make_tuple(time.p25, time.median, time.p75);
  }
  return result;
}

class RendererHandle {
 public:
  RendererHandle(const std::string& gl, const std::string& device, uint32_t threads, const std::string& isa) {
    sideray_renderer_desc desc = sideray_renderer_defaults();
    desc.gl = gl.c_str();
    desc.device = device.empty() ? nullptr : device.c_str();
    desc.threads = threads;
    desc.isa = isa.empty() ? nullptr : isa.c_str();
    call(mutex_, [&](sideray_error* e) { return sideray_renderer_create(&desc, &renderer_, e); });
  }
  RendererHandle(const RendererHandle&) = delete;
  ~RendererHandle() { close(); }

  void close() {
    py::gil_scoped_release released;
    const std::lock_guard lock(mutex_);
    sideray_renderer_destroy(renderer_);
    renderer_ = nullptr;
  }

  // Cancels without the mutex, which the drawing call holds.
  void cancel() {
    require_open();
    sideray_renderer_cancel(renderer_);
  }

  PictureHandle render(const SceneHandle& scene, const py::dict& view, const OptionsHandle& options, uint32_t aovs,
                       uint32_t repeats, bool continues, float exposure, bool color) {
    const sideray_camera camera = camera_of(view);
    sideray_render_options drawn = options.options.render();
    drawn.aovs = aovs;
    drawn.repeats = repeats;
    drawn.continues = continues;
    drawn.exposure = exposure;
    drawn.without_color = !color;
    sideray_picture* picture = nullptr;
    call(mutex_, [&](sideray_error* e) {
      require_open();
      return sideray_renderer_render(renderer_, scene.scene.get(), &camera, &drawn, &picture, e);
    });
    return PictureHandle(picture);
  }

  // Returns one picture from each camera. Group g has the cameras from ends[g - 1] to ends[g]. `poses`, (groups,
  // instances, 12), has the transforms of `instances` in each group, `lights` the lights. Without both there is one
  // group.
  std::vector<PictureHandle> render_many(SceneHandle& scene, const std::vector<py::dict>& views, const OptionsHandle& options,
                                         uint32_t aovs, float exposure, bool color, const Array<uint32_t>& instances,
                                         const std::optional<Array<double>>& poses,
                                         const std::optional<std::vector<std::vector<py::dict>>>& lights,
                                         const std::vector<size_t>& ends) {
    std::vector<sideray_camera> cameras;
    for (const py::dict& view : views) cameras.push_back(camera_of(view));
    std::vector<std::vector<sideray_light>> lit(ends.size());
    for (size_t group = 0; lights && group < lit.size(); ++group)
      for (const py::dict& fields : lights->at(group)) lit[group].push_back(light_of(fields));
    const py::ssize_t moved = instances.size();
    if (poses) require_shape(*poses, {static_cast<py::ssize_t>(ends.size()), moved, 12}, "poses");
    sideray_render_options drawn = options.options.render();
    drawn.aovs = aovs;
    drawn.exposure = exposure;
    drawn.without_color = !color;
    std::vector<std::unique_ptr<sideray_picture, ReleasePicture>> pictures;
    {
      py::gil_scoped_release released;
      const std::scoped_lock lock(mutex_, scene.mutex);
      require_open();
      for (size_t group = 0, begin = 0; group < ends.size(); begin = ends[group++]) {
        if (lights)
          check([&](sideray_error* e) {
            return sideray_scene_set_lights(scene.scene.get(), lit[group].data(), lit[group].size(), e);
          });
        if (poses) {
          const double* placed = poses->data() + static_cast<py::ssize_t>(group) * moved * 12;
          check([&](sideray_error* e) {
            return sideray_scene_move_instances(scene.scene.get(), instances.data(), static_cast<size_t>(moved), placed, e);
          });
        }
        if (poses || lights) check([&](sideray_error* e) { return sideray_scene_commit(scene.scene.get(), e); });
        std::vector<sideray_picture*> made(ends[group] - begin);
        check([&](sideray_error* e) {
          return sideray_renderer_render_many(renderer_, scene.scene.get(), cameras.data() + begin, made.size(), &drawn,
                                              made.data(), e);
        });
        for (sideray_picture* picture : made) pictures.emplace_back(picture);
      }
    }
    std::vector<PictureHandle> handles;
    for (auto& picture : pictures) handles.emplace_back(picture.release());
    return handles;
  }

  py::dict device() {
    const sideray_device_info* info = nullptr;
    call(mutex_, [&](sideray_error* e) {
      require_open();
      return sideray_renderer_device(renderer_, &info, e);
    });
    py::dict result;
    result["id"] = info->id;
    result["gl"] = info->gl;
    result["renderer"] = info->renderer;
    result["version"] = info->version;
    result["reason"] = info->reason;
    return result;
  }

 private:
  void require_open() const {
    if (!renderer_) throw Error(SIDERAY_INVALID_ARGUMENT, "the renderer is closed; make another");
  }

  sideray_renderer* renderer_ = nullptr;
  std::mutex mutex_;
};

// Interleaves planes of one type and size, as (height, width, planes).
template <typename T>
py::array interleaved_of(const std::vector<py::array>& planes) {
  const py::ssize_t height = planes[0].shape(0), width = planes[0].shape(1);
  const auto count = static_cast<py::ssize_t>(planes.size());
  std::vector<const T*> from;
  for (const py::array& plane : planes) {
    require_shape(plane, {height, width}, "planes");
    from.push_back(static_cast<const T*>(plane.data()));
  }
  py::array_t<T> result({height, width, count});
  T* to = result.mutable_data();
  py::gil_scoped_release released;
  for (py::ssize_t i = 0; i < height * width; ++i)
    for (const T* plane : from) *to++ = plane[i];
  return result;
}

// Stacks planes of pictures of one size, as (pictures, height, width) if each has one plane, else (pictures, height,
// width, planes).
template <typename T>
void stack(const std::vector<std::vector<py::array>>& pictures, py::array& out) {
  const py::ssize_t height = pictures[0].at(0).shape(0), width = pictures[0][0].shape(1);
  const auto planes = static_cast<py::ssize_t>(pictures[0].size());
  std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(pictures.size()), height, width};
  if (planes > 1) shape.push_back(planes);
  require_shape(out, shape, "out");
  if (!py::isinstance<py::array_t<T>>(out) || !(out.flags() & py::array::c_style) || !out.writeable())
    throw Error(SIDERAY_INVALID_ARGUMENT, std::string("out: the array is not writable, not contiguous or not of ") +
                                              (std::is_same_v<T, float> ? "float32" : "uint32") + "; give one that is");
  std::vector<const T*> from;
  for (const std::vector<py::array>& picture : pictures)
    for (const py::array& plane : picture) {
      require_shape(plane, {height, width}, "planes");
      from.push_back(static_cast<const T*>(plane.data()));
    }
  T* to = static_cast<T*>(out.mutable_data());
  py::gil_scoped_release released;
  for (size_t first = 0; first < from.size(); first += static_cast<size_t>(planes))
    for (py::ssize_t i = 0; i < height * width; ++i)
      for (py::ssize_t k = 0; k < planes; ++k) *to++ = from[first + static_cast<size_t>(k)][i];
}

void stacked(const std::vector<std::vector<py::array>>& pictures, py::array out) {
  if (py::isinstance<py::array_t<uint32_t>>(pictures.at(0).at(0)))
    stack<uint32_t>(pictures, out);
  else
    stack<float>(pictures, out);
}

// Interleaves planes of float or uint32.
py::array interleaved(const std::vector<py::array>& planes) {
  const bool is_uint = py::isinstance<py::array_t<uint32_t>>(planes.at(0));
  return is_uint ? interleaved_of<uint32_t>(planes) : interleaved_of<float>(planes);
}

}  // namespace

void define_renderer(py::module_& module) {
  module.def("interleaved", interleaved, py::arg("planes"));
  module.def("stacked", stacked, py::arg("pictures"), py::arg("out"));
  py::class_<PictureHandle>(module, "Picture")
      .def_readonly("width", &PictureHandle::width)
      .def_readonly("height", &PictureHandle::height)
      .def("channels", channels)
      .def("stats", stats)
      .def("times", times);
  py::class_<RendererHandle>(module, "Renderer")
      .def(py::init<const std::string&, const std::string&, uint32_t, const std::string&>(), py::arg("gl"),
           py::arg("device"), py::arg("threads"), py::arg("isa"))
      .def("render", &RendererHandle::render, py::arg("scene"), py::arg("camera"), py::arg("options"), py::arg("aovs"),
           py::arg("repeats"), py::arg("continues"), py::arg("exposure"), py::arg("color"))
      .def("render_many", &RendererHandle::render_many, py::arg("scene"), py::arg("cameras"), py::arg("options"),
           py::arg("aovs"), py::arg("exposure"), py::arg("color"), py::arg("instances"), py::arg("poses"),
           py::arg("lights"), py::arg("ends"))
      .def("device", &RendererHandle::device)
      .def("cancel", &RendererHandle::cancel)
      .def("close", &RendererHandle::close);
}

}  // namespace sideray::python
