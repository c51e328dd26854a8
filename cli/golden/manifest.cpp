#include "cli/golden/manifest.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "scenes/base/files.h"

namespace sideray::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr int schema = 1;
constexpr uint64_t most_bytes = uint64_t{256} << 20;

uint64_t hash_of_value(const void* value, size_t size, uint64_t before) {
  return scenes::hash_of({static_cast<const uint8_t*>(value), size}, before);
}

Json json_of(const lab::NamedObject& object) {
  Json json = {{"name", object.name}};
  if (object.of > 1) json["number"] = object.number, json["of"] = object.of;
  json["surfaces"] = object.surfaces;
  json["place"] = object.place;
  return json;
}

lab::NamedObject object_of(const Json& json) {
  return {json.at("name"), json.value("number", 1u), json.value("of", 1u), json.at("surfaces"), json.at("place")};
}

Json json_of(const Drift& drift) {
  return {{"flip", drift.flip}, {"share", drift.share}};
}

Drift drift_of(const Json& json) {
  return {json.at("flip"), json.at("share")};
}

Json json_of(const GoldenPicture& picture) {
  Json json = {{"name", picture.name},     {"file", picture.file},         {"ids", picture.ids},
               {"width", picture.width},   {"height", picture.height},     {"digest", picture.digest},
               {"ids_digest", picture.ids_digest}, {"driver", picture.driver}, {"camera", picture.camera}};
  json["objects"] = Json::array();
  for (const lab::NamedObject& object : picture.objects) json["objects"].push_back(json_of(object));
  for (const auto& [driver, drift] : picture.drifts) json["drift"][driver] = json_of(drift);
  return json;
}

GoldenPicture picture_of(const Json& json) {
  GoldenPicture picture{json.at("name"),   json.at("file"),       json.at("ids"),
                        json.at("width"),  json.at("height"),     json.at("digest"),
                        json.at("ids_digest"), json.at("driver"), json.at("camera"), {}, {}};
  for (const Json& object : json.at("objects")) picture.objects.push_back(object_of(object));
  if (json.contains("drift"))
    for (const auto& [driver, drift] : json["drift"].items()) picture.drifts[driver] = drift_of(drift);
  return picture;
}

// Writes each picture on a line, so that a change of one is a change of one line.
std::string text_with_list(const Json& head, const char* list, const std::vector<Json>& entries) {
  std::string text = head.dump(1, ' ', false, Json::error_handler_t::replace);
  text.resize(text.size() - 2);  // drops the last brace
  text += fmt::format(",\n \"{}\": [", list);
  for (size_t i = 0; i < entries.size(); ++i)
    text += (i == 0 ? "\n  " : ",\n  ") + entries[i].dump(-1, ' ', false, Json::error_handler_t::replace);
  return text + "\n ]\n}\n";
}

// Reads a file by `read`; any fault makes one line that names the file.
template <typename Read>
auto read_json(const std::string& path, const char* what, const Read& read) {
  const std::vector<uint8_t> bytes = scenes::read_file(path, most_bytes);
  const Json json = Json::parse(bytes, nullptr, false);
  if (!json.is_object() || !json.contains("schema"))
    scenes::refuse("{}: is not {}, or damaged; restore it, or record again", path, what);
  if (json["schema"] != schema)
    scenes::refuse("{}: is of version {}, this program reads {}; record again, or use the program that recorded it",
                   path, json["schema"].dump(), schema);
  try {
    return read(json);
  } catch (const Json::exception&) {
    scenes::refuse("{}: is not {}, or damaged; restore it, or record again", path, what);
  }
}

}  // namespace

std::string text_of(const Manifest& manifest) {
  const Json head = {{"schema", schema},
                     {"sideray", manifest.version},
                     {"jobs_file", manifest.jobs_file},
                     {"options", manifest.options},
                     {"jobs", manifest.jobs}};
  std::vector<Json> pictures;
  for (const GoldenPicture& picture : manifest.pictures) pictures.push_back(json_of(picture));
  return text_with_list(head, "pictures", pictures);
}

std::string text_of(const LastCheck& check) {
  std::vector<Json> pictures;
  for (const CheckedPicture& picture : check.pictures)
    pictures.push_back({{"drawn", json_of(picture.drawn)},
                        {"drift", json_of(picture.drift)},
                        {"is_colour_alone", picture.is_colour_alone}});
  return text_with_list({{"schema", schema}, {"manifest", check.manifest}}, "pictures", pictures);
}

Manifest read_manifest(const std::string& path) {
  return read_json(path, "a manifest of references", [](const Json& json) {
    Manifest manifest{json.at("sideray"), json.at("jobs_file"), json.at("options"), json.at("jobs"), {}};
    for (const Json& picture : json.at("pictures")) manifest.pictures.push_back(picture_of(picture));
    return manifest;
  });
}

LastCheck read_last_check(const std::string& path) {
  return read_json(path, "a list of checked pictures", [](const Json& json) {
    LastCheck check{json.at("manifest"), {}};
    for (const Json& picture : json.at("pictures"))
      check.pictures.push_back(
          {picture_of(picture.at("drawn")), drift_of(picture.at("drift")), picture.at("is_colour_alone")});
    return check;
  });
}

std::string digest_of(const scenes::Image& image) {
  uint64_t hash = scenes::empty_hash;
  const uint32_t size[] = {image.width, image.height, image.linear ? 1u : 0u};
  hash = hash_of_value(size, sizeof(size), hash);
  for (const scenes::Plane& plane : image.planes) {
    hash = hash_of_value(plane.name.c_str(), plane.name.size() + 1, hash);
    hash = hash_of_value(&plane.type, sizeof(plane.type), hash);
    hash = hash_of_value(plane.values.data(), plane.values.size() * sizeof(float), hash);
    hash = hash_of_value(plane.uint_values.data(), plane.uint_values.size() * sizeof(uint32_t), hash);
  }
  return fmt::format("{:016x}", hash);
}

std::string digest_of(const std::string& text) {
  return fmt::format("{:016x}", hash_of_value(text.data(), text.size(), scenes::empty_hash));
}

}  // namespace sideray::cli
