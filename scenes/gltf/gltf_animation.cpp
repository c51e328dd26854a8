#include <algorithm>
#include <cmath>

#include "scenes/base/limits.h"
#include "scenes/gltf/gltf.h"
#include "scenes/gltf/gltf_pointer.h"

// Reads animations: those of nodes as channels of the rig, those of pointers as values.
namespace sideray::scenes::gltf {
namespace {

std::string name_of(const File& file, size_t animation) {
  const std::string& name = file.model.animations[animation].name;
  return name.empty() ? fmt::format("animation{}", animation) : name;
}

std::optional<Property> property_of(const std::string& path) {
  if (path == "translation") return Property::translation;
  if (path == "rotation") return Property::rotation;
  if (path == "scale") return Property::scale;
  if (path == "weights") return Property::weights;
  return std::nullopt;
}

class AnimationReader {
 public:
  AnimationReader(const File& file, const std::vector<PlacedNode>& nodes, Rig& rig, Content& content)
      : file_(file), rig_(rig), content_(content), rig_node_(file.model.nodes.size(), -1) {
    for (size_t i = 0; i < nodes.size(); ++i) rig_node_[nodes[i].node] = static_cast<int>(i);
  }

  double length(size_t index) {
    file_.budget.check_time(fmt::format("animation {}", index));
    const tinygltf::Animation& animation = file_.model.animations[index];
    double length = 0.0;
    for (size_t c = 0; c < animation.channels.size(); ++c) {
      const std::string user = user_of(index, c);
      const std::vector<float> keys = times(sampler(animation, c, user), user);
      length = std::max(length, double{keys.back()});
      if (keys.front() < 0.0f)
        content_.warnings.push_back(fmt::format("{}: its times begin at {}; it plays from 0 on", user, keys.front()));
    }
    return length;
  }

  void play(size_t index, double period_s) {
    const tinygltf::Animation& animation = file_.model.animations[index];
    for (size_t c = 0; c < animation.channels.size(); ++c) {
      const tinygltf::AnimationChannel& source = animation.channels[c];
      const Source keys{sampler(animation, c, user_of(index, c)), user_of(index, c), period_s};
      if (source.target_path == "pointer") {
        play_pointer(source, keys);
        continue;
      }
      const std::optional<Property> property = property_of(source.target_path);
      // A channel without a node belongs to extensions.
      if (!property || source.target_node < 0) continue;
      play_node(checked_index(file_, source.target_node, rig_node_.size(), "node", keys.user), *property, keys);
    }
  }

  std::vector<AnimatedValue> take_values() { return std::move(values_); }

 private:
  // Locates the keys of a channel.
  struct Source {
    const tinygltf::AnimationSampler& sampler;
    std::string user;
    double period_s;
  };

  std::string user_of(size_t animation, size_t channel) const {
    return fmt::format("animation {}, channel {}", name_of(file_, animation), channel);
  }

  void play_node(size_t target_index, Property property, const Source& keys) {
    // Skips nodes outside the scene.
    const int node = rig_node_[target_index];
    if (node < 0) return;
    const tinygltf::Node& target = file_.model.nodes[target_index];
    const size_t targets = property == Property::weights ? target_count(file_, target) : 0;
    if (property == Property::weights && targets == 0) {
      content_.warnings.push_back(fmt::format("{}: its node has no morph targets; left out", keys.user));
      return;
    }
    const bool moves = property != Property::weights && property != Property::visible;
    if (moves && !target.matrix.empty()) {
      content_.warnings.push_back(
          fmt::format("{}: its node has a matrix, which cannot be animated; left out", keys.user));
      return;
    }
    Channel channel;
    channel.node = static_cast<uint32_t>(node);
    channel.property = property;
    channel.targets = static_cast<uint32_t>(targets);
    read_keys(keys, channel);
    rig_.nodes[channel.node].is_animated |= moves;
    rig_.nodes[channel.node].is_morphing |= property == Property::weights;
    rig_.nodes[channel.node].blinks |= property == Property::visible;
    rig_.channels.push_back(std::move(channel));
  }

  void play_pointer(const tinygltf::AnimationChannel& source, const Source& keys) {
    using Kind = PointerTarget::Kind;
    const tinygltf::Value* e = extension(source.target_extensions, "KHR_animation_pointer");
    if (e == nullptr) {
      content_.warnings.push_back(fmt::format("{}: it has no pointer of KHR_animation_pointer; left out", keys.user));
      return;
    }
    if (!e->Has("pointer") || !e->Get("pointer").IsString())
      refuse("cannot read {}: the pointer of {} is not text; export it again", file_.path, keys.user);
    const auto pointer = e->Get("pointer").Get<std::string>();
    auto target = std::make_shared<PointerTarget>(pointer_target(file_, pointer, keys.user));
    const bool of_node = target->kind == Kind::node;
    if (const auto property = property_of(target->property); of_node && property)
      return play_node(target->index, *property, keys);
    if (of_node && target->property == "extensions/KHR_node_visibility/visible")
      return play_node(target->index, Property::visible, keys);
    if (target->kind == Kind::mesh && target->property == "weights") return play_mesh_weights(target->index, keys);
    Channel channel;
    channel.property = Property::value;
    channel.targets = numbers_of(*target);
    if (channel.targets == 0) {
      if (unknown_.insert(pointer).second)
        content_.warnings.push_back(
            fmt::format("{}: its pointer {} leads to nothing that can change here; it stays as it is", keys.user,
                        pointer));
      return;
    }
    read_keys(keys, channel);
    values_.push_back({std::move(target), std::move(channel)});
  }

