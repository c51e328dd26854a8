#include "scenes/gltf/file/checks.h"

#include <nlohmann/json.hpp>

#include "scenes/base/files.h"
#include "scenes/gltf/file/extensions.h"
#include "scenes/gltf/file/json.h"
#include "scenes/gltf/file/uris.h"

namespace sideray::scenes::gltf {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

// Refuses other data URIs, which tinygltf would open as files.
void check_data_of(const Json& buffer, size_t index, bool is_glb, const std::string& path) {
  const std::string uri = buffer.value("uri", "");
  if (!buffer.contains("uri") && (index > 0 || !is_glb))
    refuse("cannot read {}: buffer {} has no data, neither a uri nor a binary chunk; export it again", path, index);
  if (uri.starts_with("data:") && !tinygltf::IsDataURI(uri))
    refuse("cannot read {}: the data URI of buffer {} is not octets in base64; export it again", path, index);
}

void check_buffers(const Json& root, const fs::path& folder, const std::string& path, bool is_glb) {
  const Json& buffers = objects(root, "buffers", path);
  for (size_t i = 0; i < buffers.size(); ++i) {
    whole(buffers[i], "byteLength", 0, fmt::format("{}, buffer {}", path, i));
    check_uri(buffers[i], folder, path, fmt::format("buffer {}", i));
    check_data_of(buffers[i], i, is_glb, path);
  }
  const Json& views = objects(root, "bufferViews", path);
  for (size_t i = 0; i < views.size(); ++i) {
    const std::string what = fmt::format("{}, bufferView {}", path, i);
    const uint64_t buffer = whole(views[i], "buffer", buffers.size(), what);
    const uint64_t offset = whole(views[i], "byteOffset", 0, what), length = whole(views[i], "byteLength", 0, what);
    whole(views[i], "byteStride", 0, what);
    if (buffer >= buffers.size()) {
      refuse("cannot read {}: there is no such buffer among the {}; export it again", what, buffers.size());
    }
    const uint64_t available = whole(buffers[buffer], "byteLength", 0, what);
    if (offset + length > available) {
      refuse("cannot read {}: bytes {} to {} are outside buffer {} of {} bytes; export it again", what, offset,
             offset + length, buffer, available);
    }
  }
}

void check_image(const Json& image, size_t index, size_t views, const fs::path& folder, const std::string& path) {
  const std::string what = fmt::format("{}, image {}", path, index);
  if (image.contains("bufferView") && whole(image, "bufferView", views, what) >= views) {
    refuse("cannot read {}: there is no such bufferView among the {}; export it again", what, views);
  }
  if (!image.contains("bufferView") && !image.contains("uri")) {
    refuse("cannot read {}: it has neither uri nor bufferView; export it again", what);
  }
  check_uri(image, folder, path, fmt::format("image {}", index));
}

}  // namespace

void check_asset(const Json& root, const std::string& path) {
  if (!root.is_object()) refuse("cannot read {}: it is not a glTF scene; check the file", path);
  const auto asset = root.find("asset");
  if (asset == root.end() || !asset->is_object()) {
    refuse("cannot read {}: it lacks \"asset\", so it is not a glTF scene; check the file", path);
  }
  const auto version = asset->find("version");
  const std::string text = version != asset->end() && version->is_string() ? version->get<std::string>() : "";
  if (text != "2" && !text.starts_with("2."))
    refuse("cannot read {}: glTF \"{}\" is not read; convert it to glTF 2.0", path, text);
}

void check_structure(const Json& root, const fs::path& folder, bool is_glb, File& file) {
  check_extensions(root, file.path, file.warnings);
  check_buffers(root, folder, file.path, is_glb);
  for (const char* key : {"accessors", "meshes", "nodes", "materials", "textures", "samplers", "cameras", "scenes",
                          "animations", "skins"}) {
    objects(root, key, file.path);
  }
}

bool hide_broken_images(Json& root, const fs::path& folder, File& file) {
  const size_t views = objects(root, "bufferViews", file.path).size();
  const size_t count = objects(root, "images", file.path).size();
  for (size_t i = 0; i < count; ++i) {
    Json& image = root["images"][i];
    try {
      check_image(image, i, views, folder, file.path);
    } catch (const Error& error) {
      file.broken_images.emplace(i, error.what());
      image = {{"uri", "data:image/png;base64,AA=="}};
    }
  }
  return !file.broken_images.empty();
}

void check_loaded_buffers(const File& file) {
  for (size_t i = 0; i < file.model.bufferViews.size(); ++i) {
    const tinygltf::BufferView& view = file.model.bufferViews[i];
    const auto buffer = static_cast<size_t>(view.buffer);
    if (view.buffer < 0 || buffer >= file.model.buffers.size() ||
        view.byteOffset + view.byteLength > file.model.buffers[buffer].data.size()) {
      refuse("cannot read {}: bufferView {} is outside its buffer's data; get the file again", file.path, i);
    }
  }
}

}  // namespace sideray::scenes::gltf
