// Defines the records of references: manifest.json beside them, and check.json beside the pictures of the last check.
// Any thread.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cli/options/options.h"
#include "lab/chart/configurations.h"
#include "lab/golden/changes.h"

namespace sideray::cli {

// Bounds the difference of another driver's pictures from a reference.
struct Drift {
  double flip = 0;   // mean
  double share = 0;  // share of pixels that differ in any bit, 0..1
};

struct GoldenPicture {
  std::string name;       // the job's output without its extension
  std::string file, ids;  // in the folder
  uint32_t width = 0, height = 0;
  std::string digest, ids_digest;  // of sizes, channels and values
  std::string driver;
  std::string camera;                     // digest
  std::vector<lab::NamedObject> objects;  // objects visible in pixels
  std::map<std::string, Drift> drifts;    // by driver
};

struct Manifest {
  std::string version;    // the program's version
  std::string jobs_file;  // relative to the folder of the references
  Given options;          // for every job that does not set them
  std::vector<lab::Configuration> jobs;
  std::vector<GoldenPicture> pictures;
};

// Holds a picture that differed, as it was drawn.
struct CheckedPicture {
  GoldenPicture drawn;
  Drift drift;
  bool is_colour_alone = false;  // every pixel shows the same object, and all values are finite
};

struct LastCheck {
  std::string manifest;  // digest of the manifest's text
  std::vector<CheckedPicture> pictures;
};

std::string text_of(const Manifest& manifest);
std::string text_of(const LastCheck& check);
// Throw Error where the file cannot be read, is damaged, or has another version.
Manifest read_manifest(const std::string& path);
LastCheck read_last_check(const std::string& path);

// Returns a digest of an image's content, however its file is compressed.
std::string digest_of(const scenes::Image& image);
std::string digest_of(const std::string& text);

}  // namespace sideray::cli
