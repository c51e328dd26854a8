// Tests runs that many tasks share: the variables of schedulers, the record of the first task, refusals, and gathering.
// Here a scheduler is just its environment variables; tests/cluster has a real one.
#include <fcntl.h>
#include <sys/stat.h>
#include <chrono>
#include <csignal>
#include <thread>

#include "cli/program.h"

namespace sideray::cli_tests::cluster_test {
namespace {

using nlohmann::json;

constexpr int usage = 2;

std::string slurm(int id, int count) {
  return "SLURM_ARRAY_TASK_MIN=0 SLURM_ARRAY_TASK_STEP=1 SLURM_ARRAY_TASK_ID=" + std::to_string(id) +
         " SLURM_ARRAY_TASK_MAX=" + std::to_string(count - 1) + " SLURM_ARRAY_TASK_COUNT=" + std::to_string(count);
}

// No frame depends on the previous one.
const std::string scene = "smoke --size 48x27 --frames 2-9 --fps 4 --taa off --denoise off";
const std::string sequence = "render " + scene + " -o d/f.#.exr --shard auto";

class Cluster : public Program {
 protected:
  void SetUp() override {
    Program::SetUp();
    if (!can_draw()) GTEST_SKIP() << "no OpenGL device; see sideray devices";
  }
  void task(int id, int count, const std::string& arguments = sequence) {
    const Outcome outcome = run(arguments, slurm(id, count));
    ASSERT_EQ(outcome.exit_code, 0) << arguments << "\n" << outcome.errors;
  }
  json status(const std::string& folder = "d") {
    const Outcome outcome = run("status " + folder + " --json");
    EXPECT_EQ(outcome.errors, "");
    const json result = json::parse(outcome.output);
    EXPECT_EQ(outcome.exit_code, result["missing"].empty() && !result["mixed"].get<bool>() ? 0 : 1);
    return result;
  }
  Outcome gather(int exit_code, const std::string& folder = "d") {
    const Outcome outcome = run("gather " + folder);
    EXPECT_EQ(outcome.exit_code, exit_code) << outcome.errors;
    EXPECT_EQ(outcome.error_lines(), exit_code == 0 ? 0u : 1u) << outcome.errors;
    return outcome;
  }
  std::vector<std::string> files_of(const std::string& folder) const {
    std::vector<std::string> names;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(path(folder)))
      names.push_back(entry.path().lexically_relative(path(folder)).string());
    std::sort(names.begin(), names.end());
    return names;
  }
  json read(const std::string& name) const { return json::parse(text_of(path(name))); }
  void edit(const std::string& name, const nlohmann::ordered_json& change) {
    auto content = nlohmann::ordered_json::parse(text_of(path(name)));
    content.merge_patch(change);
    std::ofstream(path(name)) << content;
  }
  // Runs tasks at the same time, and returns their exit codes.
  std::vector<int> run_at_once(const std::vector<std::string>& environments, const std::string& arguments) {
    std::string command = "cd '" + folder_.string() + "' && rm -f code.*; ";
    for (size_t i = 0; i < environments.size(); ++i)
      command += "(" + environments[i] + " '" SIDERAY_BINARY_DIR "/sideray' " + arguments + " >/dev/null 2>errors." +
                 std::to_string(i) + "; echo $? >code." + std::to_string(i) + ") & ";
    EXPECT_EQ(std::system((command + "wait").c_str()), 0);
    std::vector<int> codes;
    for (size_t i = 0; i < environments.size(); ++i)
      codes.push_back(std::stoi(text_of(path("code." + std::to_string(i)))));
    return codes;
  }
  void expect_bits_of_one_machine() {
    ASSERT_EQ(run("render " + scene + " -o w.#.exr").exit_code, 0);
    for (int frame = 2; frame <= 9; ++frame) {
      const std::string name = std::to_string(frame) + ".exr";
      EXPECT_EQ(text_of(path("d/f." + name)), text_of(path("w." + name))) << name;
    }
  }
};

TEST_F(Cluster, VariablesThatAreMissingOddOrContradictingAreRefused) {
  const auto refused = [&](const std::string& environment, const std::string& shard, const std::string& says) {
    SCOPED_TRACE(environment + " " + shard);
    expect_refused("render panes --frames 0-3 -o x.#.exr --shard " + shard, usage, says, environment);
  };
  const std::string array =
      "SLURM_ARRAY_TASK_MIN=2 SLURM_ARRAY_TASK_STEP=3 SLURM_ARRAY_TASK_COUNT=2 SLURM_ARRAY_TASK_ID=";
  refused("", "auto", "neither SLURM_ARRAY_TASK_ID");
  refused("SGE_TASK_ID=undefined", "auto/4", "neither SLURM_ARRAY_TASK_ID");
  refused("SLURM_ARRAY_TASK_ID=1", "auto", "SLURM_ARRAY_TASK_MIN is not set");
  refused("SLURM_ARRAY_TASK_ID=x", "auto/4", "SLURM_ARRAY_TASK_ID is \"x\"");
  refused("SLURM_ARRAY_TASK_ID=-1", "auto/4", "SLURM_ARRAY_TASK_ID is \"-1\"");
  refused("SLURM_ARRAY_TASK_ID=4", "auto/4", "SLURM_ARRAY_TASK_ID is 4; number the tasks 0 to 3");
  refused(array + "1", "auto", "SLURM_ARRAY_TASK_ID is 1");
  refused(array + "4", "auto", "SLURM_ARRAY_TASK_ID is 4");
  refused(array + "8", "auto", "SLURM_ARRAY_TASK_ID is 8");
  // --array=2,5,6: only the largest number shows that these are not 2, 3, 4.
  refused(
      "SLURM_ARRAY_TASK_MIN=2 SLURM_ARRAY_TASK_STEP=1 SLURM_ARRAY_TASK_COUNT=3 SLURM_ARRAY_TASK_MAX=6 "
      "SLURM_ARRAY_TASK_ID=2",
      "auto", "SLURM_ARRAY_TASK_MAX is 6");
  refused("SLURM_ARRAY_TASK_MIN=0 SLURM_ARRAY_TASK_STEP=0 SLURM_ARRAY_TASK_COUNT=3 SLURM_ARRAY_TASK_ID=0", "auto",
          "SLURM_ARRAY_TASK_STEP is \"0\"");
  refused("JOB_COMPLETION_INDEX=1", "auto", "JOB_COMPLETION_COUNT is not set");
  refused("JOB_COMPLETION_INDEX=1 JOB_COMPLETION_COUNT=3", "auto/4", "JOB_COMPLETION_COUNT is 3");
  refused("JOB_COMPLETION_INDEX=3 JOB_COMPLETION_COUNT=3", "auto", "JOB_COMPLETION_INDEX is 3");
  refused("SGE_TASK_ID=1", "auto", "GridEngine gives no count");
  refused("SGE_TASK_ID=5", "auto/4", "SGE_TASK_ID is 5; number the tasks 1 to 4");
  refused("SGE_TASK_ID=1 SGE_TASK_STEPSIZE=2", "auto/4", "SGE_TASK_STEPSIZE is 2");
  refused("SGE_TASK_ID=1 JOB_COMPLETION_INDEX=0", "auto/4", "both JOB_COMPLETION_INDEX and SGE_TASK_ID");
  refused("SLURM_ARRAY_TASK_ID=0", "auto/0", "--shard");
  refused("SLURM_ARRAY_TASK_ID=0", "auto/x", "--shard");
  refused("SLURM_ARRAY_TASK_ID=0", "auto/4/2", "--shard");
  refused(slurm(0, 2), "auto --max-ms 5", "--max-ms: every task would choose for itself");
  refused(slurm(0, 2), "auto --camera nosuch", "nosuch");
  expect_refused("render panes -o x.exr --shard auto", usage, "--shard", slurm(0, 2));
  expect_refused("chart panes -o d --ledger --shard auto", usage, "--ledger", slurm(0, 2));
  EXPECT_FALSE(fs::exists(path("d")));
}

// Each scheduler's variables give the task's block of twelve frames.
TEST_F(Cluster, EverySchedulerSaysWhichShard) {
  int runs = 0;
  const auto draws = [&](const std::string& environment, const std::string& shard, const std::vector<int>& frames) {
    SCOPED_TRACE(environment + " " + shard);
    const std::string folder = "d" + std::to_string(runs++);
    const Outcome outcome = run(
        "render empty --size 16x9 --shadows off --frames 0-11 -o " + folder + "/#.png --shard " + shard, environment);
    ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
    for (int frame = 0; frame < 12; ++frame)
      EXPECT_EQ(fs::exists(path(folder + "/" + std::to_string(frame) + ".png")),
                std::find(frames.begin(), frames.end(), frame) != frames.end())
          << frame;
  };
  draws("SLURM_ARRAY_TASK_MIN=10 SLURM_ARRAY_TASK_STEP=5 SLURM_ARRAY_TASK_COUNT=4 SLURM_ARRAY_TASK_ID=20", "auto",
        {6, 7, 8});
  draws("SLURM_ARRAY_TASK_MIN=2 SLURM_ARRAY_TASK_STEP=1 SLURM_ARRAY_TASK_COUNT=2 SLURM_ARRAY_TASK_ID=5", "auto/6",
        {10, 11});
  draws("JOB_COMPLETION_INDEX=1 JOB_COMPLETION_COUNT=6", "auto", {2, 3});
  draws("SGE_TASK_ID=6 SGE_TASK_STEPSIZE=1", "auto/6", {10, 11});
}

TEST_F(Cluster, ARunIsGatheredWithTheBitsOfOneMachine) {
  const std::string with_stats = "render " + scene + " -o d/f.#.exr --stats d/s.jsonl --shard auto";
  task(1, 3, with_stats);
  json now = status();
  EXPECT_EQ(now["missing"], json({2, 3, 7, 8, 9}));
  EXPECT_EQ(now["done"], 3);
  EXPECT_EQ(now["retry"], "sbatch --array=0,2");
  EXPECT_NE(
      gather(1).errors.find("5 of 8 are missing or not whole: 2-3, 7-9; run with --shard auto/3: sbatch --array=0,2"),
      std::string::npos);
  task(0, 3, with_stats);
  // With a list of tasks, auto/3 gives the number of shards.
  ASSERT_EQ(run(with_stats + "/3", "SLURM_ARRAY_TASK_ID=2").exit_code, 0);
  now = status();
  EXPECT_EQ(now["missing"], json::array());
  EXPECT_EQ(now["retry"], "");
  const Outcome done = gather(0);
  EXPECT_NE(done.output.find("whole, 8 of "), std::string::npos) << done.output;
  std::istringstream lines(text_of(path("d/s.jsonl")));
  int frame = 2;
  for (std::string line; std::getline(lines, line); ++frame) EXPECT_EQ(json::parse(line)["frame"], frame);
  EXPECT_EQ(frame, 10);
  const json sidecar = read("d/f.5.exr.json");
  EXPECT_EQ(sidecar["shard"], 1);
  EXPECT_EQ(sidecar["options"]["frame"], 5);
  EXPECT_EQ(sidecar["options"]["size"], "48x27");
  EXPECT_EQ(sidecar["config"]["time"], 1.25);
  EXPECT_EQ(sidecar["program"], now["programs"].begin().key());
  expect_bits_of_one_machine();
  // Existing frames are not drawn again.
  const auto written = fs::last_write_time(path("d/f.4.exr"));
  task(1, 3, with_stats);
  EXPECT_EQ(fs::last_write_time(path("d/f.4.exr")), written);
}

TEST_F(Cluster, ATaskOfAnotherRunIsRefusedByName) {
  const std::string render = "render empty --size 16x9 --shadows off -o d/#.png --shard auto ";
  task(0, 2, render + "--frames 0-3");
  const auto refused = [&](const std::string& arguments, int count, const std::string& says) {
    expect_refused(arguments, usage, "d holds another run: " + says, slurm(1, count));
  };
  refused(render + "--frames 0-3", 3, "shards is 2 there and 3 here");
  refused(render + "--frames 0-4", 2, "jobs 0 frames is \"0-3\" there and \"0-4\" here");
  refused(render + "--frames 0-3 --seed 2", 2, "jobs 0 seed is absent there and \"2\" here");
  refused("chart empty --size 16x9 -o d --shard auto", 2, "command is \"render\" there and \"chart\" here");
  refused("stress ray-layers --quick -o d --shard auto", 2, "command is \"render\" there and \"stress\" here");
  EXPECT_EQ(run(render + "--frames 0-3 --threads 1", slurm(1, 2)).exit_code, 0)
      << "how many threads there are is no matter";
  // The scene's file changes during the run.
  ASSERT_EQ(run("make panes -o s.glb").exit_code, 0);
  const std::string of_file = "render s.glb --size 16x9 --shadows off --frames 0-3 -o e/#.png --shard auto";
  task(0, 2, of_file);
  ASSERT_EQ(run("make panes --set count=2 -o s.glb").exit_code, 0);
  expect_refused(of_file, usage, "e holds another run: jobs 0 scene-hash is ", slurm(1, 2));
  std::ofstream(path("d/shards/run.json")) << "{";
  expect_refused(render + "--frames 0-3", 1, "is not the record of a run", slurm(1, 2));
  expect_refused("status d", 1, "is not the record of a run");
  expect_refused("status nosuch", 1, "nosuch: holds no run");
  expect_refused("gather nosuch", 1, "nosuch: holds no run");
}

// Tasks that start at once all use the record of one of them.
TEST_F(Cluster, FirstTasksMayRace) {
  const std::string render = "render empty --size 16x9 --shadows off --frames 0-7 -o d/#.png --shard auto";
  for (int round = 0; round < 2; ++round) {
    fs::remove_all(path("d"));
    std::vector<std::string> environments;
    for (const int count : {2, 3})
      for (int id = 0; id < count; ++id) environments.push_back(slurm(id, count));
    const std::vector<int> codes = run_at_once(environments, render);
    const int shards = read("d/shards/run.json")["shards"];
    for (size_t i = 0; i < codes.size(); ++i) {
      const bool is_of_run = (i < 2) == (shards == 2);
      EXPECT_EQ(codes[i], is_of_run ? 0 : usage) << i << " with " << shards << " shards";
    }
    EXPECT_EQ(status()["missing"], json::array());
    for (const std::string& name : files_of("d")) EXPECT_EQ(name.find(".tmp"), std::string::npos) << name;
  }
}

TEST_F(Cluster, AKilledTaskLosesAndLeavesNothing) {
  task(1, 2);
  const pid_t child = fork();
  if (child == 0) {
    for (const auto& [name, value] : {std::pair{"MIN", "0"}, {"STEP", "1"}, {"COUNT", "2"}, {"ID", "0"}})
      setenv((std::string("SLURM_ARRAY_TASK_") + name).c_str(), value, 1);
    if (chdir(folder_.c_str()) != 0) _exit(99);
    const std::string command = "exec '" SIDERAY_BINARY_DIR "/sideray' " + sequence + " >/dev/null 2>&1";
    execl("/bin/sh", "sh", "-c", command.c_str(), nullptr);
    _exit(99);
  }
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (!fs::exists(path("d/f.2.exr")) && std::chrono::steady_clock::now() < end)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  kill(child, SIGKILL);
  int how = 0;
  waitpid(child, &how, 0);
  ASSERT_TRUE(WIFSIGNALED(how)) << "it had ended before";
  // A task that is killed while it writes leaves a temporary file.
  std::ofstream(path("d/f.4.exr.tmp-a1B2c3")) << "half";
  std::ofstream(path("d/shards/0000.json.tmp-a1B2c3")) << "half";
  std::ofstream(path("d/notes.tmp-a1B2c3")) << "not ours";
  const json now = status();
  EXPECT_FALSE(now["missing"].empty());
  EXPECT_EQ(now["tasks"][0]["state"], "lost");
  EXPECT_EQ(now["retry"], "sbatch --array=0");
  task(0, 2);
  gather(0);
  expect_bits_of_one_machine();
  for (const std::string& name : files_of("d"))
    EXPECT_EQ(name.find(".tmp") != std::string::npos, name == "notes.tmp-a1B2c3") << name;
}

// A task counts as running while it updates its record, on any machine.
TEST_F(Cluster, StatusTellsRunningFromLostAndFailed) {
  task(0, 3);
  edit("d/shards/0000.json", {{"state", "running"}, {"space", "elsewhere"}});
  fs::copy_file(path("d/shards/0000.json"), path("d/shards/0001.json"));
  std::ofstream(path("d/shards/0002.json")) << json{{"state", "failed"}, {"node", "n7"}, {"error", "disk full"}};
  json now = status();
  EXPECT_EQ(now["missing"], json({4, 5, 6, 7, 8, 9}));
  EXPECT_EQ(now["running"], json({4, 5, 6}));
  EXPECT_EQ(now["failed"], json({7, 8, 9}));
  EXPECT_EQ(now["retry_shards"], json({2}));
  const Outcome text = run("status d");
  EXPECT_NE(text.output.find("done 2, running 3, missing 0, failed 3\n"), std::string::npos) << text.output;
  EXPECT_NE(text.output.find("shard 2: failed on n7: disk full\n"), std::string::npos) << text.output;
  EXPECT_NE(text.output.find("missing: 4-9\n"), std::string::npos) << text.output;
  fs::last_write_time(path("d/shards/0001.json"), fs::file_time_type::clock::now() - std::chrono::minutes(5));
  now = status();
  EXPECT_EQ(now["running"], json::array());
  EXPECT_EQ(now["retry"], "sbatch --array=1-2");
}

TEST_F(Cluster, WhatIsDamagedOrMixedIsNamedAndDrawnAgain) {
  for (const int id : {0, 1}) task(id, 2);
  const std::string whole = text_of(path("d/f.5.exr"));
  fs::resize_file(path("d/f.5.exr"), whole.size() / 2);
  EXPECT_EQ(status()["missing"], json({5}));
  task(0, 2);
  EXPECT_EQ(text_of(path("d/f.5.exr")), whole);
  // The size is equal: only reading the whole file finds the difference.
  std::string other = whole;
  other.back() ^= 1;
  std::ofstream(path("d/f.5.exr"), std::ios::binary) << other;
  EXPECT_EQ(status()["missing"], json::array());
  EXPECT_NE(gather(1).errors.find("1 of 8 are missing or not whole: 5; run with --shard auto/2: sbatch --array=0"),
            std::string::npos);
  task(0, 2);
  for (const int frame : {8, 9}) edit("d/f." + std::to_string(frame) + ".exr.json", {{"program", "0.1.9-old"}});
  const json now = status();
  EXPECT_TRUE(now["mixed"].get<bool>());
  EXPECT_EQ(now["programs"]["0.1.9-old"], 2);
  EXPECT_EQ(now["retry"], "sbatch --array=1");
  EXPECT_NE(run("status d").output.find("program 0.1.9-old: 8-9\n"), std::string::npos);
  EXPECT_NE(gather(1).errors.find("made by different programs: 8-9 by 0.1.9-old, 2-7 by "), std::string::npos);
  task(1, 2);
  gather(0);
}

// Single pictures are dealt to tasks in turn; the frames of sequences are split.
TEST_F(Cluster, JobsAreShared) {
  std::ofstream(path("jobs.json"))
      << R"([{"o": "d/a.png"}, {"o": "d/e/f.#.png", "frames": "0-3", "stats": "d/e/s.jsonl"},
    {"o": "d/b.png", "stats": "d/b.json"}, {"o": "d/c.png"}])";
  const std::string jobs = "render empty --size 16x9 --shadows off --jobs jobs.json --shard auto";
  fs::create_directories(path("d/e"));
  task(0, 2, jobs);
  EXPECT_TRUE(fs::exists(path("d/a.png")) && fs::exists(path("d/b.json")) && fs::exists(path("d/e/f.1.png")));
  EXPECT_EQ(status()["missing"], json({"d/e/f.2.png", "d/e/f.3.png", "d/c.png"}));
  task(1, 2, jobs);
  EXPECT_FALSE(fs::exists(path("d/e/s.jsonl")));
  gather(0);
  EXPECT_TRUE(fs::exists(path("d/e/s.jsonl")));
  // With an explicit shard nothing is recorded.
  fs::remove_all(path("d"));
  fs::create_directories(path("d/e"));
  ASSERT_EQ(run("render empty --size 16x9 --shadows off --jobs jobs.json --shard 1/2").exit_code, 0);
  EXPECT_EQ(files_of("d"), (std::vector<std::string>{"c.png", "e", "e/f.2.png", "e/f.3.png", "e/s.jsonl"}));
  std::ofstream(path("jobs.json")) << R"([{"o": "d/a.#.png", "frames": "0-3", "shard": "auto"}])";
  expect_refused("render empty --jobs jobs.json", usage, "jobs.json job 0: shard auto", slurm(0, 2));
}

