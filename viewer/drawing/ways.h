// The ways of drawing that the window compares, as options of pictures. Any thread.
#pragma once

#include <array>
#include <sideray/sideray.hpp>
#include <string>

namespace sideray::viewer {

enum class Way : uint8_t { chosen, raster, hybrid, raytraced, reference };
constexpr std::array<const char*, 5> way_names{"as set", "raster", "hybrid", "ray traced", "reference"};
constexpr size_t way_count = way_names.size();
inline const char* name_of(Way way) { return way_names[static_cast<size_t>(way)]; }

// Light samples of each position of a reference that the window refines: few, so that the first picture is ready soon.
constexpr uint32_t reference_light_samples = 1;
// Positions after which a reference is complete; each pixel then has as many samples.
constexpr uint32_t reference_positions = 1024;
// Positions after which a view at rest equals the program's `--samples 64`.
constexpr uint32_t still_positions = 64;
inline uint32_t positions_of(Way way) { return way == Way::reference ? reference_positions : still_positions; }

// Returns the options of a way. `base`: the panel's options; options that the way contradicts or decides are left out.
Options options_of(Way way, const Options& base);

// Returns whether only the rasterizer can draw with these options.
bool needs_rasterizer(const Options& options);

// Returns whether the window itself decides an option.
bool is_decided_by_window(const std::string& name);

}  // namespace sideray::viewer
