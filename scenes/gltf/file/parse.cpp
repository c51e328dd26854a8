#include "scenes/gltf/file/parse.h"

#include <filesystem>
#include <new>
#include <optional>

#include "scenes/base/files.h"
#include "scenes/base/limits.h"
#include "scenes/gltf/file/container.h"
#include "scenes/gltf/file/json.h"
#include "scenes/gltf/file/uris.h"

namespace sideray::scenes::gltf {
namespace {

namespace fs = std::filesystem;

// Counts the bytes that tinygltf's callbacks hand out, because a few characters can name the same file or bytes many
// times.
struct Source {
  const std::string& folder;
  Budget& budget;
  uint64_t hash = empty_hash;  // of the files that were read
  std::optional<Error> error;  // kept here, because no exception may pass through tinygltf

  // Returns whether the budget allows `bytes` more, and keeps the Error if it does not.
  bool take(uint64_t bytes, const char* user) {
    try {
      budget.take(bytes, user);
      budget.check_time(user);
      return true;
    } catch (const Error& refused) {
      error = refused;
      return false;
    }
  }
};

bool keep_encoded(tinygltf::Image* image, int, std::string*, std::string*, int, int, const unsigned char* bytes,
                  int size, void* source) {
  if (!static_cast<Source*>(source)->take(static_cast<uint64_t>(size), "an encoded picture")) return false;
  image->image.assign(bytes, bytes + size);
  image->as_is = true;
  return true;
}

// Hides files outside the scene's folder: tinygltf also searches the working directory.
bool file_exists(const std::string& path, void* source) {
  std::error_code error;
  return fs::is_regular_file(path, error) && is_below(static_cast<Source*>(source)->folder, path);
}

std::string same_path(const std::string& path, void*) {
  return path;
}

bool read_whole(std::vector<unsigned char>* bytes, std::string* message, const std::string& path, void* from) {
  try {
    auto& source = *static_cast<Source*>(from);
    if (!source.take(file_size(path), path.c_str())) return false;
    *bytes = read_file(path, limits::scene_file_bytes);
    source.hash = hash_of(*bytes, source.hash);
    return true;
  } catch (const Error& error) {
    *message += error.what();
    return false;
  }
}

bool write_nothing(std::string*, const std::string&, const std::vector<unsigned char>&, void*) {
  return false;
}

[[maybe_unused]] bool size_of(size_t* size, std::string* message, const std::string& path, void*) {
  try {
    *size = file_size(path);
    return true;
  } catch (const Error& error) {
    *message += error.what();
    return false;
  }
}

// tinygltf asks for file sizes since 2.9, and then refuses a set of callbacks that lacks this one.
template <typename Callbacks>
Callbacks file_callbacks(Source& source) {
  Callbacks callbacks{};
  callbacks.FileExists = file_exists;
  callbacks.ExpandFilePath = same_path;
  callbacks.ReadWholeFile = read_whole;
  callbacks.WriteWholeFile = write_nothing;
  if constexpr (requires { callbacks.GetFileSizeInBytes; }) callbacks.GetFileSizeInBytes = size_of;
  callbacks.user_data = &source;
  return callbacks;
}

}  // namespace

void parse(std::span<const uint8_t> bytes, const std::string& folder, File& file) {
  tinygltf::TinyGLTF loader;
  Source source{.folder = folder, .budget = file.budget, .hash = file.hash, .error = {}};
  loader.SetImageLoader(keep_encoded, &source);
  loader.SetFsCallbacks(file_callbacks<tinygltf::FsCallbacks>(source));
  std::string message, warning;
  bool loaded = false;
  const auto size = static_cast<unsigned int>(bytes.size());
  try {
    loaded = is_binary(bytes) ? loader.LoadBinaryFromMemory(&file.model, &message, &warning, bytes.data(), size, folder)
                              : loader.LoadASCIIFromString(&file.model, &message, &warning,
                                                           reinterpret_cast<const char*>(bytes.data()), size, folder);
  } catch (const std::bad_alloc&) {
    message = "it does not fit into memory";
  } catch (const std::exception& error) {
    message = error.what();
  }
  file.hash = source.hash;
  if (source.error) throw *source.error;
  // tinygltf gives no message for values of a wrong type.
  if (message.empty()) message = "a value is missing or not of the type that glTF gives it";
  if (!loaded) refuse("cannot read {}: {}; export it again", file.path, one_line(message));
}

}  // namespace sideray::scenes::gltf
