#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "scenes/base/limits.h"
#include "scenes/gltf/gltf.h"
#include "scenes/gltf/gltf_json.h"

// tinygltf follows offsets and paths of the file without asking. What it would follow is checked here first, on our
// own parse of the JSON.
namespace sideray::scenes::gltf {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr uint32_t json_chunk = 0x4e4f534a;

uint32_t read_u32(std::span<const uint8_t> bytes, size_t offset) {
  uint32_t value;
  std::memcpy(&value, bytes.data() + offset, sizeof(value));
  return value;
}

bool is_binary(std::span<const uint8_t> bytes) {
  return bytes.size() >= 4 && std::memcmp(bytes.data(), "glTF", 4) == 0;
}

std::span<const uint8_t> json_text(std::span<const uint8_t> bytes, const std::string& path) {
  if (!is_binary(bytes)) return bytes;
  if (bytes.size() < 20) refuse("cannot read {}: the file ends inside its header; get it again", path);
  const uint32_t version = read_u32(bytes, 4), length = read_u32(bytes, 8), json_length = read_u32(bytes, 12);
  if (version != 2) refuse("cannot read {}: glTF {} is not read; convert it to glTF 2.0", path, version);
  if (length > bytes.size()) {
    refuse("cannot read {}: it should have {} bytes and has {}; get it again", path, length, bytes.size());
  }
  if (length < 20 || json_length > length - 20) {
    refuse("cannot read {}: its JSON of {} bytes ends outside its {} bytes; get it again", path, json_length, length);
  }
  if (read_u32(bytes, 16) != json_chunk) refuse("cannot read {}: its first chunk is not JSON; export it again", path);
  return bytes.subspan(20, json_length);
}

// Files without buffers may end in a binary chunk of no bytes, which tinygltf takes for damage.
void drop_empty_chunk(std::vector<uint8_t>& bytes) {
  if (!is_binary(bytes) || bytes.size() < 20) return;
  const size_t end = size_t{20} + read_u32(bytes, 12);
  if (bytes.size() < end + 8 || read_u32(bytes, 8) != end + 8 || read_u32(bytes, end) != 0) return;
  bytes.resize(end);
  const auto length = static_cast<uint32_t>(end);
  std::memcpy(&bytes[8], &length, 4);
}

// The list `key` of the root; empty where it is absent. Its entries must be objects.
const Json& objects(const Json& root, const char* key, const std::string& path) {
  static const Json none = Json::array();
  const auto found = root.find(key);
  if (found == root.end()) return none;
  const bool well_formed = found->is_array() && std::all_of(found->begin(), found->end(),
                                                            [](const Json& entry) { return entry.is_object(); });
  if (!well_formed) refuse("cannot read {}: {} is not a list of objects; export it again", path, key);
  return *found;
}

// A whole number 0..2^31-1, as tinygltf keeps most of them in an int.
uint64_t whole(const Json& object, const char* key, uint64_t fallback, const std::string& what) {
  const auto found = object.find(key);
  if (found == object.end()) return fallback;
  const double value = found->is_number() ? found->get<double>() : -1.0;
  if (!(value >= 0.0 && value <= 2147483647.0) || value != std::floor(value)) {
    refuse("cannot read {}: {} is not a whole number from 0 to 2^31-1; export it again", what, key);
  }
  return static_cast<uint64_t>(value);
}

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

// Files beside the scene only: a scene from elsewhere must not read what it likes.
void check_uri(const std::string& uri, const fs::path& folder, const std::string& path, const std::string& user) {
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

// Exporters on Windows part folders by backslashes, which glTF lacks.
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

// Octets are octets, whatever kind of file they are said to be.
void mend_media_type(Json& buffer) {
  const auto uri = buffer.find("uri");
  if (uri == buffer.end() || !uri->is_string()) return;
  const std::string text = uri->get<std::string>();
  if (!text.starts_with("data:") || tinygltf::IsDataURI(text)) return;
  const size_t data = text.substr(0, 256).find(";base64,");
  if (data != std::string::npos) *uri = "data:application/octet-stream" + text.substr(data);
}

// Rewrites what tinygltf would not find, with a warning.
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

void check_uri_of(const Json& object, const fs::path& folder, const std::string& path, const std::string& user) {
  const auto uri = object.find("uri");
  if (uri == object.end()) return;
  if (!uri->is_string()) refuse("cannot read {}: the uri of {} is not a string; export it again", path, user);
  check_uri(uri->get<std::string>(), folder, path, user);
}

// tinygltf takes other data URIs for names of files.
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
    check_uri_of(buffers[i], folder, path, fmt::format("buffer {}", i));
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
  check_uri_of(image, folder, path, fmt::format("image {}", index));
}

// Puts a byte in place of each image that must not or cannot be read: it is missed only where something shown uses it.
// Returns whether there was such an image.
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

// Every extension that is known; a note says what is shown where it is not played.
const char* const* note_of(const std::string& extension) {
  static const std::map<std::string, const char*> known{{"EXT_mesh_gpu_instancing", nullptr},
                                                        {"EXT_meshopt_compression", nullptr},
                                                        {"EXT_texture_webp", nullptr},
                                                        {"KHR_animation_pointer", nullptr},
                                                        {"KHR_draco_mesh_compression", nullptr},
                                                        {"KHR_lights_punctual", nullptr},
                                                        {"KHR_materials_anisotropy", nullptr},
                                                        {"KHR_materials_clearcoat", nullptr},
                                                        {"KHR_materials_diffuse_transmission", nullptr},
                                                        {"KHR_materials_dispersion", nullptr},
                                                        {"KHR_materials_emissive_strength", nullptr},
                                                        {"KHR_materials_ior", nullptr},
                                                        {"KHR_materials_iridescence", nullptr},
                                                        {"KHR_materials_pbrSpecularGlossiness", nullptr},
                                                        {"KHR_materials_sheen", nullptr},
                                                        {"KHR_materials_specular", nullptr},
                                                        {"KHR_materials_transmission", nullptr},
                                                        {"KHR_materials_unlit", nullptr},
                                                        {"KHR_materials_variants", nullptr},
                                                        {"KHR_materials_volume", nullptr},
                                                        {"KHR_materials_volume_scatter", nullptr},
                                                        {"KHR_mesh_quantization", nullptr},
                                                        {"KHR_node_visibility", nullptr},
                                                        {"KHR_texture_basisu", nullptr},
                                                        {"KHR_texture_transform", nullptr},
                                                        {"MSFT_lod", "the most detailed level is shown"}};
  const auto found = known.find(extension);
  return found == known.end() ? nullptr : &found->second;
}

const char* remedy_for(const std::string& extension) {
  static const std::set<std::string> compressed{"KHR_meshopt_compression", "EXT_texture_avif"};
  return compressed.contains(extension) ? "use a decoded copy, for example one that gltf-transform wrote without it"
                                        : "export the scene without it";
}

void check_extensions(const Json& root, const std::string& path, Warnings& warnings) {
  std::set<std::string> required;
  for (const char* key : {"extensionsRequired", "extensionsUsed"}) {
    const auto list = root.find(key);
    if (list == root.end()) continue;
    if (!list->is_array()) refuse("cannot read {}: {} is not a list; export it again", path, key);
    for (const Json& entry : *list) {
      if (!entry.is_string()) refuse("cannot read {}: {} holds something not a string; export it again", path, key);
      const std::string name = entry.get<std::string>();
      if (const char* const* note = note_of(name)) {
        const bool is_first = key == std::string("extensionsUsed");
        if (*note != nullptr && is_first) warnings.push_back(fmt::format("extension {}: {}", name, *note));
        continue;
      }
      if (key == std::string("extensionsRequired")) {
        refuse("cannot read {}: it requires the extension {}, which is not read; {}", path, name, remedy_for(name));
      }
      warnings.push_back(fmt::format("extension {} is not read; the scene is shown without it", name));
    }
  }
}

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

// Where tinygltf's callbacks get their bytes from: a few characters can name the same file or bytes over and over.
struct Source {
  Budget& budget;
  uint64_t hash = empty_hash;  // of the files that were read
  std::optional<Error> error;  // no exception passes through tinygltf

