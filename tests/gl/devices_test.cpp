// Tests the list of devices on machines that lack something. Drivers read their environment once, so each case runs
// this program again, with variables that hide a part.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <vector>

#include "gl/gl_contexts.h"
#include "model/failure.h"

namespace sideray::gl {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

struct Outcome {
  int exit_code = -1;  // -1: killed by a signal, which `output` then names
  std::string output;
};

// `environment`: "NAME=value NAME=value", put before the command.
Outcome run_child(const std::string& environment, const std::string& test) {
  const std::string program = std::filesystem::read_symlink("/proc/self/exe").string();
  // `exec` replaces the shell, which would report the child's crash as this program's.
  const std::string command = "exec env " + environment + " '" + program + "' --gtest_also_run_disabled_tests " +
                              "--gtest_filter='" + test + "' 2>&1";
  Outcome outcome;
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return outcome;
  char part[4096];
  for (size_t n = fread(part, 1, sizeof part, pipe); n > 0; n = fread(part, 1, sizeof part, pipe))
    outcome.output.append(part, n);
  const int status = pclose(pipe);
  if (WIFEXITED(status)) outcome.exit_code = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) outcome.output += fmt::format("\n({}: killed by signal {})\n", test, WTERMSIG(status));
  return outcome;
}

std::string line_of(const Outcome& outcome, const std::string& id) {
  const std::string start = "\ndevice " + id + " ";
  const size_t at = outcome.output.find(start);
  if (at == std::string::npos) return "no line for " + id + " in: " + outcome.output;
  return outcome.output.substr(at + 1, outcome.output.find('\n', at + 1) - at - 1);
}

// The variables of these cases mean nothing to other drivers.
bool has_mesa_surfaceless() {
  const std::unique_ptr<Context> context = open_context("surfaceless");
  return context != nullptr && context->info().version.find("Mesa") != std::string::npos;
}

TEST(Child, DISABLED_ListDevices) {
  for (const DeviceInfo& device : list_devices()) {
    std::cout << "\ndevice " << device.id << " " << (device.usable ? "usable " : "unusable ") << device.version
              << device.reason << std::endl;
    EXPECT_EQ(device.usable, device.reason.empty());
  }
}

TEST(Child, DISABLED_Create) {
  try {
    const std::unique_ptr<Context> context = Context::create("auto", "");
    std::cout << "created " << context->info().id << " " << context->info().version << std::endl;
  } catch (const Failure& failure) {
    std::cout << "failure " << failure.status << " " << failure.what() << std::endl;
  }
}

TEST(Devices, HereEachIsUsableOrSaysWhyNot) {
  for (const DeviceInfo& device : list_devices()) {
    EXPECT_FALSE(device.id.empty());
    EXPECT_EQ(device.usable, device.reason.empty()) << device.id;
    EXPECT_EQ(device.usable, !device.renderer.empty()) << device.id;
    EXPECT_EQ(device.reason.find('\n'), std::string::npos) << device.id;
  }
}

TEST(Devices, IdsAreUniqueAndStable) {
  const std::vector<DeviceInfo> first = list_devices(), second = list_devices();
  ASSERT_EQ(first.size(), second.size());
  for (size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].id, second[i].id);
    for (size_t k = 0; k < i; ++k) EXPECT_NE(first[i].id, first[k].id);
  }
}

TEST(Devices, MissingVendorFileIsExplained) {
  const Outcome outcome = run_child("__EGL_VENDOR_LIBRARY_FILENAMES=/no/vendor.json", "Child.DISABLED_ListDevices");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_THAT(line_of(outcome, "egl"), AllOf(HasSubstr("unusable"), HasSubstr("vendor file"),
                                             HasSubstr("__EGL_VENDOR_LIBRARY_FILENAMES=/no/vendor.json")));
}

