#include <algorithm>
#include <bit>
#include <cmath>

#include "scenes/glb/glb_instances.h"
#include "scenes/gltf/gltf.h"
#include "scenes/base/limits.h"

// Reads EXT_mesh_gpu_instancing, and the custom attributes that our writer adds (docs/gltf.md).
namespace sideray::scenes::gltf {
namespace {

// Reads the attributes of one node; each has one element for each instance.
class AttributeReader {
 public:
  AttributeReader(const File& file, const tinygltf::Value& attributes, const std::string& name)
      : file_(file), attributes_(attributes), name_(name) {
    count_instances();
  }

  // Includes attributes of other programs.
  size_t count() const { return count_; }

  // Returns an empty list if the node lacks the attribute.
  std::vector<float> read(const char* key, uint32_t components) const {
    if (!attributes_.Has(key)) return {};
    const std::string user = user_of(key);
    std::vector<float> values = read_floats(file_, accessor(key, user), components, count_, user);
    if (!std::all_of(values.begin(), values.end(), [](float x) { return std::isfinite(x); }))
      refuse("cannot read {}: {} is not finite; correct it", file_.path, user);
    return values;
  }

  // Returns one row of every instance's matrix; a row is four doubles in 16 unsigned shorts.
  std::vector<double> read_row(const char* key) const {
    if (!attributes_.Has(key)) return {};
    const std::string user = user_of(key);
    const std::vector<float> parts = read(key, 16);
    const tinygltf::Accessor& source = file_.model.accessors[static_cast<size_t>(accessor(key, user))];
    if (source.componentType != TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT || source.normalized)
      refuse("cannot read {}: {} is not of unsigned shorts; export it again", file_.path, user);
    std::vector<double> row;
    row.reserve(parts.size() / 4);
    for (size_t i = 0; i < parts.size(); i += 4) row.push_back(double_of(&parts[i]));
    if (!std::all_of(row.begin(), row.end(), [](double x) { return std::isfinite(x); }))
      refuse("cannot read {}: {} is not finite; correct it", file_.path, user);
    return row;
  }

 private:
  // Joins four unsigned shorts into a double, the lowest bits first.
  static double double_of(const float* parts) {
    uint64_t bits = 0;
    for (int i = 0; i < 4; ++i) bits |= static_cast<uint64_t>(parts[i]) << (16 * i);
    return std::bit_cast<double>(bits);
  }

  std::string user_of(const std::string& key) const { return fmt::format("node {}, instance {}", name_, key); }

  int accessor(const std::string& key, const std::string& user) const {
    const double index = number(file_, attributes_, key.c_str(), -1.0);
    if (!(index >= 0.0 && index <= 2147483647.0) || index != std::floor(index))
      refuse("cannot read {}: {} is {}, not the number of an accessor; export it again", file_.path, user, index);
    return static_cast<int>(index);
  }

  // Must be called before memory is allocated.
  void count_instances() {
    for (const std::string& key : attributes_.Keys()) {
      const std::string user = user_of(key);
      const size_t elements = accessor_count(file_, accessor(key, user), user);
      if (count_ == 0) count_ = elements;
      if (elements != count_)
        refuse("cannot read {}: {} has {} elements where {} belong; export it again", file_.path, user, elements,
               count_);
    }
    if (count_ > limits::objects)
      refuse("cannot read {}: node {} has {} instances, more than {}; use a smaller scene", file_.path, name_, count_,
             limits::objects);
    // The two matrices of each instance during assembly.
    file_.budget.check_memory(count_ * 2 * sizeof(glm::dmat4), "node " + name_);
  }

