#include "cli/run/run.h"

#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "cli/base/failure.h"

namespace sideray::cli {
namespace {

constexpr const char* library_name = "libsideray_run.so";

// Returns the path beside the program in a build, or in the library folder beside bin/ in an installation.
std::string library_path() {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::path folder = fs::read_symlink("/proc/self/exe", error).parent_path();
  for (const fs::path& place : {folder, folder.parent_path() / SIDERAY_LIBRARY_FOLDER / "sideray"})
    if (fs::exists(place / library_name, error)) return (place / library_name).string();
  wrong_usage("run: {} is neither beside the program nor in {}; build or install it again", library_name,
              (folder.parent_path() / SIDERAY_LIBRARY_FOLDER / "sideray").string());
}

// Returns an absolute path, since the program may change its working directory.
std::string absolute(const std::string& path) {
  return path.empty() ? path : std::filesystem::absolute(path).string();
}

void set(const char* name, const std::string& value) {
  if (value.empty())
    ::unsetenv(name);
  else
    ::setenv(name, value.c_str(), 1);
}

void preload(const std::string& library) {
  const char* others = std::getenv("LD_PRELOAD");
  set("LD_PRELOAD", others && *others ? library + ":" + others : library);
}

}  // namespace

int run_program(const RunArguments& arguments) {
  if (arguments.words.empty()) wrong_usage("run: no program; write sideray run [OPTIONS] -- PROGRAM [ARGUMENTS]");
  if (!arguments.rules.empty() && ::access(arguments.rules.c_str(), R_OK) != 0)
    wrong_usage("run: --rules: {} cannot be read: {}; name a file that is there", arguments.rules, std::strerror(errno));
  set("SIDERAY_RUN_RULES", absolute(arguments.rules));
  set("SIDERAY_RUN_REPORT", absolute(arguments.report));
  set("SIDERAY_RUN_CAPTURE", absolute(arguments.capture));
  set("SIDERAY_RUN_PICTURES", absolute(arguments.pictures));
  set("SIDERAY_RUN_OFF", arguments.off ? "1" : "");
  set("SIDERAY_RUN_LATE", arguments.late ? "1" : "");
  preload(library_path());
  std::vector<char*> words;
  for (const std::string& word : arguments.words) words.push_back(const_cast<char*>(word.c_str()));
  words.push_back(nullptr);
  ::execvp(words[0], words.data());
  wrong_usage("run: {} cannot be run: {}; check its name and its rights", words[0], std::strerror(errno));
}

}  // namespace sideray::cli
