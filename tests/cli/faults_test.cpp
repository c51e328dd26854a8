// Lets every allocation and every file call fail in turn, once or permanently. An output must be the whole old or the
// whole new file, no partial file may be left, and the program must end with an exit code and one line with the remedy.
// SIDERAY_FAULTS_FROM=N makes the Slow tests begin at place N, SIDERAY_FAULTS_STEP=N take every N-th place.
#include <array>
#include <map>

#include "cli/program.h"

namespace sideray::cli_tests::faults_test {
namespace {

using nlohmann::json;

const std::string old_text = "the old file\n";

struct Counts {
  uint64_t allocations = 0, files = 0, failures = 0;
};

class Faults : public Program {
 protected:
  void SetUp() override {
#if !defined(SIDERAY_FAILING_CALLS)
    GTEST_SKIP() << "sanitizers have an allocator of their own";
#endif
    Program::SetUp();
    if (!can_draw()) GTEST_SKIP() << "no OpenGL device; see sideray devices";
  }

  // Runs in the folder "work", a fresh copy of the folder "before".
  Outcome fault(const std::string& arguments, const std::string& which) {
    fs::remove_all(path("work"));
    fs::copy(path("before"), path("work"), fs::copy_options::recursive);
#if defined(SIDERAY_FAILING_CALLS)
    const std::string shim = SIDERAY_FAILING_CALLS;
#else
    const std::string shim;
#endif
    const Outcome outcome = run(arguments, "env -C work SIDERAY_CACHE=off LD_PRELOAD='" + shim +
                                               "' SIDERAY_FAULT=" + which + " SIDERAY_FAULT_COUNT=../count");
    std::ifstream(path("count"), std::ios::binary).read(reinterpret_cast<char*>(&counts_), sizeof(counts_));
    return outcome;
  }

  void expect_nothing_unfinished(const std::string& which) const {
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(path("work")))
      EXPECT_EQ(entry.path().string().find(".tmp"), std::string::npos) << which << " leaves " << entry.path();
  }

  void expect_told(const Outcome& outcome, const std::string& which) {
    constexpr int killed_by_segv = 139;
    if (outcome.exit_code == killed_by_segv && crashes_.size() < known_crashes_) {
      crashes_.push_back(which);
      return;
    }
    ASSERT_TRUE(outcome.exit_code == 0 || outcome.exit_code == 1 || outcome.exit_code == 2)
        << which << ": " << outcome.exit_code << "\n"
        << outcome.errors;
    if (outcome.exit_code == 0) return;
    // Warnings may precede the error.
    const size_t last = outcome.errors.rfind("sideray: ");
    ASSERT_NE(last, std::string::npos) << which << ": " << outcome.errors;
    EXPECT_NE(outcome.errors.find("; ", last), std::string::npos) << which << ": " << outcome.errors;
    for (size_t line = 0; line < outcome.errors.size(); line = outcome.errors.find('\n', line) + 1)
      EXPECT_EQ(outcome.errors.compare(line, 9, "sideray: "), 0) << which << ": " << outcome.errors;
  }

  struct Output {
    std::string arguments, file;
    // Returns whether a text is the whole new file, given that of an undisturbed run.
    bool (*is_whole)(const std::string& text, const std::string& whole);
  };

  void expect_old_or_new(const Output& output, const std::string& which) {
    const Outcome outcome = fault(output.arguments, which);
    expect_told(outcome, which);
    expect_nothing_unfinished(which);
    const std::string text = text_of(path("work/" + output.file));
    const bool is_new = text != old_text && output.is_whole(text, whole_);
    EXPECT_TRUE(is_new || text == old_text) << which << ": " << text.size() << " bytes";
    if (outcome.exit_code == 0) {
      EXPECT_TRUE(is_new) << which << ": nothing written, and not told";
    }
  }

  Counts count(const Output& output) {
    const Outcome outcome = fault(output.arguments, "none");
    EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
    whole_ = text_of(path("work/" + output.file));
    EXPECT_NE(whole_, old_text);
    EXPECT_TRUE(output.is_whole(whole_, whole_));
    EXPECT_GT(counts_.allocations, 1000u);
    EXPECT_GT(counts_.files, 10u);
    return counts_;
  }

