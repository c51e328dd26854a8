#include "gl/context/context.h"

#include <cstdlib>
#include <utility>

#include "gl/context/platforms.h"

namespace sideray::gl {
namespace {

constexpr size_t errors_kept = 64;

}  // namespace

bool debug_requested() {
  const char* value = std::getenv("SIDERAY_GL_DEBUG");
  return value != nullptr && *value != '\0' && std::string_view(value) != "0";
}

void* Context::get_proc_address(void* context, const char* name) {
  return static_cast<Context*>(context)->resolve(name);
}

void GLAD_API_PTR Context::receive_message(GLenum, GLenum type, GLuint, GLenum, GLsizei length, const GLchar* message,
                                           const void* context) {
  if (type != GL_DEBUG_TYPE_ERROR || message == nullptr) return;
  auto* self = static_cast<Context*>(const_cast<void*>(context));
  std::string text = length < 0 ? std::string(message) : std::string(message, static_cast<size_t>(length));
  while (!text.empty() && (text.back() == '\n' || text.back() == '\0')) text.pop_back();
  const std::lock_guard lock(self->errors_mutex_);
  if (self->errors_.size() < errors_kept) self->errors_.push_back(std::move(text));
}

std::vector<std::string> Context::take_errors() {
  const std::lock_guard lock(errors_mutex_);
  return std::exchange(errors_, {});
}

bool Context::is_lost() {
  if (functions_.GetGraphicsResetStatus && functions_.GetGraphicsResetStatus() != GL_NO_ERROR) is_lost_ = true;
  return is_lost_;
}

void Context::finish_creation() {
  functions_ = load_functions(&Context::get_proc_address, this);
  info_.renderer = functions_.renderer;
  info_.version = functions_.version_string;
  info_.usable = true;
  info_.reason.clear();
  if (!functions_.debug) return;
  const Functions& gl = functions_;
  gl.DebugMessageCallback(&Context::receive_message, this);
  gl.DebugMessageControl(GL_DONT_CARE, GL_DONT_CARE, GL_DONT_CARE, 0, nullptr, GL_FALSE);
  gl.DebugMessageControl(GL_DONT_CARE, GL_DEBUG_TYPE_ERROR, GL_DONT_CARE, 0, nullptr, GL_TRUE);
  gl.Enable(GL_DEBUG_OUTPUT);
  if (debug_requested()) gl.Enable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
}

}  // namespace sideray::gl
