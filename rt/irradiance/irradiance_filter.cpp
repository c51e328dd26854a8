#include "rt/irradiance/irradiance_filter.h"

#include "rt/base/half_bits.h"

namespace sideray::rt {
namespace {

constexpr int32_t smooth_steps = 2, light_steps = wall_steps;
constexpr uint32_t rings_of_pixels = 2;  // of cells around its own that a pixel reads

// Returns the number of rows around the written ones that a pass must compute for later passes.
constexpr uint32_t read_after(int32_t pass, int32_t passes, uint32_t read_in_the_end) {
  for (int32_t later = pass + 1; later < passes; ++later) read_in_the_end += 1u << later;
  return read_in_the_end;
}
constexpr uint32_t read_after_pass(int32_t pass) {
  return read_after(pass, light_steps, rings_of_pixels);
}
constexpr uint32_t read_after_smooth(int32_t pass) {
  return read_after(pass, smooth_steps, read_after_pass(-1));
}

}  // namespace

// Calls work(index of the block in the table) for each block of cells in the rows.
template <typename Work>
void IrradianceFilter::for_blocks(CellRows rows, Executor& executor, const Work& work) const {
  executor.run(rows.count(), [&](size_t row, uint32_t) {
    const int32_t first = table_.row(rows.first + row), end = first + static_cast<int32_t>(table_.width());
    for (int32_t at = first; at < end; at += cells_at_once) work(at);
  });
}

void IrradianceFilter::smooth(int32_t number, CellRows rows, const IrradianceKernels& kernels, Executor& executor) {
  for_blocks(rows, executor, [&](int32_t at) { kernels.smooth(table_.columns(), at, number); });
  table_.swap_smooth();
}

void IrradianceFilter::pass(int32_t number, CellRows rows, const IrradianceKernels& kernels, Executor& executor) {
  for_blocks(rows, executor, [&](int32_t at) { kernels.pass(table_.columns(), at, number); });
  table_.swap_light();
}

// Subtracts the control variate, whose light the sky's mask already contains.
void IrradianceFilter::take_mean_sky(const IrradianceCells& cells, CellRows rows, Executor& executor) {
  const CellColumns& c = table_.columns();
  executor.run(rows.count(), [&](size_t index, uint32_t) {
    const size_t row = rows.first + index;
    const CellLight* lights = &cells.lights[row * table_.width()];
    for (int32_t x = 0, at = table_.row(row); x < static_cast<int32_t>(table_.width()); ++x, ++at) {
      const glm::vec3 light = lights[x].light - lights[x].tint * c.open[at];
      for (int k = 0; k < 3; ++k) c.light[k][at] = light[k];
    }
  });
}

void IrradianceFilter::spread(const Input& in, PixelRows rows, TracedScene& scene, IrradianceImage& image) {
  const IrradianceRequest& r = in.request;
  const FrameCamera camera(r.view, r.width, r.height);
  Executor& executor = scene.executor();
  rows_.resize(executor.threads());
  const CellsToSpread from{in.cells, in.walls, table_};
  image.light.resize(size_t{4} * r.width * r.height);
  executor.run(rows.end - rows.first, [&](size_t index, uint32_t worker) {
    const size_t y = rows.first + index;
    PixelRow& row = rows_[worker];
    row.find(camera, from, scene.intersector(), &in.depths[y * r.width], r.width, static_cast<uint32_t>(y));
    for (uint32_t x = 0; x < r.width; ++x) {
      const glm::vec4 light = row.light(x);
      uint16_t* texel = &image.light[4 * (y * r.width + x)];
      // A channel is negative where the one-channel mask of the sky adds too much of it.
      for (int c = 0; c < 3; ++c) texel[c] = signed_half_bits(light[c]);
      texel[3] = half_bits(light.w);
    }
  });
}

void IrradianceFilter::apply(const Input& in, PixelRows rows, TracedScene& scene, IrradianceImage& image) {
  Executor& executor = scene.executor();
  const Intersector& intersector = scene.intersector();
  const IrradianceKernels& kernels = irradiance_kernels(intersector.isa().c_str());
  const bool denoise = in.request.denoise;
  const auto about = [&](uint32_t around) { return in.cells.rows_of(rows, around); };
  const auto look = [&](int32_t number, uint32_t around) {
    // Rows below store the walls toward rows above.
    in.walls.look(number, number >= smooth_steps, about(around + (1u << number)), intersector, executor);
  };
  table_.fill(in.cells, about(read_after_smooth(-1)), executor);
  in.walls.begin(in.cells, table_, executor);
  // The first passes run before the harmonic mean distance is known.
  for (int32_t number = 0; number < smooth_steps; ++number) look(number, read_after_smooth(number));
  for (int32_t number = 0; denoise && number < smooth_steps; ++number)
    smooth(number, about(read_after_smooth(number)), kernels, executor);
  take_mean_sky(in.cells, about(read_after_pass(-1)), executor);
  for (int32_t number = 0; denoise && number < light_steps; ++number) {
    if (number >= smooth_steps) look(number, read_after_pass(number));
    pass(number, about(read_after_pass(number)), kernels, executor);
  }
  spread(in, rows, scene, image);
}

}  // namespace sideray::rt
