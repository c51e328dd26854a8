#include <fmt/format.h>

#include <filesystem>
#include <optional>

#include "cli/base/failure.h"
#include "cli/base/outputs.h"
#include "cli/base/program.h"
#include "cli/golden/golden.h"
#include "cli/golden/golden_folder.h"
#include "cli/golden/golden_jobs.h"
#include "cli/options/configuration_files.h"
#include "cli/options/render_table.h"
#include "scenes/base/files.h"

namespace sideray::cli {
namespace {

namespace fs = std::filesystem;

// Returns the earlier manifest, if any. Throws Error for a folder with other content.
std::optional<Manifest> former(const GoldenFolder& folder) {
  std::error_code ignored;
  if (fs::exists(folder.manifest(), ignored)) return read_manifest(folder.manifest());
  if (fs::exists(folder.references(), ignored) && !fs::is_empty(folder.references(), ignored))
    scenes::refuse("{}: holds other files than references; move them, or record into another folder",
                   folder.references());
  return {};
}

const GoldenPicture* entry_named(const std::optional<Manifest>& manifest, const std::string& name) {
  if (!manifest) return nullptr;
  for (const GoldenPicture& picture : manifest->pictures)
    if (picture.name == name) return &picture;
  return nullptr;
}

// Compares with the earlier reference. If the picture is the same, the bounds approved for other drivers stay.
const char* compare_with(const GoldenPicture* before, GoldenPicture& picture) {
  if (!before) return "recorded";
  if (before->digest != picture.digest) return "recorded; differs from the reference before";
  picture.drifts = before->drifts;
  return "recorded, the same as before";
}

}  // namespace

int golden_record(const std::string& folder_name, const Given& given) {
  check_given(golden_record_table(), given);
  const GoldenFolder folder{folder_name};
  Manifest manifest{program_version(), "", given, {}, {}};
  manifest.options.emplace("gl", "none");
  const auto jobs_file = manifest.options.extract("jobs");
  const std::string path = jobs_file ? jobs_file.mapped() : folder.folder + "/jobs.json";
  uint32_t threads = 0;
  if (manifest.options.erase("threads") != 0) threads = whole_number_of(golden_record_table(), given, "threads");
  const std::optional<Manifest> before = former(folder);
  manifest.jobs = read_configurations(path, "job");
  const std::vector<GoldenJob> jobs = golden_jobs(manifest.jobs, path, manifest.options);
  make_folder(folder.folder);
  manifest.jobs_file = fs::proximate(path, folder.folder).string();
  const StagedFolder stage(folder.references());
  std::string lines;
  draw_golden(
      jobs, threads, [&](const std::string& name) { return stage.file(name); },
      [&](DrawnPicture&& drawn) {
        const char* said = compare_with(entry_named(before, drawn.golden.name), drawn.golden);
        lines += fmt::format("{}: {}\n", drawn.golden.name, said);
        manifest.pictures.push_back(std::move(drawn.golden));
      });
  write_text(stage.file("manifest.json"), text_of(manifest));
  if (before) stage.take_others(files_of(*before));
  stage.publish();
  fmt::print("{}", lines);
  return exit_ok;
}

}  // namespace sideray::cli
