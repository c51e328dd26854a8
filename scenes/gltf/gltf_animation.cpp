#include <algorithm>
#include <cmath>

#include "scenes/base/limits.h"
#include "scenes/gltf/gltf.h"

// Node animations as channels of the rig.
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
      const std::string user = fmt::format("animation {}, channel {}", name_of(file_, index), c);
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
      const std::string user = fmt::format("animation {}, channel {}", name_of(file_, index), c);
      const std::optional<Property> property = property_of(source.target_path);
      // Without a node it is for extensions; nodes outside the scene are not seen.
      if (!property || source.target_node < 0) continue;
      const int node = rig_node_[checked_index(file_, source.target_node, rig_node_.size(), "node", user)];
      if (node < 0) continue;
      const tinygltf::Node& target = file_.model.nodes[static_cast<size_t>(source.target_node)];
      const bool is_weights = property == Property::weights;
      const size_t targets = is_weights ? target_count(file_, target) : 0;
      if (is_weights && targets == 0) {
        content_.warnings.push_back(fmt::format("{}: its node has no morph targets; left out", user));
        continue;
      }
      if (!is_weights && !target.matrix.empty()) {
        content_.warnings.push_back(fmt::format("{}: its node has a matrix, which cannot be animated; left out", user));
        continue;
      }
      Channel channel;
      channel.node = static_cast<uint32_t>(node);
      channel.property = *property;
      channel.period_s = period_s;
      channel.targets = static_cast<uint32_t>(targets);
      read_keys(sampler(animation, c, user), user, channel);
      rig_.nodes[channel.node].is_animated |= !is_weights;
      rig_.nodes[channel.node].is_morphing |= is_weights;
      rig_.channels.push_back(std::move(channel));
    }
  }

 private:
  const tinygltf::AnimationSampler& sampler(const tinygltf::Animation& animation, size_t channel,
                                            const std::string& user) {
    const auto& samplers = animation.samplers;
    return samplers[checked_index(file_, animation.channels[channel].sampler, samplers.size(), "sampler", user)];
  }

  // A few characters can name the same numbers over and over.
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

  void read_keys(const tinygltf::AnimationSampler& source, const std::string& user, Channel& channel) {
    channel.times = times(source, user);
    size_t elements = channel.times.size();
    if (source.interpolation == "STEP") {
      channel.interpolation = Interpolation::step;
    } else if (source.interpolation == "CUBICSPLINE") {
      channel.interpolation = Interpolation::cubic;
      elements *= 3;
    } else if (!source.interpolation.empty() && source.interpolation != "LINEAR") {
      content_.warnings.push_back(
          fmt::format("{}: its interpolation \"{}\" is unknown; LINEAR is taken", user, source.interpolation));
    }
    // Weights are single numbers, as many a key as there are targets.
    const bool is_weights = channel.property == Property::weights;
    const uint32_t components = is_weights ? 1 : channel.property == Property::rotation ? 4 : 3;
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
  std::vector<int> rig_node_;  // of each node of the file; -1 = not in the scene
  size_t numbers_ = 0;
};

}  // namespace

void read_animations(const File& file, const std::vector<PlacedNode>& nodes, const std::string& wanted, Rig& rig,
                     Content& content) {
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
  for (RigNode& node : rig.nodes)
    node.moves = node.is_animated || (node.parent >= 0 && rig.nodes[static_cast<size_t>(node.parent)].moves);
}

}  // namespace sideray::scenes::gltf
