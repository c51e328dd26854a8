#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "cli/base/failure.h"
#include "cli/base/outputs.h"
#include "cli/base/program.h"
#include "cli/golden/golden.h"
#include "cli/golden/golden_folder.h"
#include "cli/golden/golden_jobs.h"
#include "cli/golden/golden_verdict.h"
#include "cli/golden/junit.h"
#include "cli/options/configuration_files.h"
#include "scenes/base/files.h"

namespace sideray::cli {
namespace {

namespace fs = std::filesystem;

struct CheckOptions {
  GoldenFolder folder;
  std::string junit, page;
  uint32_t threads = 0;
};

CheckOptions resolve_check(const std::string& folder, const Given& given) {
  check_given(golden_check_table(), given);
  CheckOptions options{{folder}, "", "", 0};
  options.junit = text_of(golden_check_table(), given, "junit");
  options.page = text_of(golden_check_table(), given, "page");
  if (options.page.empty()) options.page = folder + "/check.html";
  if (!options.junit.empty()) require_extension("--junit", options.junit, {".xml"});
  require_extension("--page", options.page, {".html"});
  if (given.contains("threads")) options.threads = whole_number_of(golden_check_table(), given, "threads");
  return options;
}

// Refuses a folder of this name that holds no check, since it is the user's own.
void require_own_check(const GoldenFolder& folder) {
  std::error_code ignored;
  if (fs::exists(folder.check(), ignored) && !fs::exists(folder.last_check(), ignored))
    scenes::refuse("{}: is not of a check, whose pictures go there; move it away", folder.check());
}

// Returns the recorded jobs. Throws Error where the file has changed: jobs added since would not be checked.
std::vector<GoldenJob> recorded_jobs(const GoldenFolder& folder, const Manifest& manifest) {
  const std::string path = (fs::path(folder.folder) / manifest.jobs_file).lexically_normal().string();
  if (read_configurations(path, "job") != manifest.jobs)
    scenes::refuse("{}: is not what was recorded; sideray golden record {} draws its jobs anew", path, folder.folder);
  return golden_jobs(manifest.jobs, path, manifest.options);
}

// Throws Error unless every picture of the jobs has an entry, in the same order; a manifest merged by hand may not.
void require_entries(const GoldenFolder& folder, const Manifest& manifest, const std::vector<GoldenJob>& jobs) {
  size_t at = 0;
  bool is_whole = true;
  for (const GoldenJob& job : jobs)
    for (const GoldenPicture& picture : pictures_of(job)) {
      is_whole = is_whole && at < manifest.pictures.size() && manifest.pictures[at].file == picture.file &&
                 manifest.pictures[at].ids == picture.ids;
      ++at;
    }
  if (!is_whole || at != manifest.pictures.size())
    scenes::refuse("{}: its pictures are not those of its jobs; restore it, or record again", folder.manifest());
}

// Throws Error where a reference is missing or damaged, before any drawing, which may take long.
void require_references(const GoldenFolder& folder, const Manifest& manifest) {
  for (const GoldenPicture& picture : manifest.pictures) {
    (void)recorded_picture(folder.references(), picture);
    (void)recorded_ids(folder.references(), picture);
  }
}

std::string summary_of(const CheckOptions& options, const Manifest& manifest, const std::vector<Verdict>& verdicts) {
  const auto differing = std::count_if(verdicts.begin(), verdicts.end(), [](const Verdict& v) { return !v.holds; });
  if (differing == 0) return fmt::format("{} of {} pictures are as recorded", verdicts.size(), verdicts.size());
  std::string text =
      fmt::format("{} of {} pictures differ; look at {}, and sideray golden approve {} makes them the references",
                  differing, verdicts.size(), options.page, options.folder.folder);
  if (manifest.version != program_version())
    text += fmt::format("; recorded by sideray {}, this is {}", manifest.version, program_version());
  return text;
}

LastCheck last_check(const Manifest& manifest, const std::vector<Verdict>& verdicts) {
  LastCheck check{digest_of(text_of(manifest)), {}};
  for (const Verdict& v : verdicts)
    if (!v.holds)
      check.pictures.push_back({v.drawn, v.drift(), v.differences.has_same_ids && v.differences.flip.has_value() &&
                                                        v.drawn.camera == v.reference.camera});
  return check;
}

std::vector<JunitCase> junit_cases(const std::vector<Verdict>& verdicts) {
  std::vector<JunitCase> cases;
  for (const Verdict& v : verdicts) cases.push_back({v.drawn.name, v.holds ? "" : v.text, v.seconds});
  return cases;
}

void print_verdict(const Verdict& verdict) {
  fmt::print("{}: {}\n", verdict.drawn.name, verdict.text);
  std::fflush(stdout);
}

std::vector<Verdict> draw_and_compare(const CheckOptions& options, const Manifest& manifest,
                                      const std::vector<GoldenJob>& jobs, const StagedFolder& stage) {
  std::vector<Verdict> verdicts;
  const std::string references = options.folder.references();
  draw_golden(
      jobs, options.threads, [&](const std::string& name) { return stage.file(name); },
      [&](DrawnPicture&& drawn) {
        const GoldenPicture& recorded = manifest.pictures[verdicts.size()];
        verdicts.push_back(verdict_on(std::move(drawn), recorded, recorded_picture(references, recorded),
                                      recorded_ids(references, recorded)));
        print_verdict(verdicts.back());
        if (!verdicts.back().holds) return;
        for (const std::string& file : {recorded.file, recorded.ids}) unlink(stage.file(file).c_str());
      });
  return verdicts;
}

}  // namespace

int golden_check(const std::string& folder, const Given& given) {
  const CheckOptions options = resolve_check(folder, given);
  const Manifest manifest = recorded(options.folder);
  const std::vector<GoldenJob> jobs = recorded_jobs(options.folder, manifest);
  require_entries(options.folder, manifest, jobs);
  require_own_check(options.folder);
  require_distinct({{"--page", options.page}, {"--junit", options.junit}}, {});
  for (const std::string& file : {options.page, options.junit})
    if (!file.empty()) require_writable(file);
  require_references(options.folder, manifest);
  const StagedFolder stage(options.folder.check());
  const std::vector<Verdict> verdicts = draw_and_compare(options, manifest, jobs, stage);
  const std::string summary = summary_of(options, manifest, verdicts);
  write_text(stage.file("check.json"), text_of(last_check(manifest, verdicts)));
  write_text(options.page, golden_page_text(folder, summary, verdicts, stage.path(), options.folder.references()));
  if (!options.junit.empty()) write_text(options.junit, junit_text("sideray golden", junit_cases(verdicts)));
  stage.publish();
  fmt::print("{}\n", summary);
  return std::all_of(verdicts.begin(), verdicts.end(), [](const Verdict& v) { return v.holds; }) ? exit_ok
                                                                                              : exit_differs;
}

}  // namespace sideray::cli
