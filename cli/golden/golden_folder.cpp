#include "cli/golden/golden_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "cli/base/outputs.h"
#include "scenes/base/files.h"

namespace sideray::cli {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t most_bytes = uint64_t{8} << 30;

[[noreturn]] void cannot_make(const std::string& path, int code) {
  scenes::refuse("{}: cannot be written: {}; free some space, or choose a folder that allows it", path,
                 std::strerror(code));
}

scenes::Image recorded_image(const std::string& where, const std::string& file, const GoldenPicture& entry,
                             const std::string& digest) {
  const std::string path = where + "/" + file;
  std::error_code ignored;
  if (!fs::exists(path, ignored)) scenes::refuse("{}: is missing; restore it, or record again", path);
  scenes::Image image = scenes::read_image(path);
  if (image.width != entry.width || image.height != entry.height)
    scenes::refuse("{}: is {}x{}, recorded were {}x{}; restore it, or record again", path, image.width, image.height,
                   entry.width, entry.height);
  if (digest_of(image) != digest)
    scenes::refuse("{}: is not the picture that was recorded; restore it, or record again", path);
  return image;
}

// Returns whether to fall back to two renames, where the system or disk cannot exchange two folders at once.
bool cannot_exchange(int code) {
  return code == EINVAL || code == ENOSYS || code == ENOTSUP || code == EXDEV;
}

// Removes the folders beside `target` that killed programs have left. Those of running ones are locked.
void remove_abandoned(const fs::path& target) {
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(target.parent_path(), ignored)) {
    if (!is_unfinished(entry.path().string()) || entry.path().stem() != target.filename()) continue;
    const FolderLock lock(entry.path().string());
    if (lock.is_held()) fs::remove_all(entry.path(), ignored);
  }
}

}  // namespace

FolderLock::FolderLock(const std::string& path)
    : descriptor_(::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC)),
      is_held_(descriptor_ >= 0 && ::flock(descriptor_, LOCK_EX | LOCK_NB) == 0) {}

FolderLock::~FolderLock() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Manifest recorded(const GoldenFolder& folder) {
  std::error_code ignored;
  if (!fs::is_directory(folder.folder, ignored))
    scenes::refuse("{}: is no folder; give the one that sideray golden record made", folder.folder);
  if (!fs::exists(folder.manifest(), ignored))
    scenes::refuse("{}: holds no references; sideray golden record {} makes them", folder.folder, folder.folder);
  return read_manifest(folder.manifest());
}

scenes::Image recorded_picture(const std::string& where, const GoldenPicture& entry) {
  return recorded_image(where, entry.file, entry, entry.digest);
}

scenes::Image recorded_ids(const std::string& where, const GoldenPicture& entry) {
  scenes::Image ids = recorded_image(where, entry.ids, entry, entry.ids_digest);
  const scenes::Plane* surfaces = ids.find("first.surface");
  if (!surfaces || surfaces->type != scenes::Plane::Type::uint)
    scenes::refuse("{}/{}: has no surface ids; restore it, or record again", where, entry.ids);
  return ids;
}

std::set<std::string> files_of(const Manifest& manifest) {
  std::set<std::string> files{"manifest.json"};
  for (const GoldenPicture& picture : manifest.pictures) files.insert({picture.file, picture.ids});
  return files;
}

StagedFolder::StagedFolder(const std::string& target) : target_(target), path_(target + ".tmp-XXXXXX") {
  std::error_code ignored;
  const fs::file_status status = fs::status(target, ignored);
  if (fs::exists(status) && !fs::is_directory(status))
    scenes::refuse("{}: is no folder; move it away", target);
  remove_abandoned(target);
  if (!mkdtemp(path_.data())) cannot_make(target, errno);
  lock_.emplace(path_);
  // mkdtemp makes private folders; this one gets the permissions of any new folder.
  const mode_t mask = ::umask(0);
  ::umask(mask);
  ::chmod(path_.c_str(), static_cast<mode_t>(0777) & ~mask);
}

StagedFolder::~StagedFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

std::string StagedFolder::file(const std::string& name) const {
  const fs::path path = fs::path(path_) / name;
  make_folder(path.parent_path().string());
  return path.string();
}

// Links, which takes no space and no time: files in the folders of references are replaced, never written to.
void StagedFolder::take(const std::string& from, const std::string& name) const {
  const std::string to = file(name);
  if (::link(from.c_str(), to.c_str()) == 0) return;
  scenes::write_file(to, scenes::read_file(from, most_bytes));
}

void StagedFolder::take_others(const std::set<std::string>& own) const {
  std::error_code error;
  if (!fs::exists(target_, error)) return;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(target_, error)) {
    const std::string name = entry.path().lexically_relative(target_).string();
    if (!entry.is_regular_file() || own.contains(name) || fs::exists(fs::path(path_) / name)) continue;
    take(entry.path().string(), name);
  }
  if (error) cannot_make(target_, error.value());
}

void StagedFolder::publish() const {
  if (::renameat2(AT_FDCWD, path_.c_str(), AT_FDCWD, target_.c_str(), RENAME_EXCHANGE) == 0) return;
  if (errno == ENOENT) {
    if (::rename(path_.c_str(), target_.c_str()) != 0) cannot_make(target_, errno);
    return;
  }
  if (!cannot_exchange(errno)) cannot_make(target_, errno);
  const std::string old = path_ + "-old";
  if (::rename(target_.c_str(), old.c_str()) != 0) cannot_make(target_, errno);
  if (::rename(path_.c_str(), target_.c_str()) != 0) {
    const int code = errno;
    if (::rename(old.c_str(), target_.c_str()) != 0)
      scenes::refuse("{}: cannot be written: {}; what it was is now {}: rename that back", target_,
                     std::strerror(code), old);
    cannot_make(target_, code);
  }
  (void)::rename(old.c_str(), path_.c_str());  // the destructor removes it there
}

}  // namespace sideray::cli
