// Manages the folder of golden pictures: what is where, and replacing its content as a whole. Main thread.
#pragma once

#include <optional>
#include <set>
#include <string>

#include "cli/golden/manifest.h"

namespace sideray::cli {

// DIR/references holds the pictures and manifest.json; DIR/check those of the last check that differed, and check.json.
struct GoldenFolder {
  std::string folder;

  std::string references() const { return folder + "/references"; }
  std::string manifest() const { return references() + "/manifest.json"; }
  std::string check() const { return folder + "/check"; }
  std::string last_check() const { return check() + "/check.json"; }
};

// Throws Error where the folder holds no references.
Manifest recorded(const GoldenFolder& folder);

// Return an entry's picture or ids in the folder `where`. Throw Error where the file is missing or differs from what
// was recorded.
scenes::Image recorded_picture(const std::string& where, const GoldenPicture& entry);
scenes::Image recorded_ids(const std::string& where, const GoldenPicture& entry);

// Returns the program's own files in the folder of references.
std::set<std::string> files_of(const Manifest& manifest);

// Locks a folder, which the system unlocks where the program is killed. File systems without such locks hold none.
class FolderLock {
 public:
  explicit FolderLock(const std::string& path);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;
  bool is_held() const { return is_held_; }

 private:
  int descriptor_;
  bool is_held_;
};

// Creates a folder beside `target` with a name that no other process has. It is removed at the end, or replaces the
// target as a whole; the old target is then removed. The next one for the target removes those of killed programs.
class StagedFolder {
 public:
  explicit StagedFolder(const std::string& target);  // throws Error
  ~StagedFolder();
  StagedFolder(const StagedFolder&) = delete;
  StagedFolder& operator=(const StagedFolder&) = delete;

  const std::string& path() const { return path_; }
  // Returns the path for a file of that name, and creates the folders above it. Throws Error.
  std::string file(const std::string& name) const;
  // Copies or links a file from elsewhere. Throws Error.
  void take(const std::string& from, const std::string& name) const;
  // Takes the target's files that `own` does not name, which are the user's. Throws Error.
  void take_others(const std::set<std::string>& own) const;
  // Replaces the target. Throws Error, in which case the target stays the old one.
  void publish() const;

 private:
  std::string target_, path_;
  std::optional<FolderLock> lock_;
};

}  // namespace sideray::cli
