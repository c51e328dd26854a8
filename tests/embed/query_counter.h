// A loader that records queries of the context's state: calls and names. One at a time; test support.
#pragma once

#include <fmt/format.h>
#include <sideray/sideray.h>

#include <cstring>
#include <set>
#include <string>

#include "gl/context/context.h"

namespace sideray::tests {

class QueryCounter {
 public:
  explicit QueryCounter(gl::Context& context) : context_(context) { current = this; }
  ~QueryCounter() { current = nullptr; }
  QueryCounter(const QueryCounter&) = delete;
  QueryCounter& operator=(const QueryCounter&) = delete;

  sideray_host_gl host() { return {sizeof(sideray_host_gl), &get_proc_address, this}; }
  // Returns the queries since its last call.
  std::set<std::string> take() { return std::exchange(asked_, {}); }

 private:
  template <auto member>
  struct Asking;
  template <typename Result, typename Name, typename... Rest,
            Result (GLAD_API_PTR* GladGLContext::*member)(Name, Rest...)>
  struct Asking<member> {
    static inline const char* function = "";
    static Result GLAD_API_PTR call(Name name, Rest... rest) {
      current->asked_.insert(fmt::format("{}(0x{:x})", function, name));
      return (current->context_.functions().*member)(name, rest...);
    }
  };
  template <auto member>
  static void* find(const char* function, const char* wanted) {
    if (std::strcmp(function, wanted) != 0) return nullptr;
    Asking<member>::function = function;
    return reinterpret_cast<void*>(&Asking<member>::call);
  }
  static void* get_proc_address(void* user, const char* name) {
    using G = GladGLContext;
    QueryCounter& self = *static_cast<QueryCounter*>(user);
    for (void* const asking :
         {find<&G::GetBooleanv>("glGetBooleanv", name), find<&G::GetBooleani_v>("glGetBooleani_v", name),
          find<&G::GetFloatv>("glGetFloatv", name), find<&G::GetFloati_v>("glGetFloati_v", name),
          find<&G::GetDoublev>("glGetDoublev", name), find<&G::GetIntegerv>("glGetIntegerv", name),
          find<&G::GetIntegeri_v>("glGetIntegeri_v", name), find<&G::GetInteger64v>("glGetInteger64v", name),
          find<&G::GetInteger64i_v>("glGetInteger64i_v", name), find<&G::IsEnabled>("glIsEnabled", name),
          find<&G::IsEnabledi>("glIsEnabledi", name), find<&G::IsBuffer>("glIsBuffer", name),
          find<&G::IsRenderbuffer>("glIsRenderbuffer", name), find<&G::IsSampler>("glIsSampler", name),
          find<&G::IsTexture>("glIsTexture", name), find<&G::IsVertexArray>("glIsVertexArray", name)})
      if (asking) return asking;
    return gl::Context::get_proc_address(&self.context_, name);
  }

  static inline QueryCounter* current = nullptr;
  gl::Context& context_;
  std::set<std::string> asked_;
};

}  // namespace sideray::tests
