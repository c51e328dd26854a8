#include "scenes/gltf/file/uris.h"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <system_error>

#include "scenes/base/files.h"
#include "scenes/gltf/file/json.h"

namespace sideray::scenes::gltf {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

std::string percent_decoded(const std::string& uri) {
  std::string text;
  for (size_t i = 0; i < uri.size(); ++i) {
    unsigned int code = 0;
    if (uri[i] == '%' && i + 2 < uri.size() && std::sscanf(uri.c_str() + i + 1, "%2x", &code) == 1) {
      text += static_cast<char>(code);
      i += 2;
    } else {
      text += uri[i];
    }
  }
  return text;
}

void check_name(const std::string& uri, const fs::path& folder, const std::string& path, const std::string& user) {
  if (uri.starts_with("data:")) return;
  const std::string name = percent_decoded(uri);
  const fs::path relative = fs::path(name).lexically_normal();
  const bool has_zero = name.find('\0') != std::string::npos;
  if (name.empty() || has_zero || relative.is_absolute() || relative.begin() == relative.end() ||
      *relative.begin() == ".." || name.find("://") != std::string::npos) {
    refuse("cannot read {}: {} names \"{}\", which is not in the scene's folder; copy the file beside the scene", path,
           user, uri);
  }
  std::error_code error;
  const fs::file_status status = fs::status(folder / relative, error);
  if (!fs::exists(status)) {
    refuse("cannot read {}: {} needs the file {}, which does not exist; copy it there", path, user,
           (folder / relative).string());
  }
  if (!fs::is_regular_file(status)) {
    refuse("cannot read {}: {} names {}, which is not a regular file; correct the name", path, user,
           (folder / relative).string());
  }
  const fs::path real = fs::canonical(folder / relative, error), real_folder = fs::canonical(folder, error);
  if (error ||
      std::mismatch(real_folder.begin(), real_folder.end(), real.begin(), real.end()).first != real_folder.end()) {
    refuse("cannot read {}: {} names \"{}\", a link out of the scene's folder; copy the file there", path, user, uri);
  }
}

// Replaces backslashes between folders, which exporters on Windows write and glTF does not allow.
void mend_backslashes(Json& object, const fs::path& folder) {
  const auto uri = object.find("uri");
  if (uri == object.end() || !uri->is_string()) return;
  std::string name = uri->get<std::string>();
  std::error_code error;
  if (name.starts_with("data:") || name.find('\\') == std::string::npos ||
      fs::exists(folder / percent_decoded(name), error))
    return;
  std::replace(name.begin(), name.end(), '\\', '/');
  if (fs::exists(folder / percent_decoded(name), error)) *uri = name;
}

// Replaces the media type of a buffer's data URI: it is read as bytes, whatever its type.
void mend_media_type(Json& buffer) {
  const auto uri = buffer.find("uri");
  if (uri == buffer.end() || !uri->is_string()) return;
  const std::string text = uri->get<std::string>();
  if (!text.starts_with("data:") || tinygltf::IsDataURI(text)) return;
  const size_t data = text.substr(0, 256).find(";base64,");
  if (data != std::string::npos) *uri = "data:application/octet-stream" + text.substr(data);
}

}  // namespace

bool mend_uris(Json& root, const fs::path& folder, File& file) {
  bool changed = false;
  for (const auto& [key, name] : {std::pair{"buffers", "buffer"}, {"images", "image"}}) {
    const size_t count = objects(root, key, file.path).size();
    for (size_t i = 0; i < count; ++i) {
      Json& object = root[key][i];
      const Json before = object.value("uri", Json());
      mend_backslashes(object, folder);
      if (key == std::string("buffers")) mend_media_type(object);
      if (!object.contains("uri") || object["uri"] == before) continue;
      changed = true;
      const bool is_data = object["uri"].get<std::string>().starts_with("data:");
      file.warnings.push_back(fmt::format("{} {}: {}", name, i,
                                          is_data ? "its data URI has a media type that glTF lacks; its octets are read"
                                                  : "its uri has backslashes; they are read as slashes"));
    }
  }
  return changed;
}

void check_uri(const Json& object, const fs::path& folder, const std::string& path, const std::string& user) {
  const auto uri = object.find("uri");
  if (uri == object.end()) return;
  if (!uri->is_string()) refuse("cannot read {}: the uri of {} is not a string; export it again", path, user);
  check_name(uri->get<std::string>(), folder, path, user);
}

}  // namespace sideray::scenes::gltf
