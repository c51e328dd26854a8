#include "lab/golden/changes.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "lab/golden/light_factor.h"
#include "lab/golden/object_pairs.h"
#include "scenes/base/files.h"

namespace sideray::lab {
namespace {

using scenes::Image;

bool is_colour(const std::string& channel) {
  return channel == "R" || channel == "G" || channel == "B";
}

// Compares bits, since NaN does not equal itself, and -0 must differ from 0.
bool differs(const scenes::Plane& a, const scenes::Plane& b, size_t pixel) {
  if (a.type == scenes::Plane::Type::uint) return a.uint_values[pixel] != b.uint_values[pixel];
  return std::bit_cast<uint32_t>(a.values[pixel]) != std::bit_cast<uint32_t>(b.values[pixel]);
}

bool is_same_kind(const scenes::Plane& a, const scenes::Plane& b) {
  return a.name == b.name && a.type == b.type && a.values.size() == b.values.size() &&
         a.uint_values.size() == b.uint_values.size();
}

size_t pixels_of(const Image& image) {
  return size_t{image.width} * image.height;
}

// Which pixels differ, in colours and in any channel.
struct Marks {
  std::vector<bool> colour, any;
  std::vector<std::string> channels;  // differing ones other than colours
  uint64_t in_channels = 0;           // pixels
};

Marks marks_of(const Image& now, const Image& reference) {
  Marks marks{std::vector<bool>(pixels_of(now)), std::vector<bool>(pixels_of(now)), {}, 0};
  std::vector<bool> beside(pixels_of(now));
  for (const scenes::Plane& plane : now.planes) {
    const scenes::Plane* other = reference.find(plane.name);
    bool any = !other || !is_same_kind(plane, *other);
    if (!any)
      for (size_t i = 0; i < marks.any.size(); ++i)
        if (differs(plane, *other, i)) {
          any = marks.any[i] = true;
          (is_colour(plane.name) ? marks.colour : beside)[i] = true;
        }
    if (any && !is_colour(plane.name)) marks.channels.push_back(plane.name);
  }
  for (const scenes::Plane& plane : reference.planes)
    if (!now.find(plane.name)) marks.channels.push_back(plane.name);
  marks.in_channels = static_cast<uint64_t>(std::count(beside.begin(), beside.end(), true));
  return marks;
}

float distance_at(const Image& ids, size_t pixel) {
  const scenes::Plane* z = ids.find("first.Z");
  return z && !z->values.empty() ? z->values[pixel] : std::numeric_limits<float>::infinity();
}

// Counts the pixels of one object.
struct Tally {
  uint64_t before = 0, after = 0;  // pixels that show it
  uint64_t exchanged = 0;          // where it replaced another object in front, or uncovered one
  uint64_t recoloured = 0;         // that show it in both pictures, in other colours
  double flip = 0;                 // sum over the recoloured pixels
};

// Holds a tally for each object of the reference, then for each new object, and for the background last.
class Tallies {
 public:
  Tallies(const ShownPicture& now, const ShownPicture& reference, const SceneNow& scene)
      : now_(now), reference_(reference), scene_(scene) {
    const std::vector<size_t> now_shown = shown_objects(now), then_shown = shown_objects(reference);
    pairs_ = paired_objects(now.objects, now_shown, reference.objects, then_shown);
    tallies_.resize(reference.objects.size() + now.objects.size() + 1);
    for (size_t i = 0; i < then_shown.size(); ++i) {
      then_.push_back(then_shown[i] == no_object ? background() : then_shown[i]);
      now_index_.push_back(now_shown[i] == no_object ? background() : index_of_now(now_shown[i]));
    }
    count_pixels();
  }

  bool is_same_everywhere() const { return then_ == now_index_; }

  void add_colours(const std::vector<bool>& marks, const std::vector<float>& flip_map) {
    for (size_t i = 0; i < marks.size(); ++i) {
      if (!marks[i] || then_[i] != now_index_[i]) continue;
      Tally& tally = tallies_[then_[i]];
      ++tally.recoloured;
      if (!flip_map.empty()) tally.flip += double{flip_map[i]};
    }
  }

