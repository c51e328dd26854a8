// A loader that makes a context look like that of an older driver: it hides functions and values that this driver
// lacks, and records their use. Test support, one at a time.
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
  bool all_but = false;                          // all extensions of the context but the ones above
  std::vector<std::string> null_functions = {};  // missing although version or extensions promise them
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
  // Returns hidden functions and values that were used.
  const std::set<std::string>& used() const { return used_; }
  // Says whether results of queries stay unavailable.
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
