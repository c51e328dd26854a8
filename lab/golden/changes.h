// Describes the differences between two pictures of one view, by the objects that their pixels show. Plain memory; any
// thread.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "lab/metrics/metrics.h"
#include "scenes/images/images.h"

namespace sideray::lab {

// An object of a scene: number `number` (from 1) of the `of` objects with its name.
struct NamedObject {
  std::string name;
  uint32_t number = 1, of = 1;
  std::vector<uint32_t> surfaces;  // its surface ids
  std::string place;               // a digest of its transforms; "" = unknown
};
// Returns "vase", or "tree #12" if several objects have the name.
std::string label_of(const NamedObject& object);

// A picture with the objects in its pixels.
struct ShownPicture {
  const scenes::Image& picture;
  const scenes::Image& ids;  // "first.surface", and "first.Z" to tell which surface is in front
  const std::vector<NamedObject>& objects;  // objects that pixels may show
};

// Holds further facts about the current scene.
struct SceneNow {
  std::map<std::string, uint32_t> objects;  // name -> number of objects, visible or not
  bool has_same_camera = true;
  const scenes::Image* radiance = nullptr;  // of the picture before exposure and tone mapping
};

enum class ChangeKind {
  camera,        // the view changed
  light,         // everything is `factor` times as bright
  missing,       // no longer in the scene
  out_of_sight,  // still in the scene, but no pixel shows it
  added,         // newly visible
  moved,         // its transform changed, or pixels came to it or left it
  look,          // the same pixels show it in other colours
  channels       // channels besides the colours differ; `name` lists them
};

struct Change {
  ChangeKind kind;
  std::string name;  // the object's label; "" = the background
  uint64_t pixels = 0;
  std::optional<double> flip;  // look: mean FLIP over these pixels
  double factor = 1;           // light
};

struct Differences {
  bool is_equal = true;        // in size, channels and all bits
  bool has_same_ids = true;    // every pixel shows the same object
  uint64_t pixels = 0;         // pixels that differ in any channel
  std::optional<double> flip;  // mean; empty if pixels are not finite
  // Changes of the whole picture first, then of moved objects, then of those that look different; within each, the most
  // pixels first.
  std::vector<Change> changes;
  std::vector<float> flip_map; // one value a pixel; empty if pixels are not finite
};

// Returns whether sizes, and names, types and bits of all channels, are equal.
bool is_same_image(const scenes::Image& a, const scenes::Image& b);

// Compares the current picture with the reference, which must have the same size. Objects are matched by name and
// number or, if the scenes have different numbers of a name, by shared pixels. A pixel that changes from one object to
// another is attributed to the nearer of the two: it came, or it left.
Differences differences(const ShownPicture& now, const ShownPicture& reference, const SceneNow& scene,
                        const Display& display);

// Returns a text: "'vase 3' moved (412 pixels)".
std::string describe(const Change& change);
// Returns the first `most` of them in one line; "" without changes.
std::string describe(const std::vector<Change>& changes, size_t most);

}  // namespace sideray::lab
