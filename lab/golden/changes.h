// What is different between two pictures of one view, told by the objects that their pixels show. Plain memory; any
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

// An object of a scene: the number-th of its name (from 1) among `of`.
struct NamedObject {
  std::string name;
  uint32_t number = 1, of = 1;
  std::vector<uint32_t> surfaces;  // its surface ids
  std::string place;               // a digest of where it stands; "" = unknown
};
// "vase", or "tree #12" where the scene has several of the name.
std::string label_of(const NamedObject& object);

// A picture with what its pixels show.
struct ShownPicture {
  const scenes::Image& picture;
  const scenes::Image& ids;  // "first.surface" and, to tell what is in front, "first.Z"
  const std::vector<NamedObject>& objects;  // those that pixels show
};

// What else is known of the scene as it is now.
struct SceneNow {
  std::map<std::string, uint32_t> objects;  // how many of each name, seen or not
  bool has_same_camera = true;
  const scenes::Image* radiance = nullptr;  // of the picture before exposure and tone mapping
};

enum class ChangeKind {
  camera,        // the view is another one
  light,         // all is `factor` times as bright
  missing,       // the scene has the object no more
  out_of_sight,  // the scene has it, and no pixel shows it
  added,         // no pixel showed it
  moved,         // stands elsewhere, or pixels came to it or went from it
  look,          // shown by the same pixels with other colours
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
  // Of the whole picture, then of objects that are elsewhere, then of those that look otherwise; the most pixels first.
  std::vector<Change> changes;
  std::vector<float> flip_map; // one value a pixel; empty likewise
};

// Whether sizes, names and types of all channels and all of their bits are the same.
bool is_same_image(const scenes::Image& a, const scenes::Image& b);

// Compares what is drawn now with the reference, both of one size. An object is known by its name and number, or, where
// the scenes have different numbers of a name, by the pixels that it shares. A pixel that goes from one object to another
// is laid to the one in front of the other: it came, or it went.
Differences differences(const ShownPicture& now, const ShownPicture& reference, const SceneNow& scene,
                        const Display& display);

// "'vase 3' moved (412 pixels)"
std::string describe(const Change& change);
// The first `most` of them in one line; "" where there are none.
std::string describe(const std::vector<Change>& changes, size_t most);

}  // namespace sideray::lab
