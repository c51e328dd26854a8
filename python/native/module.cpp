#include <pybind11/pybind11.h>

#include <exception>
#include <string>
#include <string_view>
#include <vector>

#include "cli/base/failure.h"
#include "python/native/native.h"

namespace sideray::python {
namespace {

// Returns the module in which sideray.Error and its subclasses are defined, in Python.
py::module_ errors() {
  return py::module_::import("sideray._errors");
}

void set_python_error(const py::object& raised) {
  PyErr_SetObject(py::type::of(raised).ptr(), raised.ptr());
}

// A message may name a file whose name is not UTF-8: it is decoded as Python decodes such names.
py::str text_of(const std::exception& error) {
  const std::string_view message = error.what();
  return py::reinterpret_steal<py::str>(
      PyUnicode_DecodeUTF8(message.data(), static_cast<Py_ssize_t>(message.size()), "surrogateescape"));
}

void translate(std::exception_ptr thrown) {
  try {
    if (thrown) std::rethrow_exception(thrown);
  } catch (const Error& error) {
    set_python_error(errors().attr("of_status")(static_cast<int>(error.status), text_of(error)));
  } catch (const cli::UsageError& error) {
    set_python_error(errors().attr("of_usage")(text_of(error)));
  }
}

std::string version() {
  int major = 0, minor = 0, patch = 0;
  sideray_version(&major, &minor, &patch);
  return std::to_string(major) + "." + std::to_string(minor) + "." + std::to_string(patch);
}

// pybind11 before 2.12 assumes numpy 1's layout of arrays: with numpy 2 it would read wrong sizes.
void require_numpy() {
#if PYBIND11_VERSION_HEX < 0x020C0000
  const auto version = py::module_::import("numpy").attr("__version__").cast<std::string>();
  if (!version.starts_with("0.") && !version.starts_with("1."))
    throw py::import_error("sideray was built with a pybind11 older than 2.12, which knows numpy 1 alone, and this is numpy " +
                           version + "; install numpy<2, or build with a newer pybind11 (pip wheel does)");
#endif
}

std::string text_of_shape(const std::vector<py::ssize_t>& shape) {
  std::string text;
  for (const py::ssize_t side : shape) text += (text.empty() ? "" : ", ") + (side < 0 ? "n" : std::to_string(side));
  return "(" + text + (shape.size() == 1 ? ",)" : ")");
}

}  // namespace

void require_shape(const py::array& array, const std::vector<py::ssize_t>& shape, const char* what) {
  const std::vector<py::ssize_t> given(array.shape(), array.shape() + array.ndim());
  bool fits = given.size() == shape.size();
  for (size_t i = 0; fits && i < shape.size(); ++i) fits = shape[i] < 0 || shape[i] == given[i];
  if (!fits)
    throw Error(SIDERAY_INVALID_ARGUMENT, std::string(what) + ": the array has the shape " + text_of_shape(given) +
                                              "; give " + text_of_shape(shape));
}

PYBIND11_MODULE(_native, module) {
  module.doc() = "What of sideray is not written in Python. Not to be used directly: it may change with any version.";
  require_numpy();
  py::register_exception_translator(translate);
  module.def("version", version);
  define_options(module);
  define_scene(module);
  define_content(module);
  define_renderer(module);
  define_tracer(module);
  define_images(module);
  define_backdrop(module);
}

}  // namespace sideray::python
