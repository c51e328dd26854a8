#include "scenes/base/files.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>

namespace sideray::scenes {
namespace {

namespace fs = std::filesystem;

// Owns a descriptor.
struct OpenFile {
  int descriptor = -1;
  OpenFile() = default;
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  ~OpenFile() {
    if (descriptor >= 0) ::close(descriptor);
  }
};

// Makes a file beside `target` under a unique name, and owns it until it is renamed. Memory is allocated before the
// file is made, so that a failed allocation leaves no file.
struct TemporaryFile : OpenFile {
  std::string name;
  bool is_there = false;
  explicit TemporaryFile(const std::string& target) : name(target + ".tmp-XXXXXX") {
    descriptor = ::mkostemp(name.data(), O_CLOEXEC);
    is_there = descriptor >= 0;
  }
  ~TemporaryFile() {
    if (is_there) ::unlink(name.c_str());
  }
};

const char* remedy_for_reading(int code) {
  switch (code) {
    case ENOENT:
      return "check the path";
    case EACCES:
      return "check its permissions";
    default:
      return "check the file and its disk";
  }
}

const char* remedy_for_writing(int code) {
  switch (code) {
    case ENOENT:
      return "create the folder first";
    case EACCES:
    case EPERM:
    case EROFS:
      return "choose a folder you may write to";
    case ENOSPC:
    case EDQUOT:
    case EFBIG:
      return "free some space or choose another disk";
    default:
      return "choose another path";
  }
}

[[noreturn]] void refuse_writing(const std::string& path, int code) {
  refuse("cannot write {}: {}; {}", path, std::strerror(code), remedy_for_writing(code));
}

// Returns the file at the end of symbolic links. It need not exist: writing through the link would create it.
std::string end_of_links(const std::string& path) {
  constexpr int maximum_links = 40;  // as Linux follows
  fs::path end = path;
  std::error_code error;
  for (int i = 0; i < maximum_links; ++i) {
    if (!fs::is_symlink(fs::symlink_status(end, error))) return end.string();
    const fs::path target = fs::read_symlink(end, error);
    if (error) refuse_writing(path, error.value());
    end = end.parent_path() / target;
  }
  refuse_writing(path, ELOOP);
}

// Returns the file that a rename may replace: the target of a symbolic link, else `path` itself.
std::string write_target(const std::string& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) return end_of_links(path);
  if (!fs::is_regular_file(status)) refuse("cannot write {}: it is not a regular file; choose another path", path);
  if (!fs::is_symlink(fs::symlink_status(path, error))) return path;
  const fs::path target = fs::canonical(path, error);
  return error ? path : target.string();
}

}  // namespace

std::string printable(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return std::iscntrl(static_cast<unsigned char>(c)) != 0; }, ' ');
  return text;
}

uint64_t hash_of(std::span<const uint8_t> bytes, uint64_t before) {
  for (const uint8_t byte : bytes) before = (before ^ byte) * 0x100000001b3u;
  return before;
}

uint64_t file_size(const std::string& path) {
  std::error_code error;
  const uintmax_t size = fs::is_regular_file(path, error) ? fs::file_size(path, error) : 0;
  return error ? 0 : size;
}

std::vector<uint8_t> read_file(const std::string& path, uint64_t maximum_bytes) {
  OpenFile file;
  // Without O_NONBLOCK, opening a pipe that has no writer would block forever.
  file.descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (file.descriptor < 0) refuse("cannot read {}: {}; {}", path, std::strerror(errno), remedy_for_reading(errno));
  struct stat status {};
  if (::fstat(file.descriptor, &status) != 0 || !S_ISREG(status.st_mode)) {
    refuse("cannot read {}: it is not a regular file; check the path", path);
  }
  const auto size = static_cast<uint64_t>(status.st_size);
  if (size > maximum_bytes) {
    refuse("cannot read {}: it has {} bytes, more than the limit of {}; use a smaller file", path, size, maximum_bytes);
  }
  std::vector<uint8_t> bytes(size);
  size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t count = ::read(file.descriptor, bytes.data() + done, bytes.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) refuse("cannot read {}: {}; {}", path, std::strerror(errno), remedy_for_reading(errno));
    if (count == 0) break;
    done += static_cast<size_t>(count);
  }
  bytes.resize(done);
  return bytes;
}

void write_file(const std::string& path, std::span<const uint8_t> bytes) {
  const std::string target = write_target(path);
  TemporaryFile file(target);
  if (!file.is_there) refuse_writing(path, errno);
  size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t count = ::write(file.descriptor, bytes.data() + done, bytes.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) refuse_writing(path, count < 0 ? errno : ENOSPC);
    done += static_cast<size_t>(count);
  }
  // A rename can reach the disk before the bytes do, so that a power cut would leave neither the old nor the new file.
  // Network file systems report a full disk only here. Some file systems do not support the call.
  if (::fsync(file.descriptor) != 0 && errno != EINVAL && errno != ENOSYS && errno != EOPNOTSUPP)
    refuse_writing(path, errno);
  // mkostemp makes private files; a picture should have the permissions of any new file.
  const mode_t mask = ::umask(0);
  ::umask(mask);
  ::fchmod(file.descriptor, static_cast<mode_t>(0666) & ~mask);
  const int closed = ::close(std::exchange(file.descriptor, -1));
  if (closed != 0) refuse_writing(path, errno);
  if (::rename(file.name.c_str(), target.c_str()) != 0) refuse_writing(path, errno);
  file.is_there = false;
}

std::string extension_of(const std::string& path) {
  std::string extension = fs::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

}  // namespace sideray::scenes
