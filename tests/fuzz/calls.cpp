#include <atomic>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <map>
#include <new>
#include <optional>
#include <set>
#include <sideray/sideray.hpp>
#include <string>
#include <thread>
#include <vector>

#include "fuzz/fuzz.h"
#include "fuzz/random.h"

// Makes random valid and invalid calls of the C interface of scenes, with failing allocations, and compares results
// with a model: `fuzz_calls SEED COUNT` runs COUNT sequences of up to 64 calls. A failed call must change nothing, so
// the model ignores it.
namespace {

// Allocations of this thread until one fails; below 0 none does.
thread_local long until_failure = -1;
thread_local bool has_failed = false;

void* allocate(size_t size) {
  if (until_failure >= 0 && until_failure-- == 0) {
    has_failed = true;
    throw std::bad_alloc();
  }
  if (void* memory = std::malloc(size == 0 ? 1 : size)) return memory;
  throw std::bad_alloc();
}

}  // namespace

void* operator new(size_t size) { return allocate(size); }
void* operator new[](size_t size) { return allocate(size); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, size_t) noexcept { std::free(memory); }

namespace {

using namespace sideray;

struct Mesh {
  double low[3], high[3];
  bool has_triangles;
  int users = 0;
};
struct Material {
  std::set<uint32_t> textures;
  bool translucent = false;
  int users = 0;
};
struct Instance {
  uint32_t mesh, material, surface_id, visibility;
  double transform[12];
};

// Models the scene as far as results depend on it.
struct Model {
  std::map<uint32_t, Mesh> meshes;
  std::map<uint32_t, int> textures;  // users
  std::map<uint32_t, Material> materials;
  std::map<uint32_t, Instance> instances;
  uint32_t winds = 0;
  std::vector<uint32_t> particles;
  std::optional<std::map<uint32_t, Instance>> committed;
  std::map<uint32_t, Mesh> committed_meshes;
};

class Sequence {
 public:
  explicit Sequence(uint64_t seed) : random_(seed) {
    if (sideray_scene_create(&scene_, &error_) != SIDERAY_OK) fuzz::broken("a scene is made", error_.message);
  }
  Sequence(const Sequence&) = delete;
  Sequence& operator=(const Sequence&) = delete;
  ~Sequence() { sideray_scene_release(scene_); }

  uint64_t run() {
    const uint32_t calls = 1 + random_.below(64);
    std::optional<std::thread> reader;
    std::atomic<bool> stop = false;
    // The committed state may be queried while the scene is edited.
    if (random_.one_in(64)) reader.emplace([&] { read_bounds(stop); });
    for (uint32_t i = 0; i < calls; ++i) call();
    stop = true;
    if (reader) reader->join();
    return calls;
  }

 private:
  using Call = void (Sequence::*)();

  void read_bounds(const std::atomic<bool>& stop) const {
    sideray_scene_retain(scene_);
    while (!stop) {
      double low[3], high[3];
      sideray_error error{};
      const sideray_status status = sideray_scene_bounds(scene_, low, high, &error);
      if (status != SIDERAY_OK && status != SIDERAY_NOT_READY)
        fuzz::broken("bounds can be read meanwhile", error.message);
    }
    sideray_scene_release(scene_);
  }

  void call() {
    using S = Sequence;
    static constexpr Call calls[] = {
        &S::add_mesh,         &S::add_mesh,         &S::replace_mesh,    &S::remove_mesh,       &S::set_vertices,
        &S::add_texture,      &S::replace_texture,  &S::remove_texture,  &S::add_material,      &S::add_material,
        &S::replace_material, &S::remove_material,  &S::add_instances,   &S::add_instances,     &S::add_instances,
        &S::remove_instances, &S::move_instances,   &S::renumber,        &S::replace_instances, &S::set_visibility,
        &S::add_wind,         &S::set_time,         &S::add_particles,   &S::set_sprites,       &S::set_lights,
        &S::set_environment,  &S::commit,           &S::commit,          &S::bounds};
    (this->*random_.of(calls))();
  }

