#include "cli/base/outputs.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <sideray/sideray.hpp>

#include "cli/base/failure.h"
#include "scenes/base/files.h"

namespace sideray::cli {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void cannot_write(const std::string& path, const std::string& why, const std::string& remedy) {
  throw Error(SIDERAY_INVALID_ARGUMENT, fmt::format("{}: cannot be written: {}; {}", path, why, remedy));
}

[[noreturn]] void cannot_write(const std::string& path, int code) {
  cannot_write(path, std::strerror(code),
               code == ENAMETOOLONG ? "choose a shorter name" : "choose a folder that exists and allows it");
}

// Creates an empty file beside `path`, whose name no other process has on any machine, and removes it at the end.
// Throws Error where none can be created.
class Scratch {
 public:
  explicit Scratch(const std::string& path) : name_(path + ".tmp-XXXXXX") {
    const int file = mkostemp(name_.data(), O_CLOEXEC);
    if (file < 0) cannot_write(path, errno);
    close(file);
  }
  ~Scratch() { unlink(name_.c_str()); }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  const std::string& name() const { return name_; }

 private:
  std::string name_;
};

bool is_same_file(const std::string& a, const std::string& b) {
  std::error_code error;
  if (fs::equivalent(a, b, error)) return true;  // also true for hard links
  std::error_code unknown_a, unknown_b;
  const fs::path full_a = fs::weakly_canonical(fs::absolute(a, error), unknown_a);
  const fs::path full_b = fs::weakly_canonical(fs::absolute(b, error), unknown_b);
  return !unknown_a && !unknown_b && full_a == full_b;
}

void require_apart(const NamedFile& a, const NamedFile& b) {
  if (!a.path.empty() && !b.path.empty() && is_same_file(a.path, b.path))
    wrong_usage("{} {}: is the same file as {}; choose another name", a.what, a.path, b.what);
}

}  // namespace

std::string require_extension(const std::string& what, const std::string& path,
                              const std::vector<std::string>& accepted) {
  std::string extension = fs::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (std::find(accepted.begin(), accepted.end(), extension) == accepted.end())
    wrong_usage("{} {}: unknown kind of file; use {}", what, path, fmt::join(accepted, " or "));
  return extension;
}

// Creates and removes a file, since permission bits say little (root, read-only mounts).
void require_writable(const std::string& path) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) cannot_write(path, "it is a folder", "choose another name");
  const fs::file_status status = fs::status(path, ignored);
  if (fs::exists(status) && !fs::is_regular_file(status))
    cannot_write(path, "it is not a regular file", "choose another name");
  const Scratch scratch(path);
}

void make_folder(const std::string& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error || !fs::is_directory(path))
    scenes::refuse("{}: cannot be made: {}; choose a folder that can be written", path,
                   error ? error.message() : "it is a file");
}

void write_text(const std::string& path, const std::string& text) {
  const std::vector<uint8_t> bytes(text.begin(), text.end());
  scenes::write_file(path, bytes);
}

// Uses a link, which fails where the name is taken; a rename would replace what another machine has just written.
bool write_text_once(const std::string& path, const std::string& text) {
  const Scratch scratch(path);
  write_text(scratch.name(), text);
  const int failure = link(scratch.name().c_str(), path.c_str()) == 0 ? 0 : errno;
  if (failure != 0 && failure != EEXIST) cannot_write(path, failure);
  return failure == 0;
}

bool is_unfinished(const std::string& name) {
  const size_t at = name.rfind(".tmp-");
  return at != std::string::npos && name.size() == at + std::strlen(".tmp-XXXXXX");
}

void require_distinct(const std::vector<NamedFile>& written, const std::vector<NamedFile>& read) {
  for (size_t i = 0; i < written.size(); ++i) {
    for (size_t k = i + 1; k < written.size(); ++k) require_apart(written[i], written[k]);
    for (const NamedFile& input : read) require_apart(written[i], input);
  }
}

}  // namespace sideray::cli
