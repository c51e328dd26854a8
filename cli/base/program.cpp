#include "cli/base/program.h"

#include <fmt/format.h>
#include <link.h>
#include <sideray/sideray.h>

#include <algorithm>
#include <string_view>
#include <vector>

#include "scenes/base/files.h"

namespace sideray::cli {
namespace {

// The program itself has an empty name in the list of loaded objects.
int add_own_file(dl_phdr_info* object, size_t, void* data) {
  const std::string_view name = object->dlpi_name;
  auto& files = *static_cast<std::vector<std::string>*>(data);
  if (name.empty() && files.empty()) files.emplace_back("/proc/self/exe");
  if (name.find("libsideray") != std::string_view::npos) files.emplace_back(name);
  return 0;
}

uint64_t hash_of_program() {
  constexpr uint64_t most_bytes = uint64_t{1} << 30;
  std::vector<std::string> files;
  dl_iterate_phdr(add_own_file, &files);
  std::sort(files.begin(), files.end());
  uint64_t hash = scenes::empty_hash;
  for (const std::string& file : files) hash = scenes::hash_of(scenes::read_file(file, most_bytes), hash);
  return hash;
}

}  // namespace

std::string program_version() {
  int major = 0, minor = 0, patch = 0;
  sideray_version(&major, &minor, &patch);
  return fmt::format("{}.{}.{}", major, minor, patch);
}

const std::string& program_build() {
  static const std::string build = fmt::format("{}-{:016x}", program_version(), hash_of_program());
  return build;
}

}  // namespace sideray::cli