  std::vector<Change> changes(bool has_flip, bool with_looks) const {
    std::vector<Change> changes;
    for (size_t i = 0; i < tallies_.size(); ++i)
      if (const std::optional<Change> change = change_of(i, has_flip, with_looks)) changes.push_back(*change);
    // Moved objects come first, even with fewer pixels: they cause changed shadows and mirror images of others.
    std::stable_sort(changes.begin(), changes.end(), [](const Change& a, const Change& b) {
      const bool a_looks = a.kind == ChangeKind::look, b_looks = b.kind == ChangeKind::look;
      return a_looks != b_looks ? b_looks : a.pixels > b.pixels;
    });
    return changes;
  }

 private:
  size_t background() const { return tallies_.size() - 1; }
  size_t index_of_now(size_t object) const {
    return pairs_[object] != no_object ? pairs_[object] : reference_.objects.size() + object;
  }

  // Lays a pixel whose object changed to the nearer of the two objects, and to both at equal distance.
  void count_pixels() {
    for (size_t i = 0; i < then_.size(); ++i) {
      ++tallies_[then_[i]].before, ++tallies_[now_index_[i]].after;
      if (then_[i] == now_index_[i]) continue;
      const float before = distance_at(reference_.ids, i), after = distance_at(now_.ids, i);
      if (after <= before) ++tallies_[now_index_[i]].exchanged;
      if (before <= after) ++tallies_[then_[i]].exchanged;
    }
  }

  std::string label(size_t index) const {
    if (index == background()) return "";
    return label_of(index < reference_.objects.size() ? reference_.objects[index]
                                                      : now_.objects[index - reference_.objects.size()]);
  }

  bool is_in_scene_now(const NamedObject& object) const {
    const auto at = scene_.objects.find(object.name);
    return at != scene_.objects.end() && at->second >= object.of;
  }

  // Returns whether the object has another place. It may cover the same pixels: a wall that slides along itself.
  bool stands_elsewhere(size_t index) const {
    if (index >= reference_.objects.size()) return false;
    const auto now = std::find(pairs_.begin(), pairs_.end(), index);
    const std::string& place = reference_.objects[index].place;
    return now != pairs_.end() && !place.empty() &&
           now_.objects[static_cast<size_t>(now - pairs_.begin())].place != place;
  }

  std::optional<Change> change_of(size_t index, bool has_flip, bool with_looks) const {
    const Tally& tally = tallies_[index];
    const bool is_object = index != background();
    if (is_object && tally.before > 0 && tally.after == 0)
      return Change{is_in_scene_now(reference_.objects[index]) ? ChangeKind::out_of_sight : ChangeKind::missing,
                    label(index), tally.before, {}, 1};
    if (is_object && tally.before == 0 && tally.after > 0)
      return Change{ChangeKind::added, label(index), tally.after, {}, 1};
    if (is_object && tally.exchanged > 1) return Change{ChangeKind::moved, label(index), tally.exchanged, {}, 1};
    if (tally.recoloured > 0 && stands_elsewhere(index))
      return Change{ChangeKind::moved, label(index), tally.recoloured, {}, 1};
    if (!with_looks || tally.recoloured == 0) return {};
    const double mean = tally.flip / static_cast<double>(tally.recoloured);
    return Change{ChangeKind::look, label(index), tally.recoloured,
                  has_flip ? std::optional<double>(mean) : std::nullopt, 1};
  }