  // Makes the call, sometimes with a failing allocation. `valid` is the model's answer. Returns whether it succeeded.
  template <typename Function>
  bool make(const char* name, bool valid, const Function& function) {
    error_.message[0] = '\0';
    has_failed = false;
    until_failure = random_.one_in(4) ? static_cast<long>(random_.below(12)) : -1;
    const sideray_status status = function();
    until_failure = -1;
    if (status != SIDERAY_OK) check_error(name, status);
    if (has_failed && status == SIDERAY_OUT_OF_MEMORY) return false;
    if (status == SIDERAY_OUT_OF_MEMORY) fuzz::broken("memory is only said to lack where it does", name);
    if (valid != (status == SIDERAY_OK))
      fuzz::broken(std::string(name) + (valid ? " is taken" : " is refused"), valid ? error_.message : "it was taken");
    return status == SIDERAY_OK;
  }

  void check_error(const char* name, sideray_status status) {
    if (error_.status != status) fuzz::broken("the error holds the status", name);
    fuzz::check_line(error_.message);
  }

  // Returns an existing handle, sometimes an invalid one.
  template <typename Map>
  uint32_t name_of(const Map& map) {
    if (map.empty() || random_.one_in(10)) return random_.pick<uint32_t>({0, 1, 7, 1000, 0xffffffffu});
    return std::next(map.begin(), random_.below(static_cast<uint32_t>(map.size())))->first;
  }

  template <typename Map>
  void check_new(const char* what, const Map& map, uint32_t name) {
    if (name == 0 || map.contains(name))
      fuzz::broken("a new name is no other's", std::string(what) + std::to_string(name));
  }

  float odd_float() {
    constexpr float infinity = std::numeric_limits<float>::infinity();
    return random_.pick({std::numeric_limits<float>::quiet_NaN(), infinity, -1.0f, 1e30f, -1e30f});
  }

  // Positions of one or two triangles; a third of the descriptions are broken.
  struct MeshDesc {
    sideray_mesh_desc desc = sideray_mesh_defaults();
    float positions[18];
    uint32_t indices[6];
    bool valid = true;
    Mesh mesh{};
  };
  void describe_mesh(MeshDesc& d) {
    const uint32_t triangles = 1 + random_.below(2);
    d.desc.vertex_count = 3 * triangles;
    for (uint32_t i = 0; i < 9 * triangles; ++i) d.positions[i] = static_cast<float>(random_.between(-10, 10));
    for (uint32_t i = 0; i < 3 * triangles; ++i) d.indices[i] = i;
    d.desc.positions.data = d.positions;
    if (random_.one_in(2)) d.desc.indices = d.indices, d.desc.index_count = 3 * triangles;
    d.mesh.has_triangles = true;
    for (int c = 0; c < 3; ++c) {
      d.mesh.low[c] = INFINITY, d.mesh.high[c] = -INFINITY;
      for (uint32_t v = 0; v < d.desc.vertex_count; ++v) {
        d.mesh.low[c] = std::min(d.mesh.low[c], double{d.positions[3 * v + static_cast<uint32_t>(c)]});
        d.mesh.high[c] = std::max(d.mesh.high[c], double{d.positions[3 * v + static_cast<uint32_t>(c)]});
      }
    }
    if (!random_.one_in(3)) return;
    d.valid = false;
    switch (random_.below(6)) {
      case 0:
        d.desc.vertex_count = 0;
        break;
      case 1:
        d.desc.positions.data = nullptr;
        break;
      case 2:
        d.desc.size = random_.pick<size_t>({0, 1, 100000});
        break;
      case 3:
        d.desc.indices = d.indices, d.desc.index_count = 3, d.indices[1] = d.desc.vertex_count;
        break;
      case 4:
        d.desc.indices = d.indices, d.desc.index_count = 2;
        break;
      default:
        d.desc.positions.stride_bytes = random_.pick<size_t>({1, 5, 11});
    }
  }

