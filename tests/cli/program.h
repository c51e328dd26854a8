// Runs the built `sideray` as a user would, in a separate folder. Test support.
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

namespace sideray::cli_tests {

namespace fs = std::filesystem;

struct Outcome {
  int exit_code = -1;
  std::string output, errors;

  size_t error_lines() const { return static_cast<size_t>(std::count(errors.begin(), errors.end(), '\n')); }
};

inline std::string text_of(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

class Program : public testing::Test {
 protected:
  void SetUp() override {
    const std::string name = testing::UnitTest::GetInstance()->current_test_info()->name();
    folder_ = fs::path(testing::TempDir()) / ("sideray_cli_" + name + "_" + std::to_string(getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  // Runs the program in the test's folder. A shell reads `arguments` and `environment` ("NAME=value ...").
  Outcome run(const std::string& arguments, const std::string& environment = "") const {
    const std::string out = path("stdout.txt"), err = path("stderr.txt");
    const std::string command = "cd '" + folder_.string() + "' && " + environment +
                                " '" SIDERAY_BINARY_DIR "/sideray' " + arguments + " >'" + out + "' 2>'" + err + "'";
    const int status = std::system(command.c_str());
    Outcome outcome{WIFEXITED(status) ? WEXITSTATUS(status) : -1, text_of(out), text_of(err)};
    fs::remove(out);
    fs::remove(err);
    return outcome;
  }

  // Returns false where a test may be skipped for lack of OpenGL: never where contexts are promised (script/test).
  bool can_draw() const {
    if (std::getenv("SIDERAY_REQUIRE_CONTEXTS")) return true;
    for (const nlohmann::json& device : nlohmann::json::parse(run("devices --json").output))
      if (device["usable"].get<bool>() && device["gl"] != "none") return true;
    return false;
  }

  std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_))
      names.push_back(entry.path().filename().string());
    return names;
  }

  // Expects one line "sideray: what: why; what to do" on standard error, nothing on standard output, and no file.
  void expect_refused(const std::string& arguments, int exit_code, const std::string& says,
                      const std::string& environment = "") const {
    SCOPED_TRACE("sideray " + arguments);
    const std::vector<std::string> before = files();
    const Outcome outcome = run(arguments, environment);
    EXPECT_EQ(outcome.exit_code, exit_code) << outcome.errors;
    EXPECT_EQ(outcome.output, "");
    EXPECT_EQ(outcome.error_lines(), 1u) << outcome.errors;
    EXPECT_TRUE(outcome.errors.starts_with("sideray: ")) << outcome.errors;
    EXPECT_NE(outcome.errors.find("; "), std::string::npos) << outcome.errors;
    EXPECT_NE(outcome.errors.find(says), std::string::npos) << outcome.errors;
    EXPECT_EQ(files(), before);
  }

  fs::path folder_;
};

}  // namespace sideray::cli_tests