  // Says whether `bytes` more may be held, and keeps the Error where not.
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

// Buffer views with EXT_meshopt_compression name a place for decoded bytes that need not exist. Here they name their
// compressed bytes instead, so that what checks and loads views sees nothing special. True where there are such.
bool point_at_compressed(Json& root, const std::string& path) {
  constexpr const char* name = "EXT_meshopt_compression";
  const auto extension_of = [&](Json& object) -> const Json* {
    const auto extensions = object.find("extensions");
    if (extensions == object.end() || !extensions->is_object() || !extensions->contains(name)) return nullptr;
    const Json& found = extensions->at(name);
    if (!found.is_object()) refuse("cannot read {}: an extension {} is not an object; export it again", path, name);
    return &found;
  };
  bool changed = false;
  for (size_t i = 0; i < objects(root, "buffers", path).size(); ++i) {
    Json& buffer = root["buffers"][i];
    const Json* e = extension_of(buffer);
    if (e == nullptr || !e->contains("fallback") || e->at("fallback") != true) continue;
    buffer["byteLength"] = 1;
    buffer["uri"] = "data:application/octet-stream;base64,AA==";
    changed = true;
  }
  for (size_t i = 0; i < objects(root, "bufferViews", path).size(); ++i) {
    Json& view = root["bufferViews"][i];
    const Json* e = extension_of(view);
    if (e == nullptr) continue;
    for (const char* key : {"buffer", "byteOffset", "byteLength"}) {
      if (e->contains(key))
        view[key] = e->at(key);
      else
        view.erase(key);
    }
    changed = true;
  }
  return changed;
}

// tinygltf wants data behind every accessor of indices, and Draco's has none: the extension keeps their number.
bool hide_draco_indices(Json& root, const std::string& path) {
  constexpr const char* name = "KHR_draco_mesh_compression";
  bool changed = false;
  for (size_t i = 0; i < objects(root, "meshes", path).size(); ++i) {
    const auto primitives = root["meshes"][i].find("primitives");
    if (primitives == root["meshes"][i].end() || !primitives->is_array()) continue;
    for (Json& primitive : *primitives) {
      const Json::json_pointer e = Json::json_pointer("/extensions") / name;
      if (!primitive.is_object() || !primitive.contains(e) || !primitive[e].is_object()) continue;
      if (!primitive.contains("indices")) continue;
      primitive[e]["indices"] = primitive["indices"];
      primitive.erase("indices");
      changed = true;
    }
  }
  return changed;
}

// The same file with other JSON.
std::vector<uint8_t> with_json(std::span<const uint8_t> bytes, std::string json) {
  if (!is_binary(bytes)) return {json.begin(), json.end()};
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const auto rest = bytes.subspan(20 + read_u32(bytes, 12), read_u32(bytes, 8) - 20 - read_u32(bytes, 12));
  std::vector<uint8_t> result(bytes.begin(), bytes.begin() + 20);
  const uint32_t json_length = static_cast<uint32_t>(json.size());
  const uint32_t length = static_cast<uint32_t>(20 + json.size() + rest.size());
  std::memcpy(&result[8], &length, 4);
  std::memcpy(&result[12], &json_length, 4);
  result.insert(result.end(), json.begin(), json.end());
  result.insert(result.end(), rest.begin(), rest.end());
  return result;
}

bool keep_encoded(tinygltf::Image* image, int, std::string*, std::string*, int, int, const unsigned char* bytes,
                  int size, void* source) {
  if (!static_cast<Source*>(source)->take(static_cast<uint64_t>(size), "an encoded picture")) return false;
  image->image.assign(bytes, bytes + size);
  image->as_is = true;
  return true;
}

bool file_exists(const std::string& path, void*) {
  std::error_code error;
  return fs::is_regular_file(path, error);
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

// tinygltf asks for sizes too since 2.9, and then refuses a set of functions without one that tells.
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

void parse(std::span<const uint8_t> bytes, const std::string& folder, File& file) {
  tinygltf::TinyGLTF loader;
  Source source{.budget = file.budget, .hash = file.hash, .error = {}};
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
  // tinygltf says nothing of values of a wrong type.
  if (message.empty()) message = "a value is missing or not of the type that glTF gives it";
  if (!loaded) refuse("cannot read {}: {}; export it again", file.path, one_line(message));
}

// Later code indexes buffers through bufferViews without asking again.
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

// While it is parsed: the file, what is made of it (JSON with all data inside is copied twice), and each value.
uint64_t bytes_while_parsed(std::span<const uint8_t> bytes) {
  return (is_binary(bytes) ? uint64_t{2} : uint64_t{3}) * bytes.size();
}

}  // namespace

File read(const std::string& path, Budget& budget) {
  File file{.path = path, .model = {}, .warnings = {}, .budget = budget};
  budget.take(file_size(path), "the file");
  std::vector<uint8_t> bytes = read_file(path, limits::scene_file_bytes);
  budget.take(bytes_while_parsed(bytes) - bytes.size(), "the file, while it is read,");
  if (bytes.empty()) refuse("cannot read {}: the file is empty; get it again", path);
  file.hash = hash_of(bytes);
  drop_empty_chunk(bytes);
  fs::path folder = fs::path(path).parent_path();
  if (folder.empty()) folder = ".";
  {
    Json root = parse_json(json_text(bytes, path), path, budget);
    check_asset(root, path);
    bool changed = drop_nulls(root);
    changed |= mend_numbers(root);
    changed |= mend_uris(root, folder, file);
    changed |= hide_empty_primitives(root);
    file.broken_cameras = hide_broken_cameras(root);
    changed |= mend_targets(root);
    changed |= mend_spots(root) || !file.broken_cameras.empty();
    changed |= point_at_compressed(root, path);
    changed |= hide_draco_indices(root, path);
    check_structure(root, folder, is_binary(bytes), file);
    changed |= hide_broken_images(root, folder, file);
    if (changed) bytes = with_json(bytes, root.dump());
  }
  parse(bytes, folder.string(), file);
  budget.check_time("its JSON");
  check_loaded_buffers(file);
  budget.give_back(bytes.size());
  decode_meshopt(file);
  decode_draco(file);
  return file;
}

int add_buffer(File& file, std::vector<uint8_t> bytes) {
  file.model.buffers.emplace_back().data = std::move(bytes);
  return static_cast<int>(file.model.buffers.size() - 1);
}

std::string reason_of(const Error& error, const File& file) {
  std::string reason = error.what();
  const std::string before = fmt::format("cannot read {}", file.path);
  if (reason.starts_with(before)) reason.erase(0, before.size());
  reason.erase(0, reason.find_first_not_of(":, "));
  return reason.substr(0, reason.rfind("; "));
}

void warn_of_unused_images(const File& file, Content& content) {
  for (const auto& [image, message] : file.broken_images)
    content.warnings.push_back(fmt::format("image {}: it cannot be read, and nothing shown uses it; left out", image));
}

size_t checked_index(const File& file, int index, size_t count, const char* kind, const std::string& user) {
  if (index < 0 || static_cast<size_t>(index) >= count) {
    refuse("cannot read {}: {} uses {} {}, and there are {}; export it again", file.path, user, kind, index, count);
  }
  return static_cast<size_t>(index);
}

double number(const File& file, const tinygltf::Value& value, const char* key, double fallback) {
  if (!value.Has(key)) return fallback;
  const tinygltf::Value& entry = value.Get(key);
  const double result = entry.IsNumber() ? entry.GetNumberAsDouble() : not_a_number;
  if (!std::isfinite(result)) refuse("cannot read {}: {} is not a number; export it again", file.path, key);
  return result;
}

std::vector<double> numbers(const File& file, const tinygltf::Value& value, const char* key,
                            std::vector<double> fallback) {
  if (!value.Has(key)) return fallback;
  const tinygltf::Value& entry = value.Get(key);
  std::vector<double> result;
  if (entry.IsArray()) {
    for (size_t i = 0; i < entry.ArrayLen(); ++i) {
      const tinygltf::Value& element = entry.Get(static_cast<int>(i));
      result.push_back(element.IsNumber() ? element.GetNumberAsDouble() : not_a_number);
    }
  }
  const bool finite = std::all_of(result.begin(), result.end(), [](double x) { return std::isfinite(x); });
  if (result.size() != fallback.size() || !finite) {
    refuse("cannot read {}: {} is not a list of {} numbers; export it again", file.path, key, fallback.size());
  }
  return result;
}

const tinygltf::Value* extension(const tinygltf::ExtensionMap& extensions, const char* name) {
  const auto found = extensions.find(name);
  return found != extensions.end() && found->second.IsObject() ? &found->second : nullptr;
}

const tinygltf::Value* sideray_extras(const tinygltf::Value& extras) {
  if (!extras.IsObject() || !extras.Has("sideray")) return nullptr;
  const tinygltf::Value& ours = extras.Get("sideray");
  return ours.IsObject() ? &ours : nullptr;
}

}  // namespace sideray::scenes::gltf
