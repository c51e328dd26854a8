// The extension sideray._native is the C interface with arrays for pointers. It copies, locks, and lets other Python
// threads run; conveniences are written in Python (python/sideray).
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <memory>
#include <mutex>
#include <optional>
#include <sideray/sideray.hpp>
#include <string>
#include <utility>
#include <vector>

namespace sideray::python {

namespace py = pybind11;

// Arrays that are not of this type or layout are converted.
template <typename T>
using Array = py::array_t<T, py::array::c_style | py::array::forcecast>;

// Throws Error where the array does not have this shape (-1: any length); `what` names it.
void require_shape(const py::array& array, const std::vector<py::ssize_t>& shape, const char* what);

// Calls f(&error) under `mutex`, while other Python threads run. Throws where it fails.
template <typename F>
void call(std::mutex& mutex, F&& f) {
  py::gil_scoped_release released;
  const std::lock_guard lock(mutex);
  check(std::forward<F>(f));
}

struct SceneHandle {
  Scene scene = Scene::create().value();
  std::mutex mutex;
};

struct OptionsHandle {
  Options options = Options::create().value();
};

sideray_camera camera_of(const py::dict& fields);
py::dict fields_of(const sideray_camera& camera);
py::dict fields_of(const sideray_light& light);

void define_options(py::module_& module);
void define_scene(py::module_& module);
void define_content(py::module_& module);
void define_renderer(py::module_& module);
void define_tracer(py::module_& module);
void define_images(py::module_& module);
void define_backdrop(py::module_& module);

}  // namespace sideray::python