  void add_mesh() {
    MeshDesc d;
    describe_mesh(d);
    uint32_t name = 0;
    if (!make("add_mesh", d.valid, [&] { return sideray_scene_add_mesh(scene_, &d.desc, &name, nullptr, &error_); }))
      return;
    check_new("mesh ", model_.meshes, name);
    model_.meshes[name] = d.mesh;
  }
  void replace_mesh() {
    MeshDesc d;
    describe_mesh(d);
    const uint32_t name = name_of(model_.meshes);
    const auto found = model_.meshes.find(name);
    const bool valid = d.valid && found != model_.meshes.end();
    const auto replace = [&] { return sideray_scene_replace_mesh(scene_, name, &d.desc, nullptr, &error_); };
    if (!make("replace_mesh", valid, replace)) return;
    const int users = found->second.users;
    found->second = d.mesh;
    found->second.users = users;
  }
  void remove_mesh() {
    const uint32_t name = name_of(model_.meshes);
    const auto found = model_.meshes.find(name);
    const bool valid = found != model_.meshes.end() && found->second.users == 0;
    if (make("remove_mesh", valid, [&] { return sideray_scene_remove_mesh(scene_, name, &error_); }))
      model_.meshes.erase(found);
  }
  // Sets vertices; a count that differs from the mesh's is refused.
  void set_vertices() {
    MeshDesc d;
    describe_mesh(d);
    d.desc.vertex_count = 9;
    const uint32_t name = name_of(model_.meshes);
    make("set_vertices", false, [&] { return sideray_scene_set_vertices(scene_, name, &d.desc, &error_); });
  }

  void add_texture() {
    const uint8_t texels[16] = {};
    const bool valid = !random_.one_in(4);
    const uint32_t side = valid ? 1 + random_.below(2) : random_.pick<uint32_t>({0, 0x80000000u, 100000});
    uint32_t name = 0;
    const auto add = [&] {
      return sideray_scene_add_texture(scene_, side, side, SIDERAY_RGBA8, texels, &name, &error_);
    };
    if (!make("add_texture", valid, add)) return;
    check_new("texture ", model_.textures, name);
    model_.textures[name] = 0;
  }
  void replace_texture() {
    const uint8_t texels[16] = {};
    const uint32_t name = name_of(model_.textures);
    const bool has_texels = !random_.one_in(4);
    make("replace_texture", has_texels && model_.textures.contains(name), [&] {
      const uint8_t* given = has_texels ? texels : nullptr;
      return sideray_scene_replace_texture(scene_, name, 2, 2, SIDERAY_RGBA8_SRGB, given, &error_);
    });
  }
  void remove_texture() {
    const uint32_t name = name_of(model_.textures);
    const auto found = model_.textures.find(name);
    const bool valid = found != model_.textures.end() && found->second == 0;
    if (make("remove_texture", valid, [&] { return sideray_scene_remove_texture(scene_, name, &error_); }))
      model_.textures.erase(found);
  }

  struct MaterialDesc {
    sideray_material_desc desc = sideray_material_defaults();
    bool valid = true;
    Material material;
    std::vector<uint32_t> uses;
  };
  void describe_material(MaterialDesc& d) {
    if (random_.one_in(3)) d.desc.alpha_mode = SIDERAY_BLEND, d.material.translucent = true;
    if (random_.one_in(4)) d.desc.transmission = 0.5f, d.material.translucent = true;
    for (sideray_texture_slot* slot : {&d.desc.base_color_texture, &d.desc.normal_texture, &d.desc.thickness_texture}) {
      if (!random_.one_in(3)) continue;
      slot->texture = name_of(model_.textures);
      if (slot->texture == 0) continue;
      d.valid = d.valid && model_.textures.contains(slot->texture);
      d.uses.push_back(slot->texture);
    }
    if (!random_.one_in(4)) return;
    d.valid = false;
    switch (random_.below(5)) {
      case 0:
        d.desc.roughness = odd_float();
        break;
      case 1:
        d.desc.ior = 0.5f;
        break;
      case 2:
        d.desc.base_color[1] = std::numeric_limits<float>::quiet_NaN();
        break;
      case 3:
        d.desc.anisotropy = 1.5f;
        break;
      default:
        d.desc.size = 3;
    }
  }
  void count_textures(const std::vector<uint32_t>& uses, int change) {
    for (const uint32_t texture : uses) model_.textures[texture] += change;
  }
  void add_material() {
    MaterialDesc d;
    describe_material(d);
    uint32_t name = 0;
    if (!make("add_material", d.valid, [&] { return sideray_scene_add_material(scene_, &d.desc, &name, &error_); }))
      return;
    check_new("material ", model_.materials, name);
    model_.materials[name] = d.material;
    uses_[name] = d.uses;
    count_textures(d.uses, 1);
  }
  void replace_material() {
    MaterialDesc d;
    describe_material(d);
    const uint32_t name = name_of(model_.materials);
    const auto found = model_.materials.find(name);
    const bool valid = d.valid && found != model_.materials.end();
    const auto replace = [&] { return sideray_scene_replace_material(scene_, name, &d.desc, &error_); };
    if (!make("replace_material", valid, replace)) return;
    count_textures(uses_[name], -1);
    uses_[name] = d.uses;
    count_textures(d.uses, 1);
    found->second.translucent = d.material.translucent;
  }
  void remove_material() {
    const uint32_t name = name_of(model_.materials);
    const auto found = model_.materials.find(name);
    const bool valid = found != model_.materials.end() && found->second.users == 0;
    if (!make("remove_material", valid, [&] { return sideray_scene_remove_material(scene_, name, &error_); })) return;
    count_textures(uses_[name], -1);
    model_.materials.erase(found);
  }

