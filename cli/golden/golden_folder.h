// The folder of golden pictures: what is where in it, and new content that takes its place whole. Main thread.
#pragma once

#include <set>
#include <string>

#include "cli/golden/manifest.h"

namespace sideray::cli {

// DIR/references holds the pictures and manifest.json, DIR/check those of the last check that differed, and check.json.
struct GoldenFolder {
  std::string folder;

  std::string references() const { return folder + "/references"; }
  std::string manifest() const { return references() + "/manifest.json"; }
  std::string check() const { return folder + "/check"; }
  std::string last_check() const { return check() + "/check.json"; }
};

// Throws Error where the folder holds no references.
Manifest recorded(const GoldenFolder& folder);

// The picture, or the ids, of an entry in the folder `where`. Throws Error where the file is missing or is not what was
// recorded.
scenes::Image recorded_picture(const std::string& where, const GoldenPicture& entry);
scenes::Image recorded_ids(const std::string& where, const GoldenPicture& entry);

// The files of the folder of references that are the program's.
std::set<std::string> files_of(const Manifest& manifest);

// A folder beside `target` with a name that no other process has. It is removed, or takes the target's place as a
// whole; then the old one is removed.
class StagedFolder {
 public:
  explicit StagedFolder(const std::string& target);  // throws Error
  ~StagedFolder();
  StagedFolder(const StagedFolder&) = delete;
  StagedFolder& operator=(const StagedFolder&) = delete;

  const std::string& path() const { return path_; }
  // Where a file of that name goes; makes the folders above it. Throws Error.
  std::string file(const std::string& name) const;
  // Takes over a file from elsewhere. Throws Error.
  void take(const std::string& from, const std::string& name) const;
  // Takes over what the target has and `own` does not name: files of the user. Throws Error.
  void take_others(const std::set<std::string>& own) const;
  // Throws Error, and the target is then the old one.
  void publish() const;

 private:
  std::string target_, path_;
};

}  // namespace sideray::cli
