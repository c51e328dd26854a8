// Reads files and built-in scenes, as the program does.
#include "scenes/content/content.h"

#include "python/native/native.h"
#include "scenes/base/files.h"
#include "scenes/builtin/builtin.h"

namespace sideray::python {
namespace {

struct ContentHandle {
  scenes::Content content;
  std::vector<bool> traced;  // as set in the filled scene
};

std::unique_ptr<ContentHandle> load(const std::string& scene, const std::string& animation, const std::string& variant,
                                    double time_s, bool default_light, double max_seconds, double max_gb) {
  py::gil_scoped_release released;
  scenes::LoadOptions options;
  options.animation = animation;
  options.variant = variant;
  options.time_s = time_s;
  options.default_light = default_light;
  options.limits = {.seconds = max_seconds, .bytes = static_cast<uint64_t>(max_gb * 1e9)};
  return std::make_unique<ContentHandle>(ContentHandle{scenes::load(scene, options), {}});
}

bool is_builtin(const std::string& scene) {
  return scenes::is_builtin(scene.substr(0, scene.find('?')));
}

py::list builtin_table() {
  py::list rows;
  for (const scenes::Builtin& builtin : scenes::builtins()) {
    py::dict row;
    row["name"] = builtin.name;
    row["description"] = builtin.description;
    rows.append(row);
  }
  return rows;
}

py::dict camera(const ContentHandle& c, size_t index, float aspect) {
  if (index < c.content.cameras.size()) return fields_of(c.content.cameras[index].camera);
  return fields_of(scenes::framing_camera(c.content, aspect));
}

std::vector<bool> selected(const ContentHandle& c, const std::string& selection, const py::dict& view, uint32_t width,
                           uint32_t height) {
  return scenes::select_ray_traced(c.content, selection, camera_of(view), width, height);
}

void fill(ContentHandle& c, SceneHandle& s, const std::string& selection, const py::dict& view, uint32_t width,
          uint32_t height) {
  c.traced = selected(c, selection, view, width, height);
  py::gil_scoped_release released;
  const std::lock_guard lock(s.mutex);
  scenes::fill(s.scene, c.content, c.traced);
}

// Selects objects for layers. A change rebuilds everything, so it is made only if the selection differs.
void select(ContentHandle& c, SceneHandle& s, const std::string& selection, const py::dict& view, uint32_t width,
            uint32_t height) {
  std::vector<bool> traced = selected(c, selection, view, width, height);
  if (traced == c.traced) return;
  py::gil_scoped_release released;
  const std::lock_guard lock(s.mutex);
  scenes::set_traced(s.scene, c.content, traced);
  c.traced = std::move(traced);
}

void move(ContentHandle& c, SceneHandle& s, double time_s, double previous_time_s) {
  py::gil_scoped_release released;
  const std::lock_guard lock(s.mutex);
  if (!scenes::moves(c.content)) return;
  scenes::pose(c.content, time_s);
  s.scene.set_time(time_s, previous_time_s);
  scenes::move(s.scene, c.content);
}

// Returns the name of each entry.
template <typename List>
std::vector<std::string> names_of(const List& list) {
  std::vector<std::string> names;
  for (const auto& entry : list) names.push_back(entry.name);
  return names;
}

py::list lights(const ContentHandle& c) {
  py::list result;
  for (const scenes::Light& light : c.content.lights) result.append(fields_of(light.light));
  return result;
}

py::array sky() {
  const scenes::Sky sky = scenes::sky();
  Array<float> rgb({py::ssize_t{sky.height}, py::ssize_t{sky.width}, py::ssize_t{3}});
  std::copy(sky.rgb.begin(), sky.rgb.end(), rgb.mutable_data());
  return rgb;
}

}  // namespace

void define_content(py::module_& module) {
  module.def("is_builtin", is_builtin, py::arg("scene"));
  module.def("builtin_table", builtin_table);
  module.def("sky", sky);
  py::class_<ContentHandle>(module, "Content")
      .def(py::init(&load), py::arg("scene"), py::arg("animation"), py::arg("variant"), py::arg("time_s"),
           py::arg("default_light"), py::arg("max_seconds"), py::arg("max_gb"))
      .def_property_readonly("warnings", [](const ContentHandle& c) {
        return static_cast<const std::vector<std::string>&>(c.content.warnings);
      })
      .def_property_readonly("cameras", [](const ContentHandle& c) { return names_of(c.content.cameras); })
      .def_property_readonly("objects", [](const ContentHandle& c) { return names_of(c.content.objects); })
      .def_property_readonly("light_names", [](const ContentHandle& c) { return names_of(c.content.lights); })
      .def_property_readonly("animations", [](const ContentHandle& c) { return names_of(c.content.animations); })
      .def_property_readonly("variants", [](const ContentHandle& c) { return c.content.variants; })
      .def_property_readonly("lights", lights)
      .def_property_readonly("moves", [](const ContentHandle& c) { return scenes::moves(c.content); })
      .def("camera", camera, py::arg("index"), py::arg("aspect"))
      .def("fill", fill, py::arg("scene"), py::arg("selection"), py::arg("camera"), py::arg("width"), py::arg("height"))
      .def("select", select, py::arg("scene"), py::arg("selection"), py::arg("camera"), py::arg("width"),
           py::arg("height"))
      .def("move", move, py::arg("scene"), py::arg("time_s"), py::arg("previous_time_s"));
}

}  // namespace sideray::python