  sideray_instance_desc describe_instance(bool& valid) {
    sideray_instance_desc desc{};
    desc.mesh = name_of(model_.meshes), desc.material = name_of(model_.materials);
    valid = valid && model_.meshes.contains(desc.mesh) && model_.materials.contains(desc.material);
    for (int i = 0; i < 3; ++i) desc.world_from_object[4 * i] = random_.pick({1.0, -2.0, 0.5});
    for (int i = 9; i < 12; ++i) desc.world_from_object[i] = random_.between(-100, 100);
    desc.surface_id = next_id_++;
    if (random_.one_in(9)) desc.surface_id = 1 + random_.below(4);
    desc.visibility = random_.below(16);
    if (random_.one_in(5)) {
      desc.wind = 1 + random_.below(3), desc.wind_phase = 0.5f;
      valid = valid && desc.wind <= model_.winds;
    }
    if (random_.one_in(9)) {
      valid = false;
      using Double = std::numeric_limits<double>;
      desc.world_from_object[random_.below(12)] = random_.pick({Double::quiet_NaN(), 1e300, -Double::infinity()});
    }
    return desc;
  }
  void add_instances() {
    bool valid = true;
    std::vector<sideray_instance_desc> descs(random_.below(4));
    for (sideray_instance_desc& desc : descs) desc = describe_instance(valid);
    uint32_t names[4] = {};
    const auto add = [&] {
      return sideray_scene_add_instances(scene_, descs.data(), sizeof(sideray_instance_desc), descs.size(), names,
                                         &error_);
    };
    if (!make("add_instances", valid, add)) return;
    for (size_t i = 0; i < descs.size(); ++i) {
      check_new("instance ", model_.instances, names[i]);
      put(names[i], descs[i]);
    }
  }
  void put(uint32_t name, const sideray_instance_desc& desc) {
    Instance& instance = model_.instances[name];
    instance = {desc.mesh, desc.material, desc.surface_id, desc.visibility, {}};
    std::copy_n(desc.world_from_object, 12, instance.transform);
    ++model_.meshes[desc.mesh].users, ++model_.materials[desc.material].users;
    is_moving_[name] = desc.wind != 0;
  }
  void take(uint32_t name) {
    const Instance& instance = model_.instances[name];
    --model_.meshes[instance.mesh].users, --model_.materials[instance.material].users;
    model_.instances.erase(name);
  }
  void replace_instances() {
    const uint32_t name = name_of(model_.instances);
    bool valid = model_.instances.contains(name);
    const sideray_instance_desc desc = describe_instance(valid);
    if (!make("replace_instances", valid, [&] {
          return sideray_scene_replace_instances(scene_, &name, &desc, sizeof(desc), 1, &error_);
        }))
      return;
    take(name);
    put(name, desc);
  }
  void remove_instances() {
    uint32_t names[2] = {name_of(model_.instances), name_of(model_.instances)};
    const uint32_t count = 1 + random_.below(2);
    bool valid = model_.instances.contains(names[0]);
    if (count == 2) valid = valid && model_.instances.contains(names[1]) && names[0] != names[1];
    const auto remove = [&] { return sideray_scene_remove_instances(scene_, names, count, &error_); };
    if (!make("remove_instances", valid, remove)) return;
    for (uint32_t i = 0; i < count; ++i) take(names[i]);
  }
  void move_instances() {
    const uint32_t name = name_of(model_.instances);
    double to[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, random_.between(-50, 50), 3, 4};
    const bool broken = random_.one_in(4);
    if (broken) to[random_.below(12)] = std::numeric_limits<double>::quiet_NaN();
    const auto move = [&] { return sideray_scene_move_instances(scene_, &name, 1, to, &error_); };
    if (make("move_instances", !broken && model_.instances.contains(name), move))
      std::copy_n(to, 12, model_.instances[name].transform);
  }
  void renumber() {
    const uint32_t name = name_of(model_.instances), id = next_id_++;
    const auto renumber = [&] { return sideray_scene_renumber_instances(scene_, &name, 1, &id, &error_); };
    if (make("renumber", model_.instances.contains(name), renumber))
      model_.instances[name].surface_id = id;
  }
  void set_visibility() {
    const uint32_t name = name_of(model_.instances), visibility = random_.below(16);
    const auto set = [&] { return sideray_scene_set_visibility(scene_, name, visibility, &error_); };
    if (make("set_visibility", model_.instances.contains(name), set))
      model_.instances[name].visibility = visibility;
  }