// Mesa has its drivers in one library since 24.3, and looks in no folder for them.
bool mesa_searches_folders() {
  const std::unique_ptr<Context> context = open_context("surfaceless");
  const std::string version = context ? context->info().version : "";
  const size_t at = version.find("Mesa ");
  int major = 0, minor = 0;
  if (at == std::string::npos || std::sscanf(version.c_str() + at, "Mesa %d.%d", &major, &minor) != 2) return false;
  return major < 24 || (major == 24 && minor < 3);
}

TEST(Devices, MissingDriverIsExplained) {
  std::vector<const char*> environments{"GALLIUM_DRIVER=nonsense"};
  if (mesa_searches_folders()) environments.push_back("LIBGL_DRIVERS_PATH=/no/drivers");
  for (const char* environment : environments) {
    // Mesa leaks what it had when it finds no driver.
    const Outcome outcome =
        run_child(std::string("ASAN_OPTIONS=detect_leaks=0 ") + environment, "Child.DISABLED_ListDevices");
    EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
    if (!has_mesa_surfaceless()) GTEST_SKIP() << "no surfaceless EGL of Mesa here";
    EXPECT_THAT(line_of(outcome, "egl:surfaceless"),
                AllOf(HasSubstr("unusable"), HasSubstr("driver"), HasSubstr(environment)));
  }
}

// A file that is no library, first in the search path, takes the real one's place.
TEST(Devices, MissingLibrariesAreExplainedAllAtOnce) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "sideray_no_libraries";
  std::filesystem::create_directories(folder);
  for (const char* name : {"libEGL.so.1", "libOSMesa.so.8", "libOSMesa.so.6"})
    std::ofstream(folder / name) << "not a library";
  // Keeps the path by which this program's own libraries were found.
  const char* given = std::getenv("LD_LIBRARY_PATH");
  const std::string path =
      "'LD_LIBRARY_PATH=" + folder.string() + (given != nullptr ? ":" : "") + (given != nullptr ? given : "") + "'";
  const Outcome listing = run_child(path, "Child.DISABLED_ListDevices");
  const Outcome creation = run_child(path, "Child.DISABLED_Create");
  std::filesystem::remove_all(folder);
  EXPECT_EQ(listing.exit_code, 0) << listing.output;
  EXPECT_THAT(line_of(listing, "egl"), AllOf(HasSubstr("unusable"), HasSubstr("libEGL.so.1"), HasSubstr("libegl1")));
  EXPECT_THAT(line_of(listing, "osmesa"),
              AllOf(HasSubstr("unusable"), HasSubstr("libOSMesa"), HasSubstr("libosmesa6")));
  EXPECT_EQ(creation.exit_code, 0) << creation.output;
  EXPECT_THAT(creation.output, AllOf(HasSubstr("failure -4 no usable OpenGL device"), HasSubstr("libegl1"),
                                     HasSubstr("libosmesa6"), HasSubstr("no display is needed")));
}

TEST(Devices, TooOldADriverIsExplained) {
  const Outcome outcome = run_child("MESA_GL_VERSION_OVERRIDE=3.0", "Child.DISABLED_ListDevices");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  if (!has_mesa_surfaceless()) GTEST_SKIP() << "no surfaceless EGL of Mesa here";
  EXPECT_THAT(line_of(outcome, "egl:surfaceless"), AllOf(HasSubstr("unusable"), HasSubstr("3.3")));
}

// The oldest OpenGL that is served, on the same machine.
TEST(Devices, OpenGl33PassesTheSameTests) {
  if (!has_mesa_surfaceless()) GTEST_SKIP() << "no surfaceless EGL of Mesa here";
  const Outcome outcome = run_child("MESA_GL_VERSION_OVERRIDE=3.3",
                                    "*EveryContext.*/surfaceless:*StateGuard*:-*Debug*:*Messages*:*Listing*");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  const Outcome creation = run_child("MESA_GL_VERSION_OVERRIDE=3.3", "Child.DISABLED_Create");
  EXPECT_THAT(creation.output, HasSubstr(" 3.3")) << creation.output;
}

}  // namespace
}  // namespace sideray::gl