  const File& file_;
  const tinygltf::Value& attributes_;
  const std::string& name_;
  size_t count_ = 0;
};

std::vector<glm::dmat4> placements(const AttributeReader& attributes) {
  const std::vector<float> translations = attributes.read("TRANSLATION", 3), rotations = attributes.read("ROTATION", 4),
                           scales = attributes.read("SCALE", 3);
  std::vector<glm::dmat4> transforms(attributes.count(), glm::dmat4(1.0));
  for (size_t i = 0; i < transforms.size(); ++i) {
    transforms[i] = instance_transform({translations.empty() ? nullptr : &translations[3 * i],
                                        rotations.empty() ? nullptr : &rotations[4 * i],
                                        scales.empty() ? nullptr : &scales[3 * i]});
  }
  return transforms;
}

// Returns whether two transforms are equal up to the rounding of floats.
bool is_same_place(const glm::dmat4& exact, const glm::dmat4& rounded) {
  constexpr double tolerance = 1e-5;
  for (int c = 0; c < 4; ++c) {
    double largest = 0.0, farthest = 0.0;
    for (int r = 0; r < 3; ++r) {
      largest = std::max(largest, std::abs(exact[c][r]));
      farthest = std::max(farthest, std::abs(exact[c][r] - rounded[c][r]));
    }
    if (!(farthest <= tolerance * largest)) return false;
  }
  return true;
}

// Replaces the transforms from TRANSLATION, ROTATION and SCALE, which are rounded to floats, by the exact doubles. An
// instance whose floats disagree was moved by a program that ignores the doubles, and keeps its floats.
void make_exact(const AttributeReader& attributes, const std::string& name, Content& content,
                std::vector<glm::dmat4>& transforms) {
  std::vector<glm::dmat4> exact = transforms;
  for (int r = 0; r < 3; ++r) {
    const std::vector<double> row = attributes.read_row(matrix_row_attributes[r]);
    for (size_t i = 0; i < row.size(); ++i) exact[i / 4][static_cast<int>(i % 4)][r] = row[i];
  }
  size_t moved = 0;
  for (size_t i = 0; i < transforms.size(); ++i) {
    if (is_same_place(exact[i], transforms[i]))
      transforms[i] = exact[i];
    else
      ++moved;
  }
  if (moved == 0) return;
  content.warnings.push_back(
      fmt::format("node {}: {} instances are not where {} to 2 have them; TRANSLATION, ROTATION and SCALE are taken",
                  name, moved, matrix_row_attributes[0]));
}

std::vector<float> wind_phases(const File& file, const AttributeReader& attributes, const tinygltf::Node& node,
                               const std::string& name) {
  const tinygltf::Value* ours = sideray_extras(node.extras);
  if (ours == nullptr || !ours->Has("wind")) return {};
  std::vector<float> phases = attributes.read(wind_phase_attribute, 1);
  for (const float phase : phases) {
    if (!(phase >= 0.0f && phase <= 1.0f))
      refuse("cannot read {}: node {}, instance {} is {}; give 0 to 1", file.path, name, wind_phase_attribute, phase);
  }
  return phases;
}

std::vector<uint32_t> object_indices(const File& file, const AttributeReader& attributes, const std::string& name) {
  std::vector<uint32_t> indices;
  for (const float index : attributes.read(object_index_attribute, 1)) {
    if (!(index >= 0.0f && index < 16777216.0f) || index != std::floor(index))
      refuse("cannot read {}: node {}, instance {} is {}; give whole numbers from 0 to 2^24-1", file.path, name,
             object_index_attribute, index);
    indices.push_back(static_cast<uint32_t>(index));
  }
  return indices;
}

// Returns null if the node is not instanced.
const tinygltf::Value* attributes_of(const tinygltf::Node& node) {
  const tinygltf::Value* e = extension(node.extensions, instancing_extension);
  if (e == nullptr || !e->Has("attributes")) return nullptr;
  return &e->Get("attributes");
}

}  // namespace

Instances read_instances(const File& file, const tinygltf::Node& node, const std::string& name, Content& content) {
  Instances instances;
  const tinygltf::Value* given = attributes_of(node);
  if (given == nullptr) {
    instances.node_from_instance.emplace_back(1.0);
    return instances;
  }
  if (!given->IsObject())
    refuse("cannot read {}: node {}, attributes of {} is not an object; export it again", file.path, name,
           instancing_extension);
  const AttributeReader attributes(file, *given, name);
  instances.node_from_instance = placements(attributes);
  make_exact(attributes, name, content, instances.node_from_instance);
  instances.wind_phases = wind_phases(file, attributes, node, name);
  instances.object_indices = object_indices(file, attributes, name);
  return instances;
}

bool has_wind_phases(const tinygltf::Node& node) {
  const tinygltf::Value* attributes = attributes_of(node);
  return attributes != nullptr && attributes->Has(wind_phase_attribute);
}

void order_objects(std::span<const uint32_t> places, Rig& rig, Content& content) {
  std::vector<uint32_t> placed;
  for (uint32_t i = 0; i < places.size(); ++i)
    if (places[i] != any_place) placed.push_back(i);
  if (placed.empty()) return;
  std::stable_sort(placed.begin(), placed.end(), [&](uint32_t a, uint32_t b) { return places[a] < places[b]; });
  std::vector<Object> ordered;
  ordered.reserve(content.objects.size());
  std::vector<uint32_t> new_index(content.objects.size());
  auto next_placed = placed.begin();
  uint32_t next_free = 0;
  while (ordered.size() < content.objects.size()) {
    while (next_free < places.size() && places[next_free] != any_place) ++next_free;
    const bool is_due = next_placed != placed.end() &&
                        (places[*next_placed] <= ordered.size() || next_free == places.size());
    const uint32_t from = is_due ? *next_placed++ : next_free++;
    new_index[from] = static_cast<uint32_t>(ordered.size());
    ordered.push_back(std::move(content.objects[from]));
  }
  content.objects = std::move(ordered);
  for (Attached& attached : rig.objects) attached.index = new_index[attached.index];
}

}  // namespace sideray::scenes::gltf
