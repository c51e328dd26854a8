#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>

#include "cli/base/failure.h"
#include "cli/base/outputs.h"
#include "cli/golden/golden.h"
#include "cli/golden/golden_folder.h"
#include "scenes/base/files.h"

namespace sideray::cli {
namespace {

LastCheck checked(const GoldenFolder& folder, const Manifest& manifest) {
  std::error_code ignored;
  if (!std::filesystem::exists(folder.last_check(), ignored))
    scenes::refuse("{}: has no check to approve; run sideray golden check {} first", folder.folder, folder.folder);
  LastCheck check = read_last_check(folder.last_check());
  if (check.manifest != digest_of(text_of(manifest)))
    scenes::refuse("{}: was checked against other references; run sideray golden check {} again", folder.folder,
                   folder.folder);
  return check;
}

// Removes the pictures of these names from the check and returns them.
std::vector<CheckedPicture> chosen(LastCheck& check, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    const auto is_named = [&](const CheckedPicture& picture) { return picture.drawn.name == name; };
    if (std::any_of(check.pictures.begin(), check.pictures.end(), is_named)) continue;
    std::vector<std::string> differing;
    for (const CheckedPicture& picture : check.pictures) differing.push_back(picture.drawn.name);
    wrong_usage("approve {}: no picture of that name differed in the last check; {}", name,
                differing.empty() ? "none did" : fmt::format("those that did: {}", fmt::join(differing, ", ")));
  }
  const auto stays = [&](const CheckedPicture& picture) {
    return !names.empty() && std::find(names.begin(), names.end(), picture.drawn.name) == names.end();
  };
  const auto first = std::stable_partition(check.pictures.begin(), check.pictures.end(), stays);
  std::vector<CheckedPicture> result(first, check.pictures.end());
  check.pictures.erase(first, check.pictures.end());
  return result;
}

GoldenPicture& entry_of(Manifest& manifest, const std::string& name, const GoldenFolder& folder) {
  for (GoldenPicture& picture : manifest.pictures)
    if (picture.name == name) return picture;
  scenes::refuse("{}: names {}, which the references have not; check again", folder.last_check(), name);
}

// Another driver draws the same scene with other bits: it gets a bound, and the reference stays.
std::string approve_drift(GoldenPicture& entry, const CheckedPicture& picture) {
  const std::string& driver = picture.drawn.driver;
  if (!picture.is_colour_alone)
    wrong_usage(
        "approve {}: objects differ, not the driver ({}) alone; check it on {}, or record all references on this driver",
        entry.name, driver, entry.driver);
  entry.drifts[driver] = picture.drift;
  return fmt::format("{}: {} may differ by FLIP {:.2g} and in {:.3g} % of the pixels\n", entry.name, driver,
                     picture.drift.flip, 100 * picture.drift.share);
}

std::string approve_picture(const GoldenFolder& folder, GoldenPicture& entry, const CheckedPicture& picture,
                            const StagedFolder& stage) {
  if (picture.drawn.driver != entry.driver) return approve_drift(entry, picture);
  (void)recorded_picture(folder.check(), picture.drawn);
  (void)recorded_ids(folder.check(), picture.drawn);
  for (const std::string& file : {picture.drawn.file, picture.drawn.ids}) stage.take(folder.check() + "/" + file, file);
  const std::map<std::string, Drift> drifts = entry.drifts;
  entry = picture.drawn;
  entry.drifts = drifts;  // drivers round a new picture about as they did the old one
  return fmt::format("{}: approved\n", entry.name);
}

}  // namespace

int golden_approve(const std::string& folder_name, const std::vector<std::string>& names) {
  const GoldenFolder folder{folder_name};
  Manifest manifest = recorded(folder);
  LastCheck check = checked(folder, manifest);
  const std::vector<CheckedPicture> approved = chosen(check, names);
  if (approved.empty()) {
    fmt::print("{}: nothing differed in the last check\n", folder.folder);
    return exit_ok;
  }
  const StagedFolder stage(folder.references());
  std::string lines;
  for (const CheckedPicture& picture : approved)
    lines += approve_picture(folder, entry_of(manifest, picture.drawn.name, folder), picture, stage);
  const std::string text = text_of(manifest);
  write_text(stage.file("manifest.json"), text);
  stage.take_others({});
  // The rest of the check refers to the new manifest.
  check.manifest = digest_of(text);
  stage.publish();
  write_text(folder.last_check(), text_of(check));
  fmt::print("{}", lines);
  return exit_ok;
}

}  // namespace sideray::cli
