// Declares headless OpenGL contexts: EGL devices, EGL surfaceless, and OSMesa, which is loaded at run time.
// A host's context is in gl/resources/host_context.h. One thread at a time.
#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "gl/context/functions.h"

namespace sideray::gl {

enum class Platform { egl_device, egl_surfaceless, osmesa, host, none };  // none: rays draw everything

enum class Profile { core, compatibility };

// One way to get a context on this machine. `id` is stable across runs and device order, e.g. "egl:surfaceless",
// "egl:drm:/dev/dri/renderD128", "egl:NVIDIA:0", "egl:software", "osmesa".
struct DeviceInfo {
  std::string id;
  Platform platform{};
  int index = 0;  // among the EGL devices
  std::string renderer, version;
  bool usable = false;
  std::string reason;  // says why it is not usable, and the remedy
};

// Tries each candidate to the end (a context is made and destroyed), since enumeration alone proves nothing. Leaves
// the calling thread's current context alone.
std::vector<DeviceInfo> list_devices();

class Context {
 public:
  virtual ~Context() = default;
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

  // `choice`: "auto" (EGL devices, EGL surfaceless, OSMesa: the first that works, hardware before software), "egl" or
  // "osmesa"; `device`: an id of list_devices, or empty. The context is current on return. Throws Failure: NO_DEVICE
  // lists every reason; INVALID_ARGUMENT, for a `device` that is not there, lists those that are.
  static std::unique_ptr<Context> create(const std::string& choice, const std::string& device,
                                         Profile profile = Profile::core);

  // Releases whatever context the thread had, also one of the other platform. A host's context is current already: its
  // state is saved, and restored on release.
  virtual void make_current() = 0;
  virtual void release_current() = 0;
  // Throws Failure (INVALID_ARGUMENT) where the context has something active that drawing would disturb.
  virtual void require_drawable() const {}
  const Functions& functions() const { return functions_; }
  const DeviceInfo& info() const { return info_; }
  static void* get_proc_address(void* context, const char* name);

  // Returns the error messages that the driver reported since the last call (KHR_debug), at most the first 64. With
  // SIDERAY_GL_DEBUG set, a message is there before the call that caused it returns; without, perhaps later. For a
  // host's context, whose debug output is the host's, returns what glGetError has.
  virtual std::vector<std::string> take_errors();
  // Returns whether the driver has lost the context, for example by a reset of the GPU, so that nothing is drawn in it
  // any more. False if the driver does not tell, and for a host's context, whose status only the host may query.
  virtual bool is_lost();

 protected:
  Context() = default;
  virtual void* resolve(const char* name) = 0;
  void finish_creation();  // loads the table, installs the debug callback

  Functions functions_;
  DeviceInfo info_;
  std::vector<std::string> errors_;

 private:
  bool is_lost_ = false;  // stored, because a driver may report it only once
  static void GLAD_API_PTR receive_message(GLenum source, GLenum type, GLuint id, GLenum severity, GLsizei length,
                                           const GLchar* message, const void* context);
  std::mutex errors_mutex_;  // drivers may report from threads of their own
};

}  // namespace sideray::gl
