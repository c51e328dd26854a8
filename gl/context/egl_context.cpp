#define EGL_NO_X11 1
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <dlfcn.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <iterator>
#include <map>

#include "gl/context/platforms.h"
#include "model/failure.h"

namespace sideray::gl {
namespace {

struct Library {
  PFNEGLGETPROCADDRESSPROC get_proc_address = nullptr;
  PFNEGLQUERYSTRINGPROC query_string = nullptr;
  PFNEGLGETERRORPROC get_error = nullptr;
  PFNEGLINITIALIZEPROC initialize = nullptr;
  PFNEGLBINDAPIPROC bind_api = nullptr;
  PFNEGLQUERYAPIPROC query_api = nullptr;
  PFNEGLCHOOSECONFIGPROC choose_config = nullptr;
  PFNEGLCREATECONTEXTPROC create_context = nullptr;
  PFNEGLDESTROYCONTEXTPROC destroy_context = nullptr;
  PFNEGLMAKECURRENTPROC make_current = nullptr;
  PFNEGLGETCURRENTCONTEXTPROC current_context = nullptr;
  PFNEGLGETCURRENTDISPLAYPROC current_display = nullptr;
  PFNEGLGETPLATFORMDISPLAYEXTPROC platform_display = nullptr;
  PFNEGLQUERYDEVICESEXTPROC query_devices = nullptr;                // null where devices cannot be enumerated
  PFNEGLQUERYDEVICESTRINGEXTPROC query_device_string = nullptr;     // null likewise
  PFNEGLQUERYDEVICEATTRIBEXTPROC query_device_attribute = nullptr;  // null likewise
  std::string client_extensions;
  std::string reason;  // why the library cannot be used at all
};

std::atomic<const Library*> loaded_library{nullptr};

bool has_word(const std::string& list, const std::string& word) {
  return (" " + list + " ").find(" " + word + " ") != std::string::npos;
}

std::string text(const char* value) {
  return value != nullptr ? value : "";
}

template <typename Function>
bool find(void* handle, const char* name, Function& function) {
  function = reinterpret_cast<Function>(dlsym(handle, name));
  return function != nullptr;
}

bool find_core(void* handle, Library& egl) {
  return find(handle, "eglGetProcAddress", egl.get_proc_address) && find(handle, "eglQueryString", egl.query_string) &&
         find(handle, "eglGetError", egl.get_error) && find(handle, "eglInitialize", egl.initialize) &&
         find(handle, "eglBindAPI", egl.bind_api) && find(handle, "eglQueryAPI", egl.query_api) &&
         find(handle, "eglChooseConfig", egl.choose_config) && find(handle, "eglCreateContext", egl.create_context) &&
         find(handle, "eglDestroyContext", egl.destroy_context) && find(handle, "eglMakeCurrent", egl.make_current) &&
         find(handle, "eglGetCurrentContext", egl.current_context) &&
         find(handle, "eglGetCurrentDisplay", egl.current_display);
}

template <typename Function>
void find_extension(const Library& egl, const char* name, Function& function) {
  function = reinterpret_cast<Function>(egl.get_proc_address(name));
}

// Says that no vendor file leads to a driver; libglvnd has no drivers of its own.
std::string no_vendor_reason() {
  for (const char* name : {"__EGL_VENDOR_LIBRARY_FILENAMES", "__EGL_VENDOR_LIBRARY_DIRS"})
    if (const char* value = std::getenv(name))
      return fmt::format("libEGL found no driver: {}={} names no vendor file whose library loads; unset or correct it",
                         name, value);
  return "libEGL found no driver: no vendor file in /etc/glvnd/egl_vendor.d or /usr/share/glvnd/egl_vendor.d names a "
         "library that loads; install the driver's EGL part (Mesa on Debian: libegl-mesa0 libgl1-mesa-dri)";
}

void load(Library& egl) {
  void* handle = dlopen("libEGL.so.1", RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr) {
    egl.reason = fmt::format(
        "libEGL.so.1 cannot be loaded: {}; install it (Debian: libegl1 libegl-mesa0 "
        "libgl1-mesa-dri)",
        text(dlerror()));
    return;
  }
  if (!find_core(handle, egl)) {
    egl.reason = "libEGL.so.1 lacks functions of EGL 1.4: it is damaged or too old; install a current one";
    return;
  }
  egl.client_extensions = text(egl.query_string(EGL_NO_DISPLAY, EGL_EXTENSIONS));
  egl.get_error();
  if (has_word(egl.client_extensions, "EGL_EXT_platform_base"))
    find_extension(egl, "eglGetPlatformDisplayEXT", egl.platform_display);
  const bool devices = has_word(egl.client_extensions, "EGL_EXT_device_base") ||
                       (has_word(egl.client_extensions, "EGL_EXT_device_enumeration") &&
                        has_word(egl.client_extensions, "EGL_EXT_device_query"));
  if (devices && has_word(egl.client_extensions, "EGL_EXT_platform_device")) {
    find_extension(egl, "eglQueryDevicesEXT", egl.query_devices);
    find_extension(egl, "eglQueryDeviceStringEXT", egl.query_device_string);
    find_extension(egl, "eglQueryDeviceAttribEXT", egl.query_device_attribute);
  }
  if (egl.platform_display == nullptr) egl.reason = no_vendor_reason();
  loaded_library = &egl;
}

// Returns the library, which stays loaded: unloading a driver that has made contexts is not safe.
const Library& library() {
  static const Library& loaded = *[] {
    auto* egl = new Library;
    load(*egl);
    return egl;
  }();
  return loaded;
}

std::string error_name(EGLint code) {
  switch (code) {
    case EGL_NOT_INITIALIZED:
      return "EGL_NOT_INITIALIZED";
    case EGL_BAD_ACCESS:
      return "EGL_BAD_ACCESS";
    case EGL_BAD_ALLOC:
      return "EGL_BAD_ALLOC";
    case EGL_BAD_ATTRIBUTE:
      return "EGL_BAD_ATTRIBUTE";
    case EGL_BAD_CONFIG:
      return "EGL_BAD_CONFIG";
    case EGL_BAD_CONTEXT:
      return "EGL_BAD_CONTEXT";
    case EGL_BAD_DISPLAY:
      return "EGL_BAD_DISPLAY";
    case EGL_BAD_MATCH:
      return "EGL_BAD_MATCH";
    case EGL_BAD_PARAMETER:
      return "EGL_BAD_PARAMETER";
    case EGL_CONTEXT_LOST:
      return "EGL_CONTEXT_LOST";
    default:
      return fmt::format("error 0x{:x}", code);
  }
}

// Binds the OpenGL API within its scope. eglMakeCurrent(none) and eglGetCurrentContext apply to the API that the thread
// has bound, and the host may have bound another.
class OpenglApi {
 public:
  explicit OpenglApi(const Library& egl) : egl_(egl), saved_(egl.query_api()) { egl_.bind_api(EGL_OPENGL_API); }
  ~OpenglApi() { egl_.bind_api(saved_); }
  OpenglApi(const OpenglApi&) = delete;
  OpenglApi& operator=(const OpenglApi&) = delete;

