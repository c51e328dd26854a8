// Provides options by name, devices, and the names of additional channels.
#include <sideray/plan.h>

#include "cli/options/aovs.h"
#include "python/native/native.h"

namespace sideray::python {
namespace {

const char* type_name(sideray_option_type type) {
  switch (type) {
    case SIDERAY_OPTION_SWITCH: return "switch";
    case SIDERAY_OPTION_CHOICE: return "choice";
    case SIDERAY_OPTION_INTEGER: return "integer";
    case SIDERAY_OPTION_NUMBER: return "number";
    case SIDERAY_OPTION_SIZE: return "size";
    case SIDERAY_OPTION_FLAG: return "flag";
    default: return "text";
  }
}

py::dict described(const sideray_option& option) {
  py::dict row;
  row["name"] = option.name;
  row["type"] = type_name(option.type);
  row["choices"] = std::vector<std::string>(option.choices, option.choices + option.choice_count);
  row["minimum"] = option.minimum;
  row["maximum"] = option.maximum;
  row["default"] = option.default_value;
  row["applies"] = option.applies;
  row["exact"] = option.exact_value;
  row["help"] = option.help;
  return row;
}

py::list option_table() {
  py::list rows;
  for (size_t i = 0; i < sideray_option_count(); ++i) rows.append(described(*sideray_option_at(i)));
  return rows;
}

py::list devices() {
  sideray_device_list* list = nullptr;
  {
    py::gil_scoped_release released;
    check([&](sideray_error* e) { return sideray_devices(&list, e); });
  }
  const std::unique_ptr<sideray_device_list, decltype(&sideray_devices_free)> owned(list, sideray_devices_free);
  py::list rows;
  for (size_t i = 0; i < sideray_device_count(list); ++i) {
    const sideray_device_info& device = *sideray_device_at(list, i);
    py::dict row;
    row["id"] = device.id;
    row["gl"] = device.gl;
    row["renderer"] = device.renderer;
    row["version"] = device.version;
    row["usable"] = device.usable != 0;
    row["reason"] = device.reason;
    rows.append(row);
  }
  return rows;
}

struct PlanRelease {
  void operator()(sideray_plan* plan) const { sideray_plan_release(plan); }
};

// Returns the contents that a frame of these options can have.
cli::FrameContents contents_of(SceneHandle& scene, const OptionsHandle& options) {
  const sideray_render_options& picture = options.options.render();
  sideray_plan* plan = nullptr;
  call(scene.mutex, [&](sideray_error* e) { return sideray_plan_create(scene.scene.get(), &picture, &plan, e); });
  const std::unique_ptr<sideray_plan, PlanRelease> owned(plan);
  cli::FrameContents frame;
  frame.layers = sideray_plan_layers(plan);
  frame.reference = picture.reference != nullptr;
  const std::string shadows = sideray_options_get(options.options.get(), "shadows");
  frame.inexact = shadows == "inexact";
  frame.shadow_masks = frame.inexact || shadows == "exact";
  return frame;
}

uint32_t aov_bits(const std::string& list, SceneHandle& scene, const OptionsHandle& options) {
  return cli::parse_aovs(list, contents_of(scene, options)).bits;
}

}  // namespace

void define_options(py::module_& module) {
  module.def("option_table", option_table);
  module.def("option_read_as", &sideray_option_read_as, py::arg("name"), py::arg("value"));
  module.def("devices", devices);
  module.def("aov_bits", aov_bits, py::arg("list"), py::arg("scene"), py::arg("options"));
  py::class_<OptionsHandle>(module, "Options")
      .def(py::init<>())
      .def("set", [](OptionsHandle& o, const std::string& name, const std::string& value) { o.options.set(name, value); },
           py::arg("name"), py::arg("value"))
      .def("get", [](const OptionsHandle& o, const std::string& name) { return o.options[name]; }, py::arg("name"))
      .def("check", [](const OptionsHandle& o) { o.options.require_consistent(); });
}

}  // namespace sideray::python