  // Animates the weights of a mesh: those of its nodes that have no own weights.
  void play_mesh_weights(size_t mesh, const Source& keys) {
    for (size_t i = 0; i < file_.model.nodes.size(); ++i) {
      const tinygltf::Node& node = file_.model.nodes[i];
      if (node.mesh == static_cast<int>(mesh) && node.weights.empty()) play_node(i, Property::weights, keys);
    }
  }

  const tinygltf::AnimationSampler& sampler(const tinygltf::Animation& animation, size_t channel,
                                            const std::string& user) {
    const auto& samplers = animation.samplers;
    return samplers[checked_index(file_, animation.channels[channel].sampler, samplers.size(), "sampler", user)];
  }

  // Refuses too many numbers: a few characters can name the same ones over and over.
  void count(size_t numbers) {
    numbers_ += numbers;
    if (numbers_ > limits::animation_numbers) {
      refuse("cannot read {}: its animations have more than {} numbers; use shorter ones", file_.path,
             limits::animation_numbers);
    }
  }

  std::vector<float> times(const tinygltf::AnimationSampler& source, const std::string& user) {
    const std::string what = user + ", times";
    count(accessor_count(file_, source.input, what));
    std::vector<float> times = read_floats(file_, source.input, 1, 0, what);
    const bool finite = std::all_of(times.begin(), times.end(), [](float t) { return std::isfinite(t); });
    if (!finite || !std::is_sorted(times.begin(), times.end())) {
      refuse("cannot read {}: {} are not growing numbers; correct them", file_.path, what);
    }
    return times;
  }

  void read_keys(const Source& keys, Channel& channel) {
    const tinygltf::AnimationSampler& source = keys.sampler;
    const std::string& user = keys.user;
    channel.period_s = keys.period_s;
    channel.times = times(source, user);
    size_t elements = channel.times.size();
    // Truth values cannot be interpolated.
    if (source.interpolation == "STEP" || channel.property == Property::visible) {
      channel.interpolation = Interpolation::step;
    } else if (source.interpolation == "CUBICSPLINE") {
      channel.interpolation = Interpolation::cubic;
      elements *= 3;
    } else if (!source.interpolation.empty() && source.interpolation != "LINEAR") {
      content_.warnings.push_back(
          fmt::format("{}: its interpolation \"{}\" is unknown; LINEAR is taken", user, source.interpolation));
    }
    // A key of weights has a number for each target, which are separate elements of the accessor.
    const bool is_weights = channel.property == Property::weights;
    const auto components = is_weights ? 1u : static_cast<uint32_t>(components_of(channel));
    if (is_weights) elements *= channel.targets;
    count(accessor_count(file_, source.output, user + ", values") * components);
    channel.values = read_floats(file_, source.output, components, elements, user + ", values");
    if (!std::all_of(channel.values.begin(), channel.values.end(), [](float v) { return std::isfinite(v); })) {
      refuse("cannot read {}: {} has values that are not finite; correct them", file_.path, user);
    }
  }

  const File& file_;
  Rig& rig_;
  Content& content_;
  std::vector<int> rig_node_;  // for each node of the file; -1 = not in the scene
  std::vector<AnimatedValue> values_;
  std::set<std::string> unknown_;  // pointers
  size_t numbers_ = 0;
};

}  // namespace

std::vector<AnimatedValue> read_animations(const File& file, const std::vector<PlacedNode>& nodes,
                                           const std::string& wanted, Rig& rig, Content& content) {
  AnimationReader reader(file, nodes, rig, content);
  for (size_t i = 0; i < file.model.animations.size(); ++i)
    content.animations.push_back({name_of(file, i), reader.length(i)});
  check_animation(content, wanted);
  bool has_one = false;
  for (size_t i = 0; i < content.animations.size(); ++i) {
    const bool is_wanted = wanted == "all" || (!has_one && (wanted.empty() || content.animations[i].name == wanted));
    if (!is_wanted) continue;
    has_one = true;
    reader.play(i, content.animations[i].length_s);
  }
  for (RigNode& node : rig.nodes) {
    const RigNode* parent = node.parent < 0 ? nullptr : &rig.nodes[static_cast<size_t>(node.parent)];
    node.blinks = node.blinks || (parent && parent->blinks);
    node.moves = node.is_animated || node.blinks || (parent && parent->moves);
  }
  return reader.take_values();
}

}  // namespace sideray::scenes::gltf