 private:
  const Library& egl_;
  EGLenum saved_;
};

std::vector<EGLDeviceEXT> devices(const Library& egl) {
  EGLint count = 0;
  if (egl.query_devices == nullptr || egl.query_devices(0, nullptr, &count) == EGL_FALSE || count <= 0) return {};
  std::vector<EGLDeviceEXT> list(static_cast<size_t>(count));
  if (egl.query_devices(count, list.data(), &count) == EGL_FALSE) return {};
  list.resize(static_cast<size_t>(std::max(count, 0)));
  return list;
}

struct DeviceName {
  std::string id;
  std::string node;  // in /dev/dri; empty where the device has none
  bool software = false;
};

// Names a device; prefers names that stay the same when drivers enumerate in another order. Every string may be null.
DeviceName name_device(const Library& egl, EGLDeviceEXT device, int index) {
  DeviceName name;
  const std::string extensions = text(egl.query_device_string(device, EGL_EXTENSIONS));
  if (has_word(extensions, "EGL_EXT_device_drm_render_node"))
    name.node = text(egl.query_device_string(device, EGL_DRM_RENDER_NODE_FILE_EXT));
  if (name.node.empty() && has_word(extensions, "EGL_EXT_device_drm"))
    name.node = text(egl.query_device_string(device, EGL_DRM_DEVICE_FILE_EXT));
  name.software = has_word(extensions, "EGL_MESA_device_software");
  EGLAttrib cuda = -1;
  const bool nvidia = has_word(extensions, "EGL_NV_device_cuda");
  if (nvidia) egl.query_device_attribute(device, EGL_CUDA_DEVICE_NV, &cuda);
  egl.get_error();
  if (name.software) {
    name.id = "egl:software";
  } else if (nvidia && cuda >= 0) {
    name.id = fmt::format("egl:NVIDIA:{}", cuda);
  } else if (!name.node.empty()) {
    name.id = "egl:drm:" + name.node;
  } else {
    name.id = fmt::format("egl:device:{}", index);
  }
  return name;
}

std::string node_remedy(const std::string& node) {
  if (node.empty()) return "";
  if (access(node.c_str(), F_OK) != 0)
    return fmt::format("; {} is not visible here (container? pass /dev/dri in)", node);
  if (access(node.c_str(), R_OK | W_OK) != 0)
    return fmt::format("; no permission for {} (add the user to the groups render and video)", node);
  return "";
}

// Returns a hint at settings that make Mesa look for drivers where there may be none.
std::string environment_hint() {
  std::string hint;
  for (const char* name :
       {"LIBGL_DRIVERS_PATH", "GALLIUM_DRIVER", "MESA_LOADER_DRIVER_OVERRIDE", "MESA_GL_VERSION_OVERRIDE"})
    if (const char* value = std::getenv(name)) hint += fmt::format("; {}={} is set, is it right?", name, value);
  return hint;
}

EGLDisplay open_display(const Library& egl, const DeviceInfo& candidate) {
  EGLDisplay display = EGL_NO_DISPLAY;
  std::string remedy;
  if (candidate.platform == Platform::egl_device) {
    const std::vector<EGLDeviceEXT> list = devices(egl);
    const auto index = static_cast<size_t>(candidate.index);
    if (index >= list.size()) fail(SIDERAY_NO_DEVICE, "the EGL device is gone; list the devices again");
    display = egl.platform_display(EGL_PLATFORM_DEVICE_EXT, list[index], nullptr);
    remedy = node_remedy(name_device(egl, list[index], candidate.index).node);
  } else {
    display = egl.platform_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
  }
  if (display == EGL_NO_DISPLAY)
    fail(SIDERAY_NO_DEVICE, "EGL gives no display ({}){}", error_name(egl.get_error()), remedy);
  // eglTerminate is never called after this: displays belong to the whole process, so the host may use the same one.
  if (egl.initialize(display, nullptr, nullptr) == EGL_FALSE)
    fail(SIDERAY_NO_DEVICE,
         "EGL cannot start the driver ({}): it is missing or refuses (Mesa on Debian: "
         "libgl1-mesa-dri; EGL_LOG_LEVEL=debug says more){}{}",
         error_name(egl.get_error()), remedy, environment_hint());
  return display;
}

EGLConfig choose_config(const Library& egl, EGLDisplay display, const std::string& extensions) {
  if (has_word(extensions, "EGL_KHR_no_config_context")) return EGLConfig{};  // EGL_NO_CONFIG_KHR
  const EGLint wanted[] = {EGL_SURFACE_TYPE, 0, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
  EGLConfig config{};
  EGLint count = 0;
  if (egl.choose_config(display, wanted, &config, 1, &count) == EGL_FALSE || count < 1)
    fail(SIDERAY_NO_DEVICE, "this EGL driver offers no desktop OpenGL; use another device");
  return config;
}

// Returns the attributes of a context. `tells_loss`: the context reports when it is lost.
std::vector<EGLint> context_attributes(int version, Profile profile, bool egl_1_5, bool tells_loss) {
  std::vector<EGLint> attributes = {
      EGL_CONTEXT_MAJOR_VERSION,
      version / 10,
      EGL_CONTEXT_MINOR_VERSION,
      version % 10,
      EGL_CONTEXT_OPENGL_PROFILE_MASK,
      profile == Profile::core ? EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT : EGL_CONTEXT_OPENGL_COMPATIBILITY_PROFILE_BIT};
  if (tells_loss)
    attributes.insert(attributes.end(), {EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY, EGL_LOSE_CONTEXT_ON_RESET});
  if (debug_requested() && egl_1_5)
    attributes.insert(attributes.end(), {EGL_CONTEXT_OPENGL_DEBUG, EGL_TRUE});
  else if (debug_requested())
    attributes.insert(attributes.end(), {EGL_CONTEXT_FLAGS_KHR, EGL_CONTEXT_OPENGL_DEBUG_BIT_KHR});
  attributes.push_back(EGL_NONE);
  return attributes;
}

EGLContext create_context(const Library& egl, EGLDisplay display, EGLConfig config, Profile profile) {
  const bool egl_1_5 = text(egl.query_string(display, EGL_VERSION)).compare(0, 3, "1.5") >= 0;
  for (const int version : core_versions)
    for (const bool tells_loss : {true, false}) {  // not all drivers report a loss
      const std::vector<EGLint> attributes = context_attributes(version, profile, egl_1_5, tells_loss);
      EGLContext context = egl.create_context(display, config, EGL_NO_CONTEXT, attributes.data());
      if (context != EGL_NO_CONTEXT) return context;
    }
  fail(SIDERAY_NO_DEVICE, "the driver gives no OpenGL 3.3 context ({}); update it or use another device{}",
       error_name(egl.get_error()), environment_hint());
}

class EglContext final : public Context {
 public:
  EglContext(const DeviceInfo& candidate, Profile profile) : egl_(library()) {
    info_ = candidate;
    display_ = open_display(egl_, candidate);
    const std::string extensions = text(egl_.query_string(display_, EGL_EXTENSIONS));
    for (const char* needed : {"EGL_KHR_surfaceless_context", "EGL_KHR_create_context"})
      if (!has_word(extensions, needed))
        fail(SIDERAY_NO_DEVICE, "the EGL driver lacks {}; update it or use another device", needed);
    const OpenglApi api(egl_);
    context_ = create_context(egl_, display_, choose_config(egl_, display_, extensions), profile);
    try {
      make_current();
      finish_creation();
    } catch (...) {
      close();
      throw;
    }
  }
  ~EglContext() override { close(); }

  void make_current() override {
    egl_release_thread();
    osmesa_release_thread();
    const OpenglApi api(egl_);
    if (egl_.make_current(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_FALSE)
      fail(SIDERAY_GL_FAILED, "the EGL context cannot be made current ({}); is it current on another thread?",
           error_name(egl_.get_error()));
  }

  void release_current() override {
    const OpenglApi api(egl_);
    if (egl_.current_context() == context_) egl_release_thread();
  }

 private:
  void close() {
    release_current();
    egl_.destroy_context(display_, context_);
  }

  void* resolve(const char* name) override { return reinterpret_cast<void*>(egl_.get_proc_address(name)); }

  const Library& egl_;
  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLContext context_ = EGL_NO_CONTEXT;
};

std::vector<DeviceInfo> device_candidates(const Library& egl) {
  std::vector<DeviceInfo> hardware, software;
  std::map<std::string, int> seen;
  int index = 0;
  for (EGLDeviceEXT device : devices(egl)) {
    const DeviceName name = name_device(egl, device, index);
    DeviceInfo info;
    info.id = name.id;
    if (const int before = seen[name.id]++; before > 0) info.id += fmt::format(":{}", before);
    info.platform = Platform::egl_device;
    info.index = index++;
    (name.software ? software : hardware).push_back(std::move(info));
  }
  std::move(software.begin(), software.end(), std::back_inserter(hardware));
  return hardware;
}

}  // namespace

bool egl_loads() {
  return library().get_proc_address != nullptr;
}

std::vector<DeviceInfo> egl_candidates() {
  const Library& egl = library();
  if (!egl.reason.empty()) {
    DeviceInfo info;
    info.id = "egl";
    info.platform = Platform::egl_surfaceless;
    info.reason = egl.reason;
    return {info};
  }
  std::vector<DeviceInfo> candidates = device_candidates(egl);
  DeviceInfo surfaceless;
  surfaceless.id = "egl:surfaceless";
  surfaceless.platform = Platform::egl_surfaceless;
  if (!has_word(egl.client_extensions, "EGL_MESA_platform_surfaceless"))
    surfaceless.reason =
        "no EGL driver here offers the surfaceless platform, which is Mesa's; install it (Debian: "
        "libegl-mesa0 libgl1-mesa-dri) where no device above can be used";
  candidates.push_back(std::move(surfaceless));
  return candidates;
}

std::unique_ptr<Context> open_egl(const DeviceInfo& candidate, Profile profile) {
  if (!candidate.reason.empty()) throw Failure(SIDERAY_NO_DEVICE, candidate.reason);
  return std::make_unique<EglContext>(candidate, profile);
}

void egl_release_thread() {
  const Library* egl = loaded_library;
  if (egl == nullptr) return;
  const OpenglApi api(*egl);
  if (egl->current_context() == EGL_NO_CONTEXT) return;
  egl->make_current(egl->current_display(), EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
}

}  // namespace sideray::gl
