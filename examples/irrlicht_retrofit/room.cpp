#include "room.h"

#include <GL/gl.h>

#include <cmath>
#include <stdexcept>

using namespace irr;

namespace {

constexpr u32 banner_frames = 32;

// Returns a waving banner of 12 x 8 quads at one phase of its motion.
scene::SMesh* banner_at(f32 phase) {
  constexpr u16 columns = 13, rows = 9;
  auto* buffer = new scene::SMeshBuffer;
  for (u16 y = 0; y < rows; ++y)
    for (u16 x = 0; x < columns; ++x) {
      const f32 u = static_cast<f32>(x) / (columns - 1), v = static_cast<f32>(y) / (rows - 1);
      const f32 wave = 6.2831853f * (u * 1.5f - phase), slope = 0.12f * u * 6.2831853f * 1.5f / 2.0f * std::cos(wave);
      core::vector3df normal(slope, 0, -1);
      normal.normalize();
      buffer->Vertices.push_back(video::S3DVertex(core::vector3df(2.0f * u, 1.2f * v, 0.12f * u * std::sin(wave)), normal,
                                                  video::SColor(255, 150, 30, 40), core::vector2df(u, 1 - v)));
    }
  for (u16 y = 0; y + 1 < rows; ++y)
    for (u16 x = 0; x + 1 < columns; ++x) {
      const u16 a = static_cast<u16>(y * columns + x), b = static_cast<u16>(a + columns);
      for (const u16 i : {a, b, static_cast<u16>(b + 1), a, static_cast<u16>(b + 1), static_cast<u16>(a + 1)})
        buffer->Indices.push_back(i);
    }
  buffer->recalculateBoundingBox();
  auto* mesh = new scene::SMesh;
  mesh->addMeshBuffer(buffer);
  mesh->recalculateBoundingBox();
  buffer->drop();
  return mesh;
}

}  // namespace

Room::Room(unsigned width, unsigned height) {
  SIrrlichtCreationParameters parameters;
  parameters.DriverType = video::EDT_OPENGL;
  parameters.WindowSize = {width, height};
  parameters.Stencilbuffer = true;
  parameters.LoggingLevel = ELL_ERROR;
  device_ = createDeviceEx(parameters);
  if (!device_) throw std::runtime_error("Irrlicht: no window with OpenGL; is DISPLAY set?");
  scene().setAmbientLight(video::SColorf(0.25f, 0.25f, 0.3f));
  add_walls();
  add_lights();
  add_banner();
  add_glass();
  scene().addCameraSceneNode(nullptr, {0.4f, 1.7f, -3.6f}, {0.1f, 1.3f, 1.0f});
  set_time(0);
}

Room::~Room() {
  device_->drop();
}

video::ITexture* Room::checks(const char* name, video::SColor a, video::SColor b) const {
  video::IVideoDriver& driver = *device_->getVideoDriver();
  video::IImage* image = driver.createImage(video::ECF_A8R8G8B8, {64, 64});
  for (u32 y = 0; y < 64; ++y)
    for (u32 x = 0; x < 64; ++x) image->setPixel(x, y, ((x / 16) ^ (y / 16)) & 1 ? a : b);
  video::ITexture* texture = driver.addTexture(name, image);
  image->drop();
  return texture;
}

scene::ISceneNode* Room::add_box(core::vector3df size, core::vector3df place, video::ITexture* texture) const {
  scene::ISceneNode* node = scene().addCubeSceneNode(1.0f, nullptr, -1, place, {}, size);
  node->setMaterialFlag(video::EMF_NORMALIZE_NORMALS, true);
  node->setMaterialTexture(0, texture);
  return node;
}

// Adds the walls. The one behind the camera, and the objects on it, are visible in reflections alone.
void Room::add_walls() const {
  video::ITexture* floor = checks("floor", video::SColor(255, 190, 180, 160), video::SColor(255, 90, 80, 70));
  video::ITexture* wall = checks("wall", video::SColor(255, 170, 190, 170), video::SColor(255, 150, 170, 150));
  video::ITexture* red = checks("red", video::SColor(255, 220, 60, 40), video::SColor(255, 240, 200, 60));
  add_box({10, 0.2f, 10}, {0, -0.1f, 0}, floor);
  add_box({10, 5, 0.2f}, {0, 2.5f, 5}, wall);
  add_box({0.2f, 5, 10}, {-5, 2.5f, 0}, wall);
  add_box({0.2f, 5, 10}, {5, 2.5f, 0}, wall);
  add_box({10, 5, 0.2f}, {0, 2.5f, -5}, wall);
  add_box({3, 1.6f, 0.1f}, {0.4f, 2.0f, -4.8f}, red);
  add_box({0.5f, 1.4f, 0.5f}, {-1.6f, 0.7f, 2.6f}, red);
}

