// sideray_option_*, sideray_options_*: the options of pictures by name.
#include <sideray/options.h>

#include "bridge/api/border.h"
#include "bridge/options/option_set.h"
#include "bridge/options/removed_options.h"

using sideray::bridge::guarded;
using sideray::bridge::option_place;
using sideray::bridge::option_table;
using sideray::bridge::require;

struct sideray_options {
  sideray::bridge::OptionSet set;
};

// Holds what the public interface points at; the texts are in `described`.
struct sideray_shortcuts {
  std::vector<sideray::bridge::Shortcut> described;
  std::vector<sideray_shortcut> list;
};

namespace sideray::bridge {

// Fills the caller's struct; facts that an older caller's struct lacks count as absent.
void init_facts(sideray_scene_facts* out, size_t size) {
  init_struct(out, size, sideray_scene_facts{});
}

}  // namespace sideray::bridge

namespace {

// Returns the place of an option; none where there is no option of that name.
std::optional<size_t> find(const char* name) {
  const size_t place = name ? option_place(name) : option_table().size();
  return place < option_table().size() ? std::optional(place) : std::nullopt;
}

}  // namespace

size_t sideray_option_count(void) {
  return option_table().size();
}

const sideray_option* sideray_option_at(size_t index) {
  return index < option_table().size() ? &option_table()[index].option : nullptr;
}

const sideray_option* sideray_option_find(const char* name) {
  const std::optional<size_t> place = find(name);
  return place ? &option_table()[*place].option : nullptr;
}

const char* sideray_option_read_as(const char* name, const char* value) {
  return name ? sideray::bridge::read_as(name, value ? value : "") : nullptr;
}

const char* sideray_option_removed(const char* name, const char* value) {
  if (!name) return nullptr;
  return value ? sideray::bridge::removed_value(name, value) : sideray::bridge::removed_option(name);
}

sideray_status sideray_options_create(sideray_options** options, sideray_error* error) {
  return guarded(error, [&] {
    require(options, "options result");
    *options = new sideray_options;
  });
}

sideray_status sideray_options_copy(const sideray_options* options, sideray_options** copy, sideray_error* error) {
  return guarded(error, [&] {
    require(options, "options");
    require(copy, "copy result");
    *copy = new sideray_options{options->set};
  });
}

void sideray_options_release(sideray_options* options) {
  delete options;
}

sideray_status sideray_options_set(sideray_options* options, const char* name, const char* value,
                                   sideray_error* error) {
  return guarded(error, [&] {
    require(options, "options");
    require(name, "option name");
    const char* now = sideray_option_read_as(name, value);
    if (now && !*now) return;
    const std::optional<size_t> place = find(name);
    if (!place) {
      const char* instead = sideray_option_removed(name, nullptr);
      if (instead) sideray::fail(SIDERAY_INVALID_ARGUMENT, "{}: is gone since 0.3; {}", name, instead);
      sideray::fail(SIDERAY_INVALID_ARGUMENT, "{}: no such option; sideray_option_at lists all", name);
    }
    options->set.set(*place, now ? now : value ? value : "");
  });
}

const char* sideray_options_get(const sideray_options* options, const char* name) {
  const std::optional<size_t> place = find(name);
  return place ? options->set.text(*place).c_str() : nullptr;
}

int32_t sideray_options_is_set(const sideray_options* options, const char* name) {
  const std::optional<size_t> place = find(name);
  return place && options->set.is_set(*place);
}

int32_t sideray_options_reads(const sideray_options* options, const char* name) {
  const std::optional<size_t> place = find(name);
  return place && !options->set.unread(*place);
}

int32_t sideray_options_applies(const sideray_options* options, const char* name, const char** reason) {
  const std::optional<size_t> place = find(name);
  const char* idle = place ? options->set.idle(*place) : "no such option";
  if (reason) *reason = idle ? idle : option_table()[*place].option.applies;
  return !idle;
}

sideray_status sideray_options_reduce(sideray_options* options, const sideray_scene_facts* facts,
                                      sideray_error* error) {
  return guarded(error, [&] {
    require(options, "options");
    options->set.reduce(sideray::bridge::read_struct(facts, "scene facts", sideray::bridge::init_facts));
  });
}

int32_t sideray_options_equal(const sideray_options* a, const sideray_options* b) {
  return a->set == b->set;
}

sideray_past sideray_options_past(const sideray_options* options) {
  return options->set.past();
}

sideray_status sideray_options_check(const sideray_options* options, sideray_error* error) {
  return guarded(error, [&] {
    require(options, "options");
    options->set.check();
  });
}

sideray_status sideray_shortcuts_create(const sideray_options* options, const sideray_scene_facts* facts,
                                        sideray_shortcuts** shortcuts, sideray_error* error) {
  return guarded(error, [&] {
    require(options, "options");
    require(shortcuts, "shortcuts result");
    auto made = std::make_unique<sideray_shortcuts>();
    made->described =
        options->set.shortcuts(sideray::bridge::read_struct(facts, "scene facts", sideray::bridge::init_facts));
    for (const sideray::bridge::Shortcut& s : made->described)
      made->list.push_back(
          {s.name.c_str(), s.taken, s.text.c_str(), s.exactly.data(), s.exactly.size(), s.is_random});
    *shortcuts = made.release();
  });
}

size_t sideray_shortcuts_count(const sideray_shortcuts* shortcuts) {
  return shortcuts->list.size();
}

const sideray_shortcut* sideray_shortcuts_at(const sideray_shortcuts* shortcuts, size_t index) {
  return index < shortcuts->list.size() ? &shortcuts->list[index] : nullptr;
}

void sideray_shortcuts_release(sideray_shortcuts* shortcuts) {
  delete shortcuts;
}

const sideray_render_options* sideray_options_render(const sideray_options* options) {
  return &options->set.render();
}
