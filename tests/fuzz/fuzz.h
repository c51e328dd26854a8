// What the fuzz targets share: a file in memory that the readers can open, and what an Error must look like. One
// thread.
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <string>

namespace sideray::fuzz {

// Ends the run, so that the fuzzer keeps the input.
[[noreturn]] inline void broken(const std::string& promise, const std::string& detail) {
  std::fprintf(stderr, "broken promise: %s: %s\n", promise.c_str(), detail.c_str());
  std::abort();
}

// The bytes under a name that any reader can open.
class MemoryFile {
 public:
  MemoryFile(std::span<const uint8_t> bytes, const std::string& extension) : descriptor_(::memfd_create("input", 0)) {
    if (descriptor_ < 0 || ::write(descriptor_, bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size()))
      broken("an input can be stored", "memfd_create");
    // Readers go by the extension: a link gives one to the nameless file.
    path_ = "/tmp/sideray-fuzz-" + std::to_string(::getpid()) + extension;
    ::unlink(path_.c_str());
    const std::string target = "/proc/self/fd/" + std::to_string(descriptor_);
    if (::symlink(target.c_str(), path_.c_str()) != 0) broken("an input can be named", path_);
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  ~MemoryFile() {
    ::unlink(path_.c_str());
    ::close(descriptor_);
  }
  const std::string& path() const { return path_; }

 private:
  int descriptor_;
  std::string path_;
};

// "what: why; what to do", one line, of printable characters (or UTF-8).
inline void check_message(const std::string& message) {
  for (const char c : message) {
    const auto code = static_cast<unsigned char>(c);
    if (code < 0x20 || code == 0x7f) broken("an error is one printable line", message);
  }
  if (message.find(": ") == std::string::npos || message.find("; ") == std::string::npos)
    broken("an error says what: why; what to do", message);
}

}  // namespace sideray::fuzz