TEST_F(Cluster, AChartIsGatheredFromItsRows) {
  std::ofstream(path("s.json")) << R"([{"translucency": "off"}, {"layers": 1}, {"layers": 2}])";
  const std::string chart = "chart panes --sweep s.json --repeat 1 --size 32x18 --light-samples 2 -o d --shard auto";
  task(1, 2, chart);
  EXPECT_EQ(status()["missing"], json({0, 2}));
  expect_refused(chart + " --ray-reuse 0", usage, "options ray-reuse is absent there", slurm(0, 2));
  task(0, 2, chart);
  EXPECT_TRUE(fs::exists(path("d/index.html"))) << "the task that finds all rows writes the page";
  for (const char* name : {"index.html", "results.json", "results.csv"}) fs::remove(path(std::string("d/") + name));
  EXPECT_EQ(status()["missing"], json::array());
  // Gathering needs neither the list nor the original folder.
  fs::remove(path("s.json"));
  fs::rename(path("d"), path("moved"));
  gather(0, "moved");
  EXPECT_EQ(read("moved/results.json")["rows"].size(), 3u);
  EXPECT_TRUE(fs::exists(path("moved/index.html")));
  const std::string row = "moved/rows/0002.json";
  edit(row, {{"made_with", {{"made_from", {{"program", "0.1.9-old"}}}}}});
  EXPECT_NE(gather(1, "moved").errors.find("2 by 0.1.9-old"), std::string::npos);
  fs::remove(path("moved/images/0001.exr"));
  EXPECT_EQ(status("moved")["missing"], json({1}));
}

TEST_F(Cluster, StressCasesAreGathered) {
  const std::string stress = "stress layer-count ray-layers world-offset --quick ";
  task(1, 2, stress + "-o d --shard auto");
  EXPECT_EQ(status()["missing"], json({"layer-count", "ray-layers"}));
  task(0, 2, stress + "-o d --shard auto");
  fs::remove(path("d/results.json"));
  gather(0);
  ASSERT_EQ(run(stress + "-o whole").exit_code, 0);
  for (const char* name : {"/results.json", "/index.html", "/maps/layer-count.png"})
    EXPECT_EQ(text_of(path(std::string("d") + name)), text_of(path(std::string("whole") + name))) << name;
  for (const char* shard : {"0/2", "1/2"}) ASSERT_EQ(run(stress + "-o e --shard " + shard).exit_code, 0);
  EXPECT_EQ(text_of(path("e/results.json")), text_of(path("whole/results.json")));
}

}  // namespace
}  // namespace sideray::cli_tests::cluster_test
