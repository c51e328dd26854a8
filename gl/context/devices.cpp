#include <dlfcn.h>
#include <unistd.h>

#include <algorithm>
#include <exception>
#include <filesystem>
#include <thread>

#include "gl/context/platforms.h"
#include "model/failure.h"

namespace sideray::gl {
namespace {

std::unique_ptr<Context> open(const DeviceInfo& candidate, Profile profile) {
  return candidate.platform == Platform::osmesa ? open_osmesa(candidate, profile) : open_egl(candidate, profile);
}

bool is_listed(const std::vector<DeviceInfo>& candidates, const std::string& id_part) {
  return std::any_of(candidates.begin(), candidates.end(),
                     [&](const DeviceInfo& c) { return c.id.find(id_part) != std::string::npos; });
}

DeviceInfo absent(const std::string& id, const std::string& reason) {
  DeviceInfo info;
  info.id = id;
  info.platform = Platform::egl_device;
  info.reason = reason;
  return info;
}

// Returns why no NVIDIA device is listed: libglvnd silently skips a vendor whose library does not load.
std::string nvidia_reason() {
  // The library is never closed again: unloading a driver whose threads or keys may live on is not safe.
  if (dlopen("libEGL_nvidia.so.0", RTLD_LAZY | RTLD_LOCAL) == nullptr) {
    const char* why = dlerror();
    return fmt::format(
        "an NVIDIA device is present, but its EGL library cannot be loaded: {}; install the driver's "
        "OpenGL part (in a container: NVIDIA_DRIVER_CAPABILITIES=graphics or all)",
        why != nullptr ? why : "unknown reason");
  }
  return "an NVIDIA device and its EGL library are present, but no vendor file leads to it: install 10_nvidia.json in "
         "/usr/share/glvnd/egl_vendor.d, or name it in __EGL_VENDOR_LIBRARY_FILENAMES";
}

// Returns hardware that the kernel shows but no EGL driver offers.
std::vector<DeviceInfo> unclaimed_hardware(const std::vector<DeviceInfo>& candidates) {
  namespace fs = std::filesystem;
  std::vector<DeviceInfo> found;
  if (!egl_loads()) return found;
  std::error_code ignored;
  const bool nvidia = fs::exists("/dev/nvidiactl", ignored);
  if (nvidia && !is_listed(candidates, "egl:NVIDIA")) found.push_back(absent("egl:NVIDIA", nvidia_reason()));
  std::vector<std::string> nodes;
  for (fs::directory_iterator at("/dev/dri", ignored), end; !ignored && at != end; at.increment(ignored))
    if (at->path().filename().string().rfind("renderD", 0) == 0) nodes.push_back(at->path().string());
  std::sort(nodes.begin(), nodes.end());
  for (const std::string& node : nodes) {
    // An NVIDIA device is listed by its number, whatever its node is.
    if (nvidia || is_listed(candidates, node)) continue;
    const bool allowed = access(node.c_str(), R_OK | W_OK) == 0;
    found.push_back(
        absent("egl:drm:" + node, allowed ? "no EGL driver offers this device; install the one for it (Mesa on Debian: "
                                            "libegl-mesa0 libgl1-mesa-dri)"
                                          : "no permission to open it; add the user to the groups render and video"));
  }
  return found;
}

std::vector<DeviceInfo> candidates_for(const std::string& choice) {
  std::vector<DeviceInfo> candidates;
  if (choice != "osmesa") {
    candidates = egl_candidates();
    const std::vector<DeviceInfo> unclaimed = unclaimed_hardware(candidates);
    candidates.insert(candidates.end(), unclaimed.begin(), unclaimed.end());
  }
  if (choice != "egl") candidates.push_back(osmesa_candidate());
  return candidates;
}

void try_out(DeviceInfo& candidate) {
  try {
    candidate = open(candidate, Profile::core)->info();
  } catch (const std::exception& error) {
    candidate.reason = error.what();
  }
}

std::unique_ptr<Context> open_named(const std::vector<DeviceInfo>& candidates, const std::string& choice,
                                    const std::string& device, Profile profile) {
  std::string known;
  for (const DeviceInfo& candidate : candidates) {
    if (candidate.id != device) {
      known += (known.empty() ? "" : ", ") + candidate.id;
      continue;
    }
    try {
      return open(candidate, profile);
    } catch (const Failure& error) {
      fail(SIDERAY_NO_DEVICE, "OpenGL device \"{}\" cannot be used: {}", device, error.what());
    }
  }
  fail(SIDERAY_INVALID_ARGUMENT, "no OpenGL device \"{}\"{}: it is not among those found; choose one of {}", device,
       choice == "auto" ? "" : " with gl \"" + choice + "\"", known);
}

// Opens the first hardware renderer, or the first software one where there is none.
std::unique_ptr<Context> open_best(const std::vector<DeviceInfo>& candidates, Profile profile) {
  std::unique_ptr<Context> fallback;
  std::string reasons;
  for (const DeviceInfo& candidate : candidates) {
    if (fallback != nullptr && candidate.platform == Platform::osmesa) break;  // always software
    try {
      std::unique_ptr<Context> context = open(candidate, profile);
      if (!context->functions().software) return context;
      if (fallback == nullptr) fallback = std::move(context);
    } catch (const Failure& error) {
      reasons += fmt::format("{}{}: {}", reasons.empty() ? "" : " | ", candidate.id, error.what());
    }
  }
  if (fallback == nullptr)
    fail(SIDERAY_NO_DEVICE, "no usable OpenGL device (no display is needed, only a driver): {}", reasons);
  fallback->make_current();
  return fallback;
}

}  // namespace

std::vector<DeviceInfo> list_devices() {
  std::vector<DeviceInfo> candidates;
  // The work runs on a thread of its own, because a context is current per thread and the caller may have one.
  std::exception_ptr failure;
  std::thread prober([&] {
    try {
      candidates = candidates_for("auto");
      for (DeviceInfo& candidate : candidates) try_out(candidate);
    } catch (...) {
      failure = std::current_exception();
    }
  });
  prober.join();
  if (failure) std::rethrow_exception(failure);
  return candidates;
}

std::unique_ptr<Context> Context::create(const std::string& choice, const std::string& device, Profile profile) {
  if (choice != "auto" && choice != "egl" && choice != "osmesa")
    fail(SIDERAY_INVALID_ARGUMENT, "gl \"{}\": not known; use auto, egl, osmesa or none", choice);
  const std::vector<DeviceInfo> candidates = candidates_for(choice);
  return device.empty() ? open_best(candidates, profile) : open_named(candidates, choice, device, profile);
}

}  // namespace sideray::gl