  // Fails at `places` evenly spread places of each kind, and permanently from half as many.
  void sample(const Output& output, uint64_t places) {
    const Counts all = count(output);
    for (const auto& [kind, number] :
         std::map<std::string, uint64_t>{{"allocation:", all.allocations}, {"file:", all.files}})
      for (uint64_t i = 0; i < places; ++i) {
        const std::string which =
            kind + std::to_string(1 + (2 * i + 1) * number / (2 * places)) + (i % 3 == 1 ? "+" : "");
        expect_old_or_new(output, which);
        EXPECT_GT(counts_.failures, 0u) << which;
      }
  }

  // Fails at every place. `known_crashes` counts places in libraries that crash without memory (docs/limits.md), each
  // once and permanently.
  void every_place(const Output& output, size_t known_crashes) {
    known_crashes_ = known_crashes;
    const uint64_t first = setting("SIDERAY_FAULTS_FROM"), step = setting("SIDERAY_FAULTS_STEP");
    count(output);
    for (const std::string kind : {"file:", "allocation:"})
      for (const char* lasting : {"", "+"}) {
        uint64_t number = first;
        // Not every run reaches the last places: it depends on which thread allocates.
        for (uint64_t without = 0; without < 3; number += step) {
          expect_old_or_new(output, kind + std::to_string(number) + lasting);
          without = counts_.failures == 0 ? without + 1 : 0;
        }
        std::printf("%s%s %llu places\n", kind.c_str(), lasting,
                    static_cast<unsigned long long>((number - first) / step - 3));
        std::fflush(stdout);
      }
    for (const std::string& crash : crashes_) std::printf("crash of others' code: %s\n", crash.c_str());
  }

  void write(const std::string& name, const std::string& text) const {
    fs::create_directories(fs::path(path(name)).parent_path());
    std::ofstream(path(name)) << text;
  }

  Output render() {
    write("before/o.exr", old_text);
    return {"render panes -o o.exr --size 16x9 --threads 1 --shadows exact --ambient ao", "o.exr",
            [](const std::string& text, const std::string& whole) { return text == whole; }};
  }
  Output chart() {
    write("before/s.json", R"([{"translucency": "off"}, {"layers": 2}])");
    write("before/d/results.json", old_text);
    return {chart_arguments, "d/results.json", has_all_rows};
  }
  Output gather() {
    write("before/s.json", R"([{"translucency": "off"}, {"layers": 2}])");
    for (const char* task : {"0", "1"}) {
      const Outcome made =
          run(chart_arguments + " --shard auto", std::string("env -C before SIDERAY_CACHE=off SLURM_ARRAY_TASK_MIN=0 "
                                                             "SLURM_ARRAY_TASK_MAX=1 SLURM_ARRAY_TASK_STEP=1 "
                                                             "SLURM_ARRAY_TASK_COUNT=2 SLURM_ARRAY_TASK_ID=") +
                                                     task);
      EXPECT_EQ(made.exit_code, 0) << made.errors;
    }
    write("before/d/results.json", old_text);
    return {"gather d", "d/results.json", has_all_rows};
  }

 private:
  static uint64_t setting(const char* name) {
    const char* text = std::getenv(name);
    return text ? std::stoull(text) : 1;
  }
  // Times differ from run to run.
  static bool has_all_rows(const std::string& text, const std::string&) {
    const json results = json::parse(text, nullptr, false);
    return results.is_object() && results.contains("reference") && results.contains("rows") &&
           results["rows"].size() == 2;
  }
  const std::string chart_arguments =
      "chart panes -o d --sweep s.json --size 16x9 --light-samples 1 --repeat 1 --threads 1";

  std::string whole_;
  Counts counts_{};
  size_t known_crashes_ = 0;
  std::vector<std::string> crashes_;
};

TEST_F(Faults, Render) {
  sample(render(), 6);
}
TEST_F(Faults, Chart) {
  sample(chart(), 3);
}
TEST_F(Faults, Gather) {
  sample(gather(), 6);
}

// These include the call that writes the bytes, all other file calls, and zlib's failing block.
class SlowFaults : public Faults {};

TEST_F(SlowFaults, EveryPlaceOfRender) {
  every_place(render(), 4);
}
TEST_F(SlowFaults, EveryPlaceOfChart) {
  every_place(chart(), 4);
}
TEST_F(SlowFaults, EveryPlaceOfGather) {
  every_place(gather(), 4);
}

}  // namespace
}  // namespace sideray::cli_tests::faults_test
