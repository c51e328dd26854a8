// Holds a set of options by name: the given texts, and the structs that follow from them. Any thread, one at a time.
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

  // Sets an option by its place in option_table(). An empty text restores the default. Throws Failure.
  void set(size_t place, const std::string& text);
  bool is_set(size_t place) const { return given_[place].has_value(); }
  // Returns the value in effect; valid until the next set().
  const std::string& text(size_t place) const { return texts_[place]; }

  // Returns why the current way of drawing does not read the option; nullptr where it does.
  const char* unread(size_t place) const;
  // Returns why the option has no effect; nullptr where it may have one.
  const char* idle(size_t place) const;
  // Resets every option that has no effect in such a scene, given the others, to its default.
  void reduce(const sideray_scene_facts& facts);
  bool operator==(const OptionSet& other) const { return texts_ == other.texts_; }

  sideray_past past() const;
  std::vector<Shortcut> shortcuts(const sideray_scene_facts& facts) const;
  // Throws Failure where given options contradict each other.
  void check() const;

  const OptionValues& values() const { return values_; }
  // Returns structs that point into this set.
  const sideray_render_options& render() const { return values_.picture; }

 private:
  void resolve();

  std::vector<std::optional<OptionValue>> given_;
  OptionValues values_;
  std::vector<std::string> texts_;
};

}  // namespace sideray::bridge
