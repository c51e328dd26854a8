#include "outputs.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <sideray/sideray.hpp>

#include "failure.h"

namespace sideray::cli {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void cannot_write(const std::string& path, const std::string& why) {
  throw Error(SIDERAY_INVALID_ARGUMENT,
              fmt::format("{}: cannot be written: {}; choose a folder that exists and allows it", path, why));
}

std::string scratch_name(const std::string& path) {
  return fmt::format("{}.{}.tmp", path, getpid());
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

// Permission bits say little (root, read-only mounts), so a file is made and removed.
void require_writable(const std::string& path) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) cannot_write(path, "it is a folder");
  const std::string scratch = scratch_name(path);
  const int file = open(scratch.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (file < 0) cannot_write(path, std::strerror(errno));
  close(file);
  unlink(scratch.c_str());
}

void write_text(const std::string& path, const std::string& text) {
  const std::string scratch = scratch_name(path);
  std::FILE* file = std::fopen(scratch.c_str(), "wb");
  if (!file) cannot_write(path, std::strerror(errno));
  const bool written = std::fwrite(text.data(), 1, text.size(), file) == text.size();
  int why = written ? 0 : errno;
  if (std::fclose(file) != 0 && why == 0) why = errno;
  if (why == 0 && std::rename(scratch.c_str(), path.c_str()) != 0) why = errno;
  if (why == 0) return;
  unlink(scratch.c_str());
  cannot_write(path, std::strerror(why));
}

}  // namespace sideray::cli
