// A set of options by name: the texts that were given, and the structs that follow from them. Any thread, one at a time.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bridge/options/option_row.h"

namespace sideray::bridge {

class OptionSet {
 public:
  OptionSet();
  OptionSet(const OptionSet& other);
  OptionSet& operator=(const OptionSet&) = delete;

  // Places are those of option_table(). An empty text gives the default back. Throws Failure.
  void set(size_t place, const std::string& text);
  bool is_set(size_t place) const { return given_[place].has_value(); }
  // The value that counts; lives until the next set().
  const std::string& text(size_t place) const { return texts_[place]; }

  // Why the way of drawing has no use for the option; nullptr where it reads it.
  const char* unread(size_t place) const;
  // Why the option has no effect; nullptr where it may have one.
  const char* idle(size_t place) const;
  // Resets every option without effect in such a scene, given the others, to its default.
  void reduce(const sideray_scene_facts& facts);
  bool operator==(const OptionSet& other) const { return texts_ == other.texts_; }

  sideray_past past() const;
  std::vector<Shortcut> shortcuts(const sideray_scene_facts& facts) const;
  // Throws Failure where given options contradict each other.
  void check() const;

  const OptionValues& values() const { return values_; }
  // Points into this set.
  const sideray_render_options& render() const { return values_.picture; }

 private:
  void resolve();

  std::vector<std::optional<OptionValue>> given_;
  OptionValues values_;
  std::vector<std::string> texts_;
};

}  // namespace sideray::bridge
