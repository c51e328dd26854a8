#include "engine.h"

#include <osgDB/ReadFile>
#include <osgGA/TrackballManipulator>
#include <osgViewer/ViewerEventHandlers>

#include <stdexcept>

namespace {

osg::ref_ptr<osg::GraphicsContext> open_window(int width, int height) {
  osg::ref_ptr<osg::GraphicsContext::Traits> traits = new osg::GraphicsContext::Traits;
  traits->readDISPLAY();
  if (traits->displayNum < 0) traits->displayNum = 0;
  traits->x = traits->y = 60;
  traits->width = width;
  traits->height = height;
  traits->depth = 24;
  traits->stencil = 8;
  traits->doubleBuffer = true;
  traits->windowDecoration = true;
  traits->windowName = "osg_retrofit";
  return osg::GraphicsContext::createGraphicsContext(traits);
}

}  // namespace

// Waits for the picture, so that times are those of whole frames, and copies it if asked to.
class Engine::Finish : public osg::Camera::DrawCallback {
 public:
  void operator()(osg::RenderInfo& info) const override {
    const osg::Viewport& v = *info.getCurrentCamera()->getViewport();
    if (keep)
      image->readPixels(0, 0, static_cast<int>(v.width()), static_cast<int>(v.height()), GL_RGB, GL_UNSIGNED_BYTE);
    glFinish();
    if (renderer.empty()) renderer = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  }
  bool keep = false;
  osg::ref_ptr<osg::Image> image = new osg::Image;
  mutable std::string renderer;
};

Engine::Engine(const EngineSettings& settings) : width_(settings.width), height_(settings.height) {
  viewer_ = new osgViewer::Viewer;
  viewer_->setThreadingModel(osgViewer::ViewerBase::SingleThreaded);
  // OpenSceneGraph would pin the drawing thread to one core. Threads that a pinned thread starts, such as those of a
  // software driver, are pinned too.
  viewer_->setUseConfigureAffinity(false);
  osg::Camera& camera = *viewer_->getCamera();
  if (settings.context == "window") {
    const osg::ref_ptr<osg::GraphicsContext> window = open_window(width_, height_);
    if (!window) throw std::runtime_error("no window: is DISPLAY set, and does the X server know OpenGL?");
    camera.setGraphicsContext(window);
    camera.setViewport(new osg::Viewport(0, 0, width_, height_));
    camera.setDrawBuffer(GL_BACK);
    camera.setReadBuffer(GL_BACK);
  } else {
    offscreen_ = std::make_unique<Offscreen>(settings.context, width_, height_, settings.debug);
    viewer_->setUpViewerAsEmbeddedInWindow(0, 0, width_, height_);
  }
  camera.setClearColor({0.6f, 0.7f, 0.8f, 1});
  scene_ = dynamic_cast<osg::Group*>(osgDB::readRefNodeFile(settings.scene).release());
  if (!scene_)
    throw std::runtime_error(settings.scene + ": OpenSceneGraph cannot read it; write it with retrofit_scene");
  viewer_->setSceneData(scene_);
  viewer_->setLightingMode(osg::View::NO_LIGHT);  // the scene brings its own
  finish_ = new Finish;
  camera.setFinalDrawCallback(finish_);
  viewer_->realize();
}

Engine::~Engine() = default;

void Engine::look(const osg::Vec3d& eye, const osg::Vec3d& target, double fov_deg) {
  osg::Camera& camera = *viewer_->getCamera();
  camera.setViewMatrixAsLookAt(eye, target, {0, 1, 0});
  camera.setProjectionMatrixAsPerspective(fov_deg, static_cast<double>(width_) / height_, 0.1, 200.0);
}

void Engine::update(double time_s) {
  viewer_->advance(time_s);
  viewer_->eventTraversal();
  viewer_->updateTraversal();
}

void Engine::draw() {
  viewer_->renderingTraversals();
}

void Engine::keep_picture(bool keep) {
  finish_->keep = keep;
}

const osg::Image& Engine::picture() const {
  return *finish_->image;
}

std::string Engine::renderer() const {
  return finish_->renderer;
}
