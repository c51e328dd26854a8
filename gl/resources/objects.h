// Owns single OpenGL names: move-only, deleted at the end of their scope. Creating, resetting and destroying need their
// context current on the calling thread; abandon() does not.
#pragma once

#include <cstdint>
#include <utility>

#include "gl/context/functions.h"

namespace sideray::gl {

enum class ObjectKind { texture, buffer, framebuffer, renderbuffer, vertex_array, sampler, query, program };

uint32_t create_object(const Functions& gl, ObjectKind kind);
void delete_object(const Functions& gl, ObjectKind kind, uint32_t id);

// Keeps the address of the function table, which must outlive the object.
template <ObjectKind kind>
class Object {
 public:
  Object() = default;
  explicit Object(const Functions& gl) : gl_(&gl), id_(create_object(gl, kind)) {}
  // Takes ownership of an existing name.
  Object(const Functions& gl, uint32_t id) : gl_(&gl), id_(id) {}
  ~Object() { reset(); }
  Object(Object&& other) noexcept : gl_(other.gl_), id_(std::exchange(other.id_, 0)) {}
  Object& operator=(Object&& other) noexcept {
    if (this != &other) {
      reset();
      gl_ = other.gl_;
      id_ = std::exchange(other.id_, 0);
    }
    return *this;
  }
  Object(const Object&) = delete;
  Object& operator=(const Object&) = delete;

  uint32_t id() const { return id_; }
  explicit operator bool() const { return id_ != 0; }

  void reset() {
    if (id_ != 0) delete_object(*gl_, kind, std::exchange(id_, 0));
  }
  // Gives up the name without calling OpenGL and returns it, for a context that is gone.
  uint32_t abandon() { return std::exchange(id_, 0); }

 private:
  const Functions* gl_ = nullptr;
  uint32_t id_ = 0;
};

using Texture = Object<ObjectKind::texture>;
using Buffer = Object<ObjectKind::buffer>;
using Framebuffer = Object<ObjectKind::framebuffer>;
using Renderbuffer = Object<ObjectKind::renderbuffer>;
using VertexArray = Object<ObjectKind::vertex_array>;
using Sampler = Object<ObjectKind::sampler>;
using Query = Object<ObjectKind::query>;
using ProgramObject = Object<ObjectKind::program>;

// Holds a fence of ARB_sync, or an occlusion query that is available once the fence is reached. Empty until issued.
class Fence {
 public:
  Fence() = default;
  // Puts the fence into the command stream and flushes, so that the GPU reaches it.
  explicit Fence(const Functions& gl);
  // Returns an empty fence where the driver cannot create one.
  static Fence try_issue(const Functions& gl);
  ~Fence() { reset(); }
  Fence(Fence&& other) noexcept : gl_(other.gl_) { *this = std::move(other); }
  Fence& operator=(Fence&& other) noexcept;
  Fence(const Fence&) = delete;
  Fence& operator=(const Fence&) = delete;

  explicit operator bool() const { return issued_; }
  // Returns whether the commands before the fence are complete; true without waiting where that cannot be known, since
  // mapping a buffer waits anyway. Throws Failure (GL_FAILED) where the context is lost.
  bool wait(uint64_t timeout_ns) const;
  // Does the same, but returns false where the wait itself fails.
  bool wait_or_give_up(uint64_t timeout_ns) const;
  void reset();
  void abandon();

 private:
  void begin_query();
  bool wait_for_query(uint64_t timeout_ns) const;

  const Functions* gl_ = nullptr;
  bool issued_ = false;
  GLsync sync_ = nullptr;
  Query query_;  // used without ARB_sync; empty where the host's own query is active
};

// Maps the first bytes of the buffer bound to `target`; null on failure. Waits for the commands that write them.
const void* map_to_read(const Functions& gl, GLenum target, uint64_t bytes);

}  // namespace sideray::gl
