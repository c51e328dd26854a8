// Keeps measurements of this machine in files, so that each is made once: a JSON value or a picture for each key. An
// entry that cannot be read, is truncated or belongs to another key counts as absent; one that cannot be written is
// dropped. Any thread may call it.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "scenes/images/images.h"

namespace sideray::lab {

class CalibrationCache {
 public:
  // With `folder` "" nothing is found and nothing is kept.
  explicit CalibrationCache(std::string folder) : folder_(std::move(folder)) {}

  // `key` holds everything that the value depends on.
  std::optional<nlohmann::json> find(const nlohmann::json& key) const;
  void keep(const nlohmann::json& key, const nlohmann::json& value) const;

  // Returns R, G and B with all their bits.
  std::optional<scenes::Image> find_picture(const nlohmann::json& key) const;
  void keep_picture(const nlohmann::json& key, scenes::Image picture) const;

 private:
  std::string path(const nlohmann::json& key, const char* extension) const;
  // Removes the oldest entries where there are too many.
  void make_room() const;

  std::string folder_;
};

// Returns $XDG_CACHE_HOME/sideray, else ~/.cache/sideray; "" with SIDERAY_CACHE=off, or without a home.
std::string calibration_folder();

}  // namespace sideray::lab
