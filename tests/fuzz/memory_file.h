// A file in memory under a name that any reader can open: thousands of inputs without a disk. Test support; one thread.
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>

namespace sideray::tests {

class MemoryFile {
 public:
  explicit MemoryFile(const std::string& extension) : descriptor_(::memfd_create("input", 0)) {
    // Readers go by the extension: a link gives one to the nameless file.
    const std::string target = "/proc/self/fd/" + std::to_string(descriptor_);
    path_ = "/tmp/sideray-input-" + std::to_string(::getpid()) + "-" + std::to_string(descriptor_) + extension;
    ::unlink(path_.c_str());
    if (descriptor_ < 0 || ::symlink(target.c_str(), path_.c_str()) != 0)
      throw std::runtime_error("no file in memory at " + path_);
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  ~MemoryFile() {
    ::unlink(path_.c_str());
    ::close(descriptor_);
  }

  // Replaces what the file holds.
  void put(std::span<const uint8_t> bytes) {
    const auto size = static_cast<ssize_t>(bytes.size());
    if (::ftruncate(descriptor_, 0) != 0 || ::pwrite(descriptor_, bytes.data(), bytes.size(), 0) != size)
      throw std::runtime_error("cannot write " + path_);
  }
  const std::string& path() const { return path_; }

 private:
  int descriptor_;
  std::string path_;
};

}  // namespace sideray::tests
