#include "viewer/drawing/machine.h"

#include <algorithm>
#include <string_view>

namespace sideray::viewer {
namespace {

// Returns whether a device has no OpenGL, or one of the CPU rasterizers of Mesa.
bool runs_on_cpu(const sideray_device_info& device) {
  const std::string_view renderer = device.renderer;
  const auto names = {"llvmpipe", "softpipe", "swrast", "Software Rasterizer"};
  return std::string_view(device.gl) == "none" ||
         std::any_of(names.begin(), names.end(),
                     [&](std::string_view name) { return renderer.find(name) != std::string_view::npos; });
}

}  // namespace

Machine::Machine(const Arguments& arguments)
    : gl_(arguments.text("gl", "auto")),
      device_(arguments.text("device")),
      threads_(static_cast<uint32_t>(arguments.number("threads", 0))) {}

void Machine::probe() {
  std::call_once(probed_, [this] {
    if (gl_ == "none") {
      description_ = "rays alone";
      return;
    }
    const Renderer renderer = open(gl_);
    const sideray_device_info device = renderer.device();
    is_software_ = gl_ == "auto" && runs_on_cpu(device);
    description_ = is_software_ ? "rays alone" : device.renderer;
  });
}

bool Machine::is_software() {
  probe();
  return is_software_;
}

std::string Machine::description() {
  probe();
  return description_;
}

Renderer Machine::renderer(bool needs_rasterizer) {
  if (needs_rasterizer) return open(gl_ == "none" ? "auto" : gl_);
  return open(is_software() ? "none" : gl_);
}

Tracer Machine::tracer(const Scene& scene) const {
  sideray_tracer_desc desc = sideray_tracer_defaults();
  desc.threads = threads_;
  return Tracer::create(scene, desc).value();
}

Renderer Machine::open(const std::string& gl) const {
  sideray_renderer_desc desc = sideray_renderer_defaults();
  desc.gl = gl.c_str();
  desc.device = device_.empty() || gl == "none" ? nullptr : device_.c_str();
  desc.threads = threads_;
  return Renderer::create(desc).value();
}

}  // namespace sideray::viewer
