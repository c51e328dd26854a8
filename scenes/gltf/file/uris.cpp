#include "scenes/gltf/file/uris.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <system_error>

#include "scenes/base/files.h"
#include "scenes/gltf/file/json.h"

namespace sideray::scenes::gltf {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

// Returns -1 for what is no hexadecimal digit.
int digit_of(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

std::string percent_decoded(const std::string& uri) {
  std::string text;
  for (size_t i = 0; i < uri.size(); ++i) {
    const bool is_escape = uri[i] == '%' && i + 2 < uri.size() && digit_of(uri[i + 1]) >= 0 && digit_of(uri[i + 2]) >= 0;
    text += is_escape ? static_cast<char>(digit_of(uri[i + 1]) * 16 + digit_of(uri[i + 2])) : uri[i];
    if (is_escape) i += 2;
  }
  return text;
}

// Escapes what a parser may read in another way, and bytes that are not ASCII.
std::string percent_encoded(const std::string& name) {
  std::string uri;
  for (const char c : name) {
    const bool is_plain = c > 0x1f && c < 0x7f && c != '%' && c != '+' && c != ':';
    uri += is_plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return uri;
}

void check_name(const std::string& uri, const fs::path& folder, const std::string& path, const std::string& user) {
  if (uri.starts_with("data:")) return;
  const std::string name = percent_decoded(uri);
  const fs::path relative = fs::path(name), normal = relative.lexically_normal();
  const bool has_zero = name.find('\0') != std::string::npos;
  if (name.empty() || has_zero || normal.is_absolute() || normal.begin() == normal.end() ||
      *normal.begin() == ".." || name.find("://") != std::string::npos) {
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
  if (!is_below(folder, folder / relative)) {
    refuse("cannot read {}: {} names \"{}\", a link out of the scene's folder; copy the file there", path, user, uri);
  }
}

// Replaces the backslashes between folders that exporters on Windows write; glTF has none.
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

// Gives a buffer's data URI a media type that tinygltf accepts: its bytes mean the same under any type.
void mend_media_type(Json& buffer) {
  const auto uri = buffer.find("uri");
  if (uri == buffer.end() || !uri->is_string()) return;
  const std::string text = uri->get<std::string>();
  if (!text.starts_with("data:") || tinygltf::IsDataURI(text)) return;
  const size_t data = text.substr(0, 256).find(";base64,");
  if (data != std::string::npos) *uri = "data:application/octet-stream" + text.substr(data);
}

// Writes a file's name so that tinygltf, which reads + as a space and % before any characters as an escape, opens the
// file that was checked.
bool unify_escapes(Json& object) {
  const auto uri = object.find("uri");
  if (uri == object.end() || !uri->is_string()) return false;
  const std::string text = uri->get<std::string>();
  if (text.starts_with("data:") || text.find_first_of("%+") == std::string::npos) return false;
  *uri = percent_encoded(percent_decoded(text));
  return true;
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
      const bool is_mended = object.contains("uri") && object["uri"] != before;
      changed |= unify_escapes(object);
      if (!is_mended) continue;
      changed = true;
      const bool is_data = object["uri"].get<std::string>().starts_with("data:");
      file.warnings.push_back(fmt::format("{} {}: {}", name, i,
                                          is_data ? "its data URI has a media type that glTF lacks; its octets are read"
                                                  : "its uri has backslashes; they are read as slashes"));
    }
  }
  return changed;
}

bool is_below(const fs::path& folder, const fs::path& file) {
  std::error_code no_file, no_folder;
  const fs::path real = fs::canonical(file, no_file), real_folder = fs::canonical(folder, no_folder);
  return !no_file && !no_folder &&
         std::mismatch(real_folder.begin(), real_folder.end(), real.begin(), real.end()).first == real_folder.end();
}

void check_uri(const Json& object, const fs::path& folder, const std::string& path, const std::string& user) {
  const auto uri = object.find("uri");
  if (uri == object.end()) return;
  if (!uri->is_string()) refuse("cannot read {}: the uri of {} is not a string; export it again", path, user);
  check_name(uri->get<std::string>(), folder, path, user);
}

}  // namespace sideray::scenes::gltf