void Room::add_lights() const {
  scene::ILightSceneNode* lamp = scene().addLightSceneNode(nullptr, {1.5f, 4.2f, -1.5f}, {0.9f, 0.85f, 0.75f}, 6.0f);
  lamp->getLightData().AmbientColor = video::SColorf(0.1f, 0.1f, 0.1f);
  video::SLight& spot =
      scene().addLightSceneNode(nullptr, {-3, 4, 0}, video::SColorf(0.3f, 0.35f, 0.5f), 12.0f)->getLightData();
  spot.Type = video::ELT_SPOT;
  spot.OuterCone = 45, spot.InnerCone = 20, spot.Falloff = 4;
  spot.CastShadows = false;
  scene().getActiveCamera();
}

void Room::add_banner() {
  auto* waving = new scene::SAnimatedMesh;
  for (u32 i = 0; i < banner_frames; ++i) {
    scene::SMesh* frame = banner_at(static_cast<f32>(i) / banner_frames);
    waving->addMesh(frame);
    frame->drop();
  }
  waving->recalculateBoundingBox();
  banner_ = scene().addAnimatedMeshSceneNode(waving, nullptr, -1, {0.2f, 2.0f, 3.0f});
  waving->drop();
  banner_->setAnimationSpeed(0);
  banner_->setMaterialFlag(video::EMF_BACK_FACE_CULLING, false);
}

// Adds two panes, one behind the other, with smoke between them.
void Room::add_glass() const {
  const auto pane = [this](core::vector3df place, video::SColor tint) {
    scene::IMesh* mesh = scene().getGeometryCreator()->createCubeMesh({1, 1, 1});
    scene().getMeshManipulator()->setVertexColors(mesh, tint);
    scene::ISceneNode* node = scene().addMeshSceneNode(mesh, nullptr, -1, place, {}, {2.2f, 1.8f, 0.02f});
    mesh->drop();
    video::SMaterial& material = node->getMaterial(0);
    material.MaterialType = video::EMT_TRANSPARENT_VERTEX_ALPHA;
    material.NormalizeNormals = true;
    material.Shininess = 40;
  };
  pane({0.1f, 1.3f, 0.8f}, video::SColor(70, 60, 90, 100));
  pane({0.1f, 1.3f, -0.4f}, video::SColor(80, 70, 80, 60));
}

void Room::set_time(u32 ms) {
  banner_->setCurrentFrame(static_cast<f32>(ms / 30 % banner_frames));
  if (smoke_) return;
  smoke_ = scene().addBillboardSceneNode(nullptr, {0.8f, 0.8f}, {-0.4f, 1.2f, 0.2f});
  video::IImage* image = device_->getVideoDriver()->createImage(video::ECF_A8R8G8B8, {64, 64});
  for (u32 y = 0; y < 64; ++y)
    for (u32 x = 0; x < 64; ++x) {
      const f32 dx = (static_cast<f32>(x) - 31.5f) / 32, dy = (static_cast<f32>(y) - 31.5f) / 32;
      const f32 density = core::max_(0.0f, 1 - std::sqrt(dx * dx + dy * dy));
      image->setPixel(x, y, video::SColor(static_cast<u32>(200 * density), 220, 220, 220));
    }
  video::SMaterial& material = smoke_->getMaterial(0);
  material.setTexture(0, device_->getVideoDriver()->addTexture("smoke", image));
  image->drop();
  material.MaterialType = video::EMT_TRANSPARENT_ALPHA_CHANNEL;
  material.Lighting = false;
}

void Room::add_crate() {
  if (!crate_) crate_ = add_box({0.7f, 0.7f, 0.7f}, {1.3f, 0.35f, 2.2f}, device_->getVideoDriver()->getTexture("red"));
}

void Room::remove_crate() {
  if (crate_) crate_->remove();
  crate_ = nullptr;
}

void Room::turn_camera(float degrees) {
  core::vector3df place(0.4f, 1.7f, -3.6f);
  place.rotateXZBy(static_cast<f64>(degrees), {0, 0, 0});
  scene().getActiveCamera()->setPosition(place);
}

bool Room::draw(Picture* picture) {
  if (!device_->run()) return false;
  video::IVideoDriver& driver = *device_->getVideoDriver();
  driver.beginScene(true, true, video::SColor(255, 30, 30, 40));
  scene().drawAll();
  if (picture) {
    const core::dimension2du size = driver.getScreenSize();
    const size_t row = size_t{4} * size.Width;
    std::vector<unsigned char> from_below(row * size.Height);
    glReadPixels(0, 0, static_cast<GLsizei>(size.Width), static_cast<GLsizei>(size.Height), GL_BGRA, GL_UNSIGNED_BYTE,
                 from_below.data());
    *picture = {size.Width, size.Height, {}};
    for (size_t y = size.Height; y-- > 0;)
      picture->bgra.insert(picture->bgra.end(), &from_below[y * row], &from_below[y * row] + row);
  }
  driver.endScene();
  return true;
}

void Room::save(const Picture& picture, const std::string& file) const {
  video::IVideoDriver& driver = *device_->getVideoDriver();
  std::vector<unsigned char> opaque = picture.bgra;
  for (size_t i = 3; i < opaque.size(); i += 4) opaque[i] = 255;
  video::IImage* image = driver.createImageFromData(video::ECF_A8R8G8B8, {picture.width, picture.height}, opaque.data());
  driver.writeImageToFile(image, file.c_str());
  image->drop();
}
