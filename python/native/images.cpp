// Provides image files, display values and comparisons, as in the program.
#include "scenes/images/images.h"

#include "lab/metrics/metrics.h"
#include "python/native/native.h"

namespace sideray::python {
namespace {

using scenes::Image;
using scenes::Plane;

Image image_of(const Array<float>& rgb, bool linear, const char* what) {
  require_shape(rgb, {-1, -1, 3}, what);
  Image image;
  image.height = static_cast<uint32_t>(rgb.shape(0));
  image.width = static_cast<uint32_t>(rgb.shape(1));
  image.linear = linear;
  const size_t pixels = size_t{image.width} * image.height;
  for (size_t c = 0; c < 3; ++c) {
    Plane plane{std::string(1, "RGB"[c]), Plane::Type::single, std::vector<float>(pixels), {}};
    for (size_t i = 0; i < pixels; ++i) plane.values[i] = rgb.data()[3 * i + c];
    image.planes.push_back(std::move(plane));
  }
  return image;
}

template <typename T>
py::array array_of(uint32_t height, uint32_t width, const std::vector<T>& values) {
  py::array_t<T> array({py::ssize_t{height}, py::ssize_t{width}});
  std::copy(values.begin(), values.end(), array.mutable_data());
  return array;
}

py::tuple read_image(const std::string& path) {
  Image image;
  {
    py::gil_scoped_release released;
    image = scenes::read_image(path);
  }
  py::dict planes;
  for (const Plane& plane : image.planes)
    planes[plane.name.c_str()] = plane.type == Plane::Type::uint ? array_of(image.height, image.width, plane.uint_values)
                                                                 : array_of(image.height, image.width, plane.values);
  return py::make_tuple(planes, image.linear);
}

// Writes an EXR file: colours as half floats, all other planes in their own types.
void write_exr(const std::string& path, const py::dict& planes) {
  Image image;
  for (const auto& [key, value] : planes) {
    Plane plane;
    plane.name = key.cast<std::string>();
    const auto array = value.cast<py::array>();
    require_shape(array, {-1, -1}, plane.name.c_str());
    image.height = static_cast<uint32_t>(array.shape(0)), image.width = static_cast<uint32_t>(array.shape(1));
    if (py::isinstance<py::array_t<uint32_t>>(array)) {
      const auto values = value.cast<Array<uint32_t>>();
      plane.type = Plane::Type::uint;
      plane.uint_values.assign(values.data(), values.data() + values.size());
    } else {
      const auto values = value.cast<Array<float>>();
      const bool is_colour = plane.name.size() == 1 && std::string("RGBA").find(plane.name) != std::string::npos;
      plane.type = is_colour ? Plane::Type::half : Plane::Type::single;
      plane.values.assign(values.data(), values.data() + values.size());
    }
    image.planes.push_back(std::move(plane));
  }
  py::gil_scoped_release released;
  scenes::write_exr(path, image);
}

void write_png(const std::string& path, const Array<uint8_t>& rgb) {
  require_shape(rgb, {-1, -1, 3}, "rgb");
  const std::span<const uint8_t> bytes(rgb.data(), static_cast<size_t>(rgb.size()));
  const auto height = static_cast<uint32_t>(rgb.shape(0)), width = static_cast<uint32_t>(rgb.shape(1));
  py::gil_scoped_release released;
  scenes::write_png(path, width, height, bytes);
}

py::bytes encode_png(const Array<uint8_t>& rgb) {
  require_shape(rgb, {-1, -1, 3}, "rgb");
  const std::span<const uint8_t> pixels(rgb.data(), static_cast<size_t>(rgb.size()));
  const std::vector<uint8_t> bytes = scenes::encode_png(static_cast<uint32_t>(rgb.shape(1)),
                                                        static_cast<uint32_t>(rgb.shape(0)), 3, pixels, "the picture");
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

py::array display(const Array<float>& rgb, float exposure, const std::string& tonemap) {
  const Image image = image_of(rgb, true, "rgb");
  const scenes::Tonemap curve = scenes::tonemap_named(tonemap);
  py::array_t<uint8_t> shown({rgb.shape(0), rgb.shape(1), py::ssize_t{3}});
  uint8_t* to = shown.mutable_data();
  py::gil_scoped_release released;
  const std::vector<uint8_t> bytes = scenes::quantize(scenes::display_values(image, exposure, curve));
  std::copy(bytes.begin(), bytes.end(), to);
  return shown;
}

py::tuple compare(const Array<float>& test, bool test_linear, const Array<float>& reference, bool reference_linear,
                  float exposure, const std::string& tonemap) {
  const Image a = image_of(test, test_linear, "test"), b = image_of(reference, reference_linear, "reference");
  const lab::Display shown{exposure, scenes::tonemap_named(tonemap)};
  lab::Comparison comparison;
  {
    py::gil_scoped_release released;
    comparison = lab::compare(a, b, shown);
  }
  py::dict metrics;
  for (const std::string& name : lab::metric_names())
    if (const std::optional<double> value = lab::metric(comparison.metrics, name)) metrics[name.c_str()] = *value;
  metrics["nonfinite"] = comparison.metrics.nonfinite;
  if (comparison.flip_map.empty()) return py::make_tuple(metrics, py::none());
  return py::make_tuple(metrics, array_of(a.height, a.width, comparison.flip_map));
}

}  // namespace

void define_images(py::module_& module) {
  module.def("read_image", read_image, py::arg("path"));
  module.def("write_exr", write_exr, py::arg("path"), py::arg("planes"));
  module.def("write_png", write_png, py::arg("path"), py::arg("rgb"));
  module.def("encode_png", encode_png, py::arg("rgb"));
  module.def("display", display, py::arg("rgb"), py::arg("exposure"), py::arg("tonemap"));
  module.def("compare", compare, py::arg("test"), py::arg("test_linear"), py::arg("reference"),
             py::arg("reference_linear"), py::arg("exposure"), py::arg("tonemap"));
}

}  // namespace sideray::python
