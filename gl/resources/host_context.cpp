#include "gl/resources/host_context.h"

#include <fmt/format.h>

#include <optional>

#include "gl/resources/host_guard.h"
#include "gl/resources/objects.h"

namespace sideray::gl {
namespace {

// Holds one pixel with a stencil buffer, which queries of the stencil state need.
struct StencilTarget {
  explicit StencilTarget(const Functions& gl) : renderbuffer(gl), framebuffer(gl) {
    const FramebufferGuard host(gl);
    gl.BindRenderbuffer(GL_RENDERBUFFER, renderbuffer.id());
    gl.RenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH24_STENCIL8, 1, 1);
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer.id());
    gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER, renderbuffer.id());
  }
  Renderbuffer renderbuffer;
  Framebuffer framebuffer;
};

class HostContext final : public Context {
 public:
  HostContext(GetProcAddress loader, void* user) {
    functions_ = load_functions(loader, user);
    require_renderer(functions_);
    info_.id = "host";
    info_.platform = Platform::host;
    info_.renderer = functions_.renderer;
    info_.version = functions_.version_string;
    info_.usable = true;
    const ErrorGuard errors(functions_);
    stencil_.emplace(functions_);
  }
  ~HostContext() override {
    const ErrorGuard errors(functions_);
    stencil_.reset();
  }

  void make_current() override { guard_.emplace(functions_, stencil_->framebuffer.id()); }
  void release_current() override { guard_.reset(); }
  void require_drawable() const override { require_nothing_under_way(functions_); }

  std::vector<std::string> take_errors() override {
    const GLenum error = guard_ ? guard_->take_error() : GL_NO_ERROR;
    if (error == GL_NO_ERROR) return {};
    return {fmt::format("OpenGL error {:#x}", error)};
  }
  bool is_lost() override { return false; }

 private:
  void* resolve(const char*) override { return nullptr; }  // the table was loaded by the host's loader

  std::optional<StencilTarget> stencil_;
  std::optional<HostGuard> guard_;
};

}  // namespace

std::unique_ptr<Context> host_context(GetProcAddress get_proc_address, void* user) {
  return std::make_unique<HostContext>(get_proc_address, user);
}

}  // namespace sideray::gl