  void add_wind() {
    sideray_wind_desc desc = sideray_wind_defaults();
    const bool broken = random_.one_in(3);
    if (broken) desc.height = random_.pick({0.0f, -1.0f, std::numeric_limits<float>::quiet_NaN()});
    uint32_t name = 0;
    if (make("add_wind", !broken, [&] { return sideray_scene_add_wind(scene_, &desc, &name, &error_); })) {
      if (name != ++model_.winds) fuzz::broken("winds are counted from 1", std::to_string(name));
    }
  }
  void set_time() {
    const bool broken = random_.one_in(4);
    const double time = broken ? static_cast<double>(std::numeric_limits<float>::quiet_NaN()) : random_.between(0, 9);
    make("set_time", !broken, [&] { return sideray_scene_set_time(scene_, time, 0, &error_); });
  }
  void add_particles() {
    sideray_particles_desc desc = sideray_particles_defaults();
    desc.texture = random_.one_in(2) ? 0 : name_of(model_.textures);
    bool valid = desc.texture == 0 || model_.textures.contains(desc.texture);
    if (random_.one_in(4)) desc.columns = 0, valid = false;
    uint32_t name = 0;
    if (!make("add_particles", valid, [&] { return sideray_scene_add_particles(scene_, &desc, &name, &error_); }))
      return;
    model_.particles.push_back(name);
    if (desc.texture != 0) ++model_.textures[desc.texture];
  }
  void set_sprites() {
    const bool exists = !model_.particles.empty() && !random_.one_in(5);
    const uint32_t name = exists ? random_.of(model_.particles) : 1000;
    sideray_sprite sprite{{1, 2, 3}, 1, 1, 0, {1, 1, 1, 1}, 0};
    const bool broken = random_.one_in(4);
    if (broken) sprite.width = random_.pick({-1.0f, std::numeric_limits<float>::quiet_NaN()});
    const auto set = [&] { return sideray_scene_set_sprites(scene_, name, &sprite, sizeof(sprite), 1, &error_); };
    make("set_sprites", exists && !broken, set);
  }
  void set_lights() {
    sideray_light lights[2] = {sideray_light_defaults(), sideray_light_defaults()};
    const bool broken = random_.one_in(3);
    if (broken) lights[0].intensity[2] = random_.pick({-1.0f, std::numeric_limits<float>::quiet_NaN()});
    const uint32_t count = broken ? 2 : random_.below(3);
    make("set_lights", !broken, [&] { return sideray_scene_set_lights(scene_, lights, count, &error_); });
  }
  void set_environment() {
    const float texels[12] = {1, 2, 3, odd_float()};
    const bool broken = random_.one_in(3);
    const uint32_t width = broken ? 0 : 2;
    make("set_environment", !broken,
         [&] { return sideray_scene_set_environment(scene_, width, 2, texels, 1, 0, &error_); });
  }

