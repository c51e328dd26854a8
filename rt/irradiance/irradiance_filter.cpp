#include "rt/irradiance/irradiance_filter.h"

#include "rt/base/half_bits.h"

namespace sideray::rt {
namespace {

constexpr int32_t smooth_steps = 2, light_steps = wall_steps;

}  // namespace

// Calls work(where a block of cells begins in the table) for those of all rows.
template <typename Work>
void IrradianceFilter::for_blocks(Executor& executor, const Work& work) const {
  executor.run(table_.height(), [&](size_t row, uint32_t) {
    const int32_t first = table_.row(row), end = first + static_cast<int32_t>(table_.width());
    for (int32_t at = first; at < end; at += cells_at_once) work(at);
  });
}

void IrradianceFilter::smooth(int32_t number, const IrradianceKernels& kernels, Executor& executor) {
  for_blocks(executor, [&](int32_t at) { kernels.smooth(table_.columns(), at, number); });
  table_.swap_smooth();
}

void IrradianceFilter::pass(int32_t number, const IrradianceKernels& kernels, Executor& executor) {
  for_blocks(executor, [&](int32_t at) { kernels.pass(table_.columns(), at, number); });
  table_.swap_light();
}

// Takes the control variate off: what the mask of the sky says already.
void IrradianceFilter::take_mean_sky(const IrradianceCells& cells, Executor& executor) {
  const CellColumns& c = table_.columns();
  executor.run(table_.height(), [&](size_t row, uint32_t) {
    const CellLight* lights = &cells.lights[row * table_.width()];
    for (int32_t x = 0, at = table_.row(row); x < static_cast<int32_t>(table_.width()); ++x, ++at) {
      const glm::vec3 light = lights[x].light - lights[x].tint * c.open[at];
      for (int k = 0; k < 3; ++k) c.light[k][at] = light[k];
    }
  });
}

void IrradianceFilter::spread(const IrradianceRequest& r, const IrradianceCells& cells, const std::vector<float>& depths,
                              TracedScene& scene, IrradianceImage& image) {
  const FrameCamera camera(r.view, r.width, r.height);
  Executor& executor = scene.executor();
  rows_.resize(executor.threads());
  const CellsToSpread from{cells, walls_, table_};
  image.light.resize(size_t{4} * r.width * r.height);
  executor.run(r.height, [&](size_t y, uint32_t worker) {
    PixelRow& row = rows_[worker];
    row.find(camera, from, scene.intersector(), &depths[y * r.width], r.width, static_cast<uint32_t>(y));
    for (uint32_t x = 0; x < r.width; ++x) {
      const glm::vec4 light = row.light(x);
      uint16_t* texel = &image.light[4 * (y * r.width + x)];
      // A channel is negative where the mask of the sky, which has one, says too much.
      for (int c = 0; c < 3; ++c) texel[c] = signed_half_bits(light[c]);
      texel[3] = half_bits(light.w);
    }
  });
}

void IrradianceFilter::apply(const IrradianceRequest& r, const IrradianceCells& cells, const std::vector<float>& depths,
                             TracedScene& scene, IrradianceImage& image) {
  Executor& executor = scene.executor();
  const Intersector& intersector = scene.intersector();
  const IrradianceKernels& kernels = irradiance_kernels(intersector.isa().c_str());
  table_.fill(cells, executor);
  walls_.begin(cells, table_, executor);
  // The first steps come before the harmonic mean distance is known.
  for (int32_t number = 0; number < smooth_steps; ++number) walls_.look(number, false, intersector, executor);
  for (int32_t number = 0; r.denoise && number < smooth_steps; ++number) smooth(number, kernels, executor);
  take_mean_sky(cells, executor);
  for (int32_t number = 0; r.denoise && number < light_steps; ++number) {
    if (number >= smooth_steps) walls_.look(number, true, intersector, executor);
    pass(number, kernels, executor);
  }
  spread(r, cells, depths, scene, image);
}

}  // namespace sideray::rt
