#include <dlfcn.h>

#include <array>
#include <atomic>
#include <cstdlib>
#include <string_view>

#include "gl/context/platforms.h"
#include "model/failure.h"

namespace sideray::gl {
namespace {

// From GL/osmesa.h, whose package is not needed to build.
enum : int {
  osmesa_format = 0x22,
  osmesa_depth_bits = 0x30,
  osmesa_stencil_bits = 0x31,
  osmesa_profile = 0x33,
  osmesa_core_profile = 0x34,
  osmesa_compat_profile = 0x35,
  osmesa_major_version = 0x36,
  osmesa_minor_version = 0x37
};
using OsmesaContextPtr = void*;

struct Library {
  OsmesaContextPtr (*create)(const int* attributes, OsmesaContextPtr share) = nullptr;
  void (*destroy)(OsmesaContextPtr) = nullptr;
  GLboolean (*make_current)(OsmesaContextPtr, void* buffer, GLenum type, GLsizei width, GLsizei height) = nullptr;
  OsmesaContextPtr (*current)() = nullptr;
  void (*(*get_proc_address)(const char* name))() = nullptr;
  std::string reason;  // says why it cannot be used; empty where it can
  std::mutex mutex;    // OSMesa keeps unguarded globals
};

std::atomic<bool> is_loaded{false};

template <typename Function>
bool find(void* handle, const char* name, Function& function) {
  function = reinterpret_cast<Function>(dlsym(handle, name));
  return function != nullptr;
}

void load(Library& library) {
  void* handle = nullptr;
  std::string why;  // the message for the newest version, which is the one to install
  for (const char* name : {"libOSMesa.so.8", "libOSMesa.so.6"}) {
    if (handle == nullptr) handle = dlopen(name, RTLD_NOW | RTLD_LOCAL);
    const char* error = handle == nullptr ? dlerror() : nullptr;
    if (why.empty() && error != nullptr) why = error;
  }
  if (handle == nullptr) {
    library.reason = fmt::format("libOSMesa cannot be loaded: {}; install it (Debian: libosmesa6)", why);
    return;
  }
  const bool complete = find(handle, "OSMesaCreateContextAttribs", library.create) &&
                        find(handle, "OSMesaDestroyContext", library.destroy) &&
                        find(handle, "OSMesaMakeCurrent", library.make_current) &&
                        find(handle, "OSMesaGetCurrentContext", library.current) &&
                        find(handle, "OSMesaGetProcAddress", library.get_proc_address);
  if (!complete) library.reason = "libOSMesa is too old to make core contexts; install Mesa 12 or later";
  is_loaded = complete;
}

// Returns the library, which stays loaded: unloading a driver that has made contexts is not safe.
Library& library() {
  static Library& loaded = *[] {
    auto* l = new Library;
    load(*l);
    return l;
  }();
  return loaded;
}

// Returns why GALLIUM_DRIVER cannot be used: libOSMesa crashes where it names a driver that the library lacks.
std::string driver_reason() {
  const char* value = std::getenv("GALLIUM_DRIVER");
  const std::string_view driver = value != nullptr ? value : "";
  if (driver.empty() || driver == "llvmpipe" || driver == "softpipe") return "";
  return fmt::format("GALLIUM_DRIVER={} is set, and OSMesa has only the drivers llvmpipe and softpipe; unset it",
                     driver);
}

class OsmesaContext final : public Context {
 public:
  OsmesaContext(const DeviceInfo& candidate, Profile profile) {
    info_ = candidate;
    Library& os = library();
    {
      const std::lock_guard lock(os.mutex);
      for (const int version : core_versions)
        if (context_ == nullptr) context_ = create(os, version, profile);
    }
    if (context_ == nullptr)
      fail(SIDERAY_NO_DEVICE,
           "OSMesa gives no OpenGL 3.3 context; is its driver whole, and do MESA_GL_VERSION_OVERRIDE "
           "or GALLIUM_DRIVER forbid it?");
    try {
      make_current();
      finish_creation();
    } catch (...) {
      close();
      throw;
    }
  }
  ~OsmesaContext() override { close(); }

  void make_current() override {
    egl_release_thread();
    Library& os = library();
    const std::lock_guard lock(os.mutex);
    if (os.make_current(context_, buffer_.data(), GL_UNSIGNED_BYTE, side, side) == GL_FALSE)
      fail(SIDERAY_GL_FAILED, "the OSMesa context cannot be made current; is it current on another thread?");
  }

  void release_current() override {
    if (is_current()) osmesa_release_thread();
  }

 private:
  static constexpr int side = 4;  // size of the default framebuffer, which nothing draws to

  static OsmesaContextPtr create(Library& os, int version, Profile profile) {
    const int attributes[] = {osmesa_format,
                              GL_RGBA,
                              osmesa_depth_bits,
                              0,
                              osmesa_stencil_bits,
                              0,
                              osmesa_profile,
                              profile == Profile::core ? osmesa_core_profile : osmesa_compat_profile,
                              osmesa_major_version,
                              version / 10,
                              osmesa_minor_version,
                              version % 10,
                              0};
    return os.create(attributes, nullptr);
  }

  bool is_current() const { return library().current() == context_; }

  void close() {
    release_current();
    Library& os = library();
    const std::lock_guard lock(os.mutex);
    os.destroy(context_);
  }

  void* resolve(const char* name) override { return reinterpret_cast<void*>(library().get_proc_address(name)); }

  OsmesaContextPtr context_ = nullptr;
  std::array<uint8_t, 4 * side * side> buffer_{};
};

}  // namespace

DeviceInfo osmesa_candidate() {
  DeviceInfo info;
  info.id = "osmesa";
  info.platform = Platform::osmesa;
  info.reason = driver_reason();
  if (info.reason.empty()) info.reason = library().reason;
  return info;
}

std::unique_ptr<Context> open_osmesa(const DeviceInfo& candidate, Profile profile) {
  if (!candidate.reason.empty()) throw Failure(SIDERAY_NO_DEVICE, candidate.reason);
  return std::make_unique<OsmesaContext>(candidate, profile);
}

void osmesa_release_thread() {
  if (!is_loaded) return;
  Library& os = library();
  const std::lock_guard lock(os.mutex);
  os.make_current(nullptr, nullptr, GL_UNSIGNED_BYTE, 0, 0);
}

}  // namespace sideray::gl