  // Two translucent surfaces that rays find must not share an id.
  bool can_commit() const {
    std::set<uint32_t> ids;
    for (const auto& [name, instance] : model_.instances) {
      const bool layered = (instance.visibility & SIDERAY_VISIBLE_LAYERS) != 0;
      if (!layered || !model_.materials.at(instance.material).translucent || instance.surface_id == 0) continue;
      if (!ids.insert(instance.surface_id).second) return false;
    }
    return true;
  }
  void commit() {
    if (!make("commit", can_commit(), [&] { return sideray_scene_commit(scene_, &error_); })) return;
    model_.committed = model_.instances;
    model_.committed_meshes = model_.meshes;
    any_moves_ = false;
    for (const auto& [name, instance] : model_.instances) any_moves_ = any_moves_ || is_moving_[name];
  }

  // Checks bounds. Wind widens them, so that they are at least those without wind.
  void bounds() {
    double low[3], high[3], least[3] = {INFINITY, INFINITY, INFINITY}, most[3] = {-INFINITY, -INFINITY, -INFINITY};
    const sideray_status status = sideray_scene_bounds(scene_, low, high, &error_);
    if (!model_.committed || model_.committed->empty()) {
      if (status != SIDERAY_NOT_READY) fuzz::broken("an empty scene has no bounds", error_.message);
      return;
    }
    if (status != SIDERAY_OK) fuzz::broken("a scene with instances has bounds", error_.message);
    for (const auto& [name, instance] : *model_.committed) widen(instance, least, most);
    for (int c = 0; c < 3; ++c) {
      const double slack = 1e-3;
      const bool holds = low[c] <= least[c] + slack && high[c] >= most[c] - slack;
      const bool fits = low[c] >= least[c] - slack && high[c] <= most[c] + slack;
      if (!holds || !(fits || any_moves_))
        fuzz::broken("bounds are those of the instances",
                     std::to_string(low[c]) + " to " + std::to_string(high[c]) + " instead of " +
                         std::to_string(least[c]) + " to " + std::to_string(most[c]));
    }
  }
  void widen(const Instance& instance, double least[3], double most[3]) const {
    const Mesh& mesh = model_.committed_meshes.at(instance.mesh);
    for (int corner = 0; corner < 8; ++corner) {
      for (int r = 0; r < 3; ++r) {
        double at = instance.transform[9 + r];
        for (int c = 0; c < 3; ++c)
          at += instance.transform[3 * c + r] * ((corner >> c & 1) != 0 ? mesh.high[c] : mesh.low[c]);
        least[r] = std::min(least[r], at), most[r] = std::max(most[r], at);
      }
    }
  }

  fuzz::Random random_;
  sideray_scene* scene_ = nullptr;
  sideray_error error_{};
  Model model_;
  std::map<uint32_t, std::vector<uint32_t>> uses_;
  std::map<uint32_t, bool> is_moving_;
  uint32_t next_id_ = 10;
  bool any_moves_ = false;
};

}  // namespace

int main(int argc, char** argv) {
  const uint64_t first = argc > 1 ? std::strtoull(argv[1], nullptr, 0) : 1;
  const uint64_t count = argc > 2 ? std::strtoull(argv[2], nullptr, 0) : 1000;
  unsigned long long done = 0, calls = 0;
  fuzz::stop_at_signals();
  for (; done < count && fuzz::has_to_stop == 0; ++done) {
    fuzz::note("sequence", first + done);
    calls += Sequence(first + done).run();
  }
  std::printf("%llu sequences, %llu calls\n", done, calls);
  return 0;
}