  const ShownPicture &now_, &reference_;
  const SceneNow& scene_;
  std::vector<size_t> pairs_;             // for each object now, its index in the reference
  std::vector<size_t> then_, now_index_;  // for each pixel, the index of its object
  std::vector<Tally> tallies_;
};

std::string counted(uint64_t pixels) {
  const std::string digits = fmt::format("{}", pixels);
  std::string text;
  for (size_t i = 0; i < digits.size(); ++i) {
    if (i > 0 && (digits.size() - i) % 3 == 0) text += ',';
    text += digits[i];
  }
  return text + (pixels == 1 ? " pixel" : " pixels");
}

}  // namespace

std::string label_of(const NamedObject& object) {
  return object.of > 1 ? fmt::format("{} #{}", object.name, object.number) : object.name;
}

bool is_same_image(const Image& a, const Image& b) {
  if (a.width != b.width || a.height != b.height || a.planes.size() != b.planes.size() || a.linear != b.linear)
    return false;
  for (size_t k = 0; k < a.planes.size(); ++k) {
    if (!is_same_kind(a.planes[k], b.planes[k])) return false;
    for (size_t i = 0; i < pixels_of(a); ++i)
      if (differs(a.planes[k], b.planes[k], i)) return false;
  }
  return true;
}

Differences differences(const ShownPicture& now, const ShownPicture& reference, const SceneNow& scene,
                        const Display& display) {
  Differences result;
  Tallies tallies(now, reference, scene);
  result.has_same_ids = tallies.is_same_everywhere();
  result.is_equal = is_same_image(now.picture, reference.picture);
  const Marks marks = marks_of(now.picture, reference.picture);
  result.pixels = static_cast<uint64_t>(std::count(marks.any.begin(), marks.any.end(), true));
  if (!result.is_equal) {
    Comparison comparison = compare(now.picture, reference.picture, display);
    result.flip = comparison.metrics.flip;
    result.flip_map = std::move(comparison.flip_map);
  } else {
    result.flip = 0;
  }
  if (!scene.has_same_camera) result.changes.push_back({ChangeKind::camera, "", 0, {}, 1});
  std::optional<double> factor;
  if (scene.radiance && scene.has_same_camera && result.has_same_ids && !result.is_equal)
    factor = light_factor(*scene.radiance, reference.picture, display);
  if (factor) result.changes.push_back({ChangeKind::light, "", result.pixels, {}, *factor});
  tallies.add_colours(marks.colour, result.flip_map);
  // A change of the light by one factor explains the changed colours of all objects.
  for (Change& change : tallies.changes(!result.flip_map.empty(), !factor)) result.changes.push_back(std::move(change));
  if (!marks.channels.empty())
    result.changes.push_back(
        {ChangeKind::channels, fmt::format("{}", fmt::join(marks.channels, ", ")), marks.in_channels, {}, 1});
  return result;
}

std::string describe(const Change& change) {
  const std::string who = change.name.empty() ? "the background" : fmt::format("'{}'", scenes::printable(change.name));
  switch (change.kind) {
    case ChangeKind::camera:
      return "the camera is another one";
    case ChangeKind::light:
      return fmt::format("the light is {:.3g} times as bright everywhere", change.factor);
    case ChangeKind::missing:
      return fmt::format("{} is missing ({})", who, counted(change.pixels));
    case ChangeKind::out_of_sight:
      return fmt::format("{} is out of sight ({})", who, counted(change.pixels));
    case ChangeKind::added:
      return fmt::format("{} appears ({})", who, counted(change.pixels));
    case ChangeKind::moved:
      return fmt::format("{} moved ({})", who, counted(change.pixels));
    case ChangeKind::channels:
      return fmt::format("channels {} differ ({})", change.name, counted(change.pixels));
    case ChangeKind::look:
      break;
  }
  if (!change.flip) return fmt::format("{} looks otherwise ({})", who, counted(change.pixels));
  return fmt::format("{} looks otherwise (FLIP {:.2g} over {})", who, *change.flip, counted(change.pixels));
}

std::string describe(const std::vector<Change>& changes, size_t most) {
  std::vector<std::string> texts;
  for (const Change& change : changes)
    if (texts.size() < most) texts.push_back(describe(change));
  if (changes.size() > most) texts.push_back(fmt::format("{} more", changes.size() - most));
  return fmt::format("{}", fmt::join(texts, ", "));
}

}  // namespace sideray::lab
