// Keeps a snapshot's surfaces on the GPU: vertex arrays, materials, instances grouped into draws. The context must be
// current.
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "gl/context/functions.h"
#include "gl/resources/objects.h"
#include "gl/resources/raster_programs.h"
#include "gl/resources/raster_textures.h"
#include "gl/scene/gathered_meshes.h"
#include "model/snapshot.h"

namespace sideray::gl {

// Holds the instances that one call draws: same mesh, material, winding and wind, consecutive in the instance buffer.
struct Draw {
  uint32_t mesh = 0, material = 0;  // indices into the snapshot
  uint32_t first_instance = 0, instance_count = 0;
  bool mirrored = false, casts_shadow = false;
  uint32_t surface_id = 0, visibility = 0;  // only for single instances
  model::Bounds bounds;
  uint32_t wind = 0;      // index + 1 into the snapshot's winds, 0 = no wind
  uint32_t instance = 0;  // only for single instances: index into the snapshot
};

// Returns the lobes (lobe::*) that a material has.
uint32_t lobes_of(const sideray_material_desc& material);

class RasterScene {
 public:
  explicit RasterScene(const Functions& gl);

  // Keeps meshes and textures that the last snapshot had too, and the buffers of meshes where only vertices changed;
  // keeps everything where only time, lights or the environment changed.
  void set_snapshot(std::shared_ptr<const model::Snapshot> snapshot);
  bool kept_surfaces() const { return kept_surfaces_; }  // whether the last set_snapshot kept everything
  bool empty() const { return !snapshot_; }              // before the first snapshot, or after one that failed
  const model::Snapshot& snapshot() const { return *snapshot_; }
  const model::Material& material(const Draw& draw) const { return snapshot_->materials[draw.material]; }

  const std::vector<Draw>& opaque() const { return opaque_; }            // OPAQUE and MASK, in drawing order
  const std::vector<Draw>& translucent() const { return translucent_; }  // one instance each, in snapshot order

  const std::vector<Draw>& thin() const { return thin_; }                // lines and points, one instance each

  // Returns the shading variant that draws a material in its pass.
  Shading shading(const Draw& draw) const {
    Shading shading = material_shadings_[draw.material];
    shading.wind = draw.wind != 0;
    return shading;
  }
  // Sets the wind uniforms of the draw for a program with wind, which must be in use.
  void set_wind(const Program& program, const Draw& draw) const;
  uint32_t opaque_lobes() const { return opaque_lobes_; }  // lobes that some opaque surface has
  // Returns whether some texture is not drawn, because the driver has too few texture units.
  bool leaves_textures_out() const { return leaves_textures_out_; }
  // Binds the material block and the textures of a map set, unless they are bound already. A pass must start with
  // forget_bindings, since others use the same units.
  void bind_material(uint32_t material, uint32_t maps);
  void forget_bindings() { bound_material_ = no_material; }
  void draw(const Draw& draw) { draw_range(draw, draw.first_instance, draw.instance_count); }
  // Draws only the instances whose bounds `keep` accepts, in the same order. `may_keep` gets bounds around several
  // instances, and may refuse them only where `keep` accepts none of these.
  template <typename MayKeep, typename Keep>
  void draw_where(const Draw& draw, const MayKeep& may_keep, const Keep& keep) {
    draw_places(
        draw, [&](uint32_t block) { return may_keep(block_bounds_[block]); },
        [&](uint32_t place) { return keep(instance_bounds_[place]); });
  }
  // Does the same by place in the instance buffer: calls `keep` with a place, first_instance on, and `may_keep` with
  // the number of a block, whose first place is that number times places_in_block.
  template <typename MayKeep, typename Keep>
  void draw_places(const Draw& draw, const MayKeep& may_keep, const Keep& keep) {
    const uint32_t end = draw.first_instance + draw.instance_count;
    uint32_t run = end;  // where the run begins; `end` = no run
    const auto draw_run = [&](uint32_t run_end) {
      if (run < run_end) draw_range(draw, run, run_end - run);
      run = end;
    };
    for (uint32_t i = draw.first_instance; i < end;) {
      const uint32_t block_end = (i / block_size + 1) * block_size;
      if (i % block_size == 0 && block_end <= end && !may_keep(i / block_size)) {
        draw_run(i);
        i = block_end;
        continue;
      }
      for (; i < std::min(block_end, end); ++i) {
        if (!keep(i))
          draw_run(i);
        else if (run == end)
          run = i;
      }
    }
    draw_run(end);
  }
  void draw_place(const Draw& draw, uint32_t place) { draw_range(draw, place, 1); }
  // Sets the positions of the frame before as attribute 15 of the draw's mesh, until forget_positions_before. They come
  // from `before`, which has the same triangles.
  void set_positions_before(const Draw& draw, const model::Mesh& before);
  void forget_positions_before(const Draw& draw);
  // While on, draws of meshes that can be drawn together wait for draw_gathered(), which draws them with the program
  // then in use. That program must read only positions of vertices, without wind.
  void gather_draws(bool on) { gathers_ = on; }
  void draw_gathered() { gathered_.draw(); }
  const model::Bounds& bounds_at(uint32_t place) const { return instance_bounds_[place]; }
  static constexpr uint32_t places_in_block = 64;
  const model::Bounds& bounds_of_block(uint32_t block) const { return block_bounds_[block]; }
  uint32_t instance_at(uint32_t place) const { return instance_order_[place]; }  // its index in the snapshot
  std::span<const uint32_t> instance_order() const { return instance_order_; }
  std::shared_ptr<const model::Snapshot> shared_snapshot() const { return snapshot_; }
  // Returns bounds around every instance, opaque or translucent, and the centres of lit sprites that a view may show.
  model::Bounds seen_bounds(const glm::mat4& clip_from_local) const;

