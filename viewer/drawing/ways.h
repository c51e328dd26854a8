// The ways of drawing that are held against each other, as options of pictures. Any thread.
#pragma once

#include <array>
#include <sideray/sideray.hpp>
#include <string>

namespace sideray::viewer {

enum class Way : uint8_t { chosen, raster, hybrid, raytraced, reference };
constexpr std::array<const char*, 5> way_names{"as set", "raster", "hybrid", "ray traced", "reference"};
constexpr size_t way_count = way_names.size();
inline const char* name_of(Way way) { return way_names[static_cast<size_t>(way)]; }

// Of each position of a reference that the window refines: few, so that the first one is soon there.
constexpr uint32_t reference_light_samples = 1;
// Positions after which a reference is left as it is: so many samples has each pixel then.
constexpr uint32_t reference_positions = 1024;
// Positions after which a view that stands still is `--samples 64` of the program.
constexpr uint32_t still_positions = 64;
inline uint32_t positions_of(Way way) { return way == Way::reference ? reference_positions : still_positions; }

// `base` are the options of the panel. Those that contradict the way, or that it decides, are left out.
Options options_of(Way way, const Options& base);

// Whether only the rasterizer can draw it.
bool needs_rasterizer(const Options& options);

// Options that the window decides itself.
bool is_decided_by_window(const std::string& name);

}  // namespace sideray::viewer
