// Lists the differences between two pictures of one view by the objects that their pixels show. Plain memory; any
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

// Names an object of a scene: number `number` (from 1) of the `of` objects with this name.
struct NamedObject {
  std::string name;
  uint32_t number = 1, of = 1;
  std::vector<uint32_t> surfaces;  // its surface ids
  std::string place;               // a digest of where it stands; "" = unknown
};
// Returns "vase", or "tree #12" where the scene has several objects of the name.
std::string label_of(const NamedObject& object);

// Refers to a picture, and to the objects that its pixels show.
struct ShownPicture {
  const scenes::Image& picture;
  const scenes::Image& ids;  // "first.surface" and, to tell what is in front, "first.Z"
  const std::vector<NamedObject>& objects;  // those that pixels show
};

// Holds what else is known of the current scene.
struct SceneNow {
  std::map<std::string, uint32_t> objects;  // name -> number of objects, visible or not
  bool has_same_camera = true;
  const scenes::Image* radiance = nullptr;  // of the picture before exposure and tone mapping
};

enum class ChangeKind {
  camera,        // the view differs
  light,         // everything is `factor` times as bright
  missing,       // the scene no longer has the object
  out_of_sight,  // the scene has the object, but no pixel shows it
  added,         // no pixel of the reference showed the object
  moved,         // the object stands elsewhere, or gained or lost pixels
  look,          // the same pixels show the object in other colours
  channels       // channels beside the colours differ; `name` lists them
};

struct Change {
  ChangeKind kind;
  std::string name;  // of the object: its label; "" = the background
  uint64_t pixels = 0;
  std::optional<double> flip;  // look: mean FLIP over these pixels
  double factor = 1;           // light
};

struct Differences {
  bool is_equal = true;        // of size, channels and all bits
  bool has_same_ids = true;    // every pixel shows the same object
  uint64_t pixels = 0;         // that differ in any channel
  std::optional<double> flip;  // mean; empty with pixels that are not finite
  // Changes of the whole picture come first, then of objects that moved, then of objects that only look different; in
  // each group those of the most pixels come first.
  std::vector<Change> changes;
  std::vector<float> flip_map; // one value a pixel; empty likewise
};

// Returns whether both have the same size, and channels of the same names, types and bits.
bool is_same_image(const scenes::Image& a, const scenes::Image& b);

// Compares the picture drawn now with the reference of the same size. An object is recognized by its name and number,
// or, where the scenes have different numbers of objects of a name, by the pixels that show it in both. A pixel that
// shows another object than before counts as a change of the nearer of the two: that one came, or it went.
Differences differences(const ShownPicture& now, const ShownPicture& reference, const SceneNow& scene,
                        const Display& display);

// Returns text such as "'vase 3' moved (412 pixels)".
std::string describe(const Change& change);
// Returns the first `most` changes in one line; "" where there are none.
std::string describe(const std::vector<Change>& changes, size_t most);

}  // namespace sideray::lab