  RasterTextures& textures() { return textures_; }

 private:
  static constexpr uint32_t no_material = 0xffffffffu;
  static constexpr uint32_t block_size = places_in_block;
  struct MeshBuffers {
    std::shared_ptr<const model::Mesh> source;
    Buffer positions, attributes, indices;
    VertexArray vertex_array;
    uint32_t instance_offset = 0xffffffffu;  // the offset that the vertex array has now
  };
  MeshBuffers upload(const std::shared_ptr<const model::Mesh>& mesh) const;
  MeshBuffers with_vertices(MeshBuffers buffers, const std::shared_ptr<const model::Mesh>& mesh) const;
  void upload_surfaces();
  void set_meshes();
  void set_materials();
  void set_shadings();
  void set_instances();
  void set_gathered();
  std::vector<uint32_t> group(const std::vector<uint32_t>& opaque);
  void draw_range(const Draw& draw, uint32_t first_instance, uint32_t count);
  void point_at_instance(MeshBuffers& mesh, uint32_t first_instance) const;

  const Functions& gl_;
  RasterTextures textures_;
  std::shared_ptr<const model::Snapshot> snapshot_;
  std::map<const model::Mesh*, MeshBuffers> meshes_;
  std::vector<MeshBuffers*> mesh_at_;  // by snapshot index
  model::Names mesh_names_;            // names of the meshes in mesh_at_
  std::vector<Shading> material_shadings_;
  uint32_t opaque_lobes_ = 0;
  bool leaves_textures_out_ = false, kept_surfaces_ = false;
  Buffer materials_, instances_, positions_before_;
  GatheredMeshes gathered_;  // of meshes that cast shadows, have no holes and no wind
  bool gathers_ = false;
  uint32_t material_stride_bytes_ = 0;
  uint32_t bound_material_ = no_material, bound_maps_ = 0;
  std::vector<Draw> opaque_, translucent_, thin_;
  std::vector<model::Bounds> instance_bounds_;  // in the order of the instance buffer
  std::vector<uint32_t> instance_order_;        // indices into the snapshot's instances
  std::vector<model::Bounds> block_bounds_;     // bounds around each block_size of them
};

}  // namespace sideray::gl
