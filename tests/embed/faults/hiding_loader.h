// A loader that makes a context look like one of an older driver: what that driver has neither by version nor by
// extension is hidden, and its use recorded. Test support, one at a time.
#pragma once

#include <sideray/sideray.h>

#include <map>
#include <ostream>
#include <set>
#include <string>
#include <vector>

#include "gl/context/context.h"

namespace sideray::tests {

struct Driver {
  std::string name = "";                         // of the test
  int version = 21;                              // 21: OpenGL 2.1
  std::vector<std::string> extensions = {};      // without GL_
  bool all_but = false;                          // those of the context, without the ones above
  std::vector<std::string> null_functions = {};  // for which the loader returns null, though they should be there
};

inline void PrintTo(const Driver& driver, std::ostream* out) {
  *out << driver.name;
}

class HidingLoader {
 public:
  // `context` is current, and of a compatibility profile.
  HidingLoader(gl::Context& context, const Driver& driver);
  ~HidingLoader();
  HidingLoader(const HidingLoader&) = delete;
  HidingLoader& operator=(const HidingLoader&) = delete;

  static void* get_proc_address(void* loader, const char* name);
  sideray_host_gl host() { return {sizeof(sideray_host_gl), &get_proc_address, this}; }
  // What was called, or given to a call, although it is hidden.
  const std::set<std::string>& used() const { return used_; }
  // Whether no result of a query is there yet, whatever the driver says.
  void hold_queries(bool held) { queries_held_ = held; }

 private:
  friend struct Watch;
  bool has(const std::string& provider) const;  // "VERSION_3_0" or "ARB_sync"
  bool is_hidden(const std::string& function) const;
  void read_providers();
  void see(int64_t value);

  gl::Context& context_;
  const Driver driver_;
  bool queries_held_ = false;
  std::set<std::string> extensions_, used_;
  std::map<std::string, std::vector<std::string>> providers_;  // of each function
  std::string version_, glsl_, all_extensions_;
};

}  // namespace sideray::tests
