#include <filesystem>
#include <nlohmann/json.hpp>

#include "scenes/base/files.h"
#include "scenes/base/limits.h"
#include "scenes/gltf/file/checks.h"
#include "scenes/gltf/file/container.h"
#include "scenes/gltf/file/json.h"
#include "scenes/gltf/file/mend.h"
#include "scenes/gltf/file/parse.h"
#include "scenes/gltf/file/uris.h"
#include "scenes/gltf/gltf.h"

namespace sideray::scenes::gltf {
namespace {

// Returns the memory while parsing, apart from values: the file and its copies, of which JSON with embedded data has
// two.
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
  std::filesystem::path folder = std::filesystem::path(path).parent_path();
  if (folder.empty()) folder = ".";
  {
    nlohmann::json root = parse_json(json_text(bytes, path), path, budget);
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

}  // namespace sideray::scenes::gltf
